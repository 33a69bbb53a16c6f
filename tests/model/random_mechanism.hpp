#pragma once
#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "axode/model.hpp"
#include "tests/lie/random_quantities.hpp"
#include "tests/lie/relative_error.hpp"
#include "tests/support/kinds.hpp"
#include "tests/support/random_tree.hpp"

/// Random mechanisms that are drawn in the construction frame, and the same mechanisms described in the two
/// other ways.
namespace axode::test {

inline const std::vector<JointKind> one_dof_kinds =
    kinds_that([](const JointTraits& it) { return it.dof == 1; });
inline const std::vector<JointKind> multi_dof_kinds =
    kinds_that([](const JointTraits& it) { return it.dof > 1 && !it.chain; });

/// The name of a body, frame or joint: a letter and a number, such as b3, j3 or f3.
inline std::string numbered(char letter, int i) { return letter + std::to_string(i); }

/// Mass properties about the centre of mass, expressed in the body frame.
inline MassProperties mass_properties(const Inertia<>& M) {
  return {.mass = M.m, .com = center_of_mass(M), .Theta = inertia_about_com(M)};
}

/// A random body that is drawn in the construction frame, with a joint of this kind.
inline BodyDescription random_body(Random<double>& random, int number, std::string predecessor,
                                   JointKind kind) {
  return {.name = numbered('b', number),
          .predecessor = std::move(predecessor),
          .joint = {.name = numbered('j', number),
                    .kind = kind,
                    .axis = random.number(0.1, 10) * random.direction(),
                    .second_axis = random.direction(),
                    .point = random.vector(),
                    .pitch = traits(kind).has("pitch") ? random.number(-0.3, 0.3) : 0},
          .geometry = InConstructionFrame{random.pose()},
          .inertia = mass_properties(random.inertia())};
}

/// A random tree with several bodies joined to the ground. Each body is on an earlier one or on the ground,
/// and its joint has one of these kinds.
template <class Kinds> Description random_tree(Random<double>& random, int n, const Kinds& kinds) {
  Description tree{.name = "random tree", .gravity = random.vector(10)};
  for (int i = 0; i < n; ++i) {
    const auto kind = kinds[static_cast<std::size_t>(random.number(0, static_cast<double>(kinds.size())))];
    const int p = static_cast<int>(random.number(0, i));
    const bool is_root = i == 0 || random.number(0, 1) < 0.1;
    tree.bodies.push_back(random_body(random, i, is_root ? "ground" : numbered('b', p), kind));
  }
  return tree;
}

/// Changes a body that is drawn in the construction frame into another way to give its geometry. The third
/// way uses the joint frame J.
inline BodyDescription described(BodyDescription body, Way way, const SE3<>& A_predecessor, const SE3<>& J) {
  const SE3<> A = std::get<InConstructionFrame>(body.geometry).A;
  SE3<> frame;  // the frame in which axis and point are given
  if (way == Way::body_frame) {
    frame = A;
    body.geometry = InBodyFrame{inverse(A_predecessor) * A};
  } else if (way == Way::joint_frames) {
    frame = J;
    body.geometry = InJointFrames{inverse(A_predecessor) * J, inverse(A) * J};
  }
  body.joint.axis = transpose(frame.R) * body.joint.axis;
  body.joint.second_axis = transpose(frame.R) * body.joint.second_axis;
  body.joint.point = inverse(frame) * body.joint.point;
  return body;
}

/// The reference pose of a body frame of a drawn tree.
inline SE3<> reference_pose(const Description& drawn, const std::string& name) {
  const auto body = std::ranges::find(drawn.bodies, name, &BodyDescription::name);
  return body == drawn.bodies.end() ? SE3<>{} : std::get<InConstructionFrame>(body->geometry).A;
}

/// A drawn tree in which the geometry of body i is given in the way way_of(i), with random joint frames.
template <class WayOf> Description described(const Description& drawn, Random<double>& random, WayOf way_of) {
  Description tree = drawn;
  for (std::size_t i = 0; i < tree.bodies.size(); ++i)
    tree.bodies[i] = described(drawn.bodies[i], way_of(i), reference_pose(drawn, drawn.bodies[i].predecessor),
                               random.pose());
  return tree;
}

/// The largest absolute value in a list of numbers.
inline double size(const std::vector<double>& x) {
  double largest = 0;
  for (const double value : x) largest = std::max(largest, std::abs(value));
  return largest;
}

/// The largest difference between two lists of numbers.
inline double distance(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double largest = 0;
  for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, std::abs(a[k] - b[k]));
  return largest;
}

}  // namespace axode::test
