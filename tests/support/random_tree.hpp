#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "axode/model.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/recursion/loads.hpp"
#include "tests/lie/random_quantities.hpp"

/// Random mechanisms. One is first drawn, with everything in the construction frame, and then told to the
/// library in a random mix of all the ways in which it may be told.
namespace axode::test {

/// A body at q = 0; poses, points and tensors in the construction frame.
struct DrawnBody {
  struct Matter {
    double mass;
    Vec3<> com;
    Sym3<> Theta_c;  ///< about the centre of mass
  };

  std::string name, joint;
  int predecessor = -1;  ///< index of a body, -1 for the ground
  JointKind kind = JointKind::fixed;
  SE3<> A;               ///< the body frame
  SE3<> J;               ///< the joint frame; its z-axis is the axis of the joint (a free joint's is A)
  Vec3<> second_axis{};  ///< of a universal joint
  double pitch = 0;
  std::vector<Dof> dof = {};
  std::optional<Coupling> coupling = {};
  std::optional<Matter> matter = {};
};

struct DrawnFrame {
  std::string name;
  int body = -1;
  SE3<> pose;
};

struct Mechanism {
  Vec3<> gravity;
  std::vector<DrawnBody> bodies;
  std::vector<DrawnFrame> frames = {};

  SE3<> A(int i) const { return i < 0 ? SE3<>{} : bodies[static_cast<std::size_t>(i)].A; }
  std::string name(int i) const { return i < 0 ? "ground" : bodies[static_cast<std::size_t>(i)].name; }
};

/// What random trees are made of.
struct TreeRecipe {
  int most_bodies = 60;   ///< that move
  double length = 0.3;    ///< of bodies, m
  bool composite = true;  ///< cylindrical and universal joints
  bool couplings = true;
  bool always_mass = false;  ///< every body has a mass
  bool one_free_root = false;
  double springs =
      0.5;  ///< the part of told mechanisms with springs and stops on joints and springs between frames
  bool friction = false;  ///< damping and Coulomb friction on every joint, and not only on some
  double far = 0;         ///< how far the mechanism is from the origin, m
};

bool has_one_velocity(JointKind kind);

/// Draws a mechanism with all kinds of joints, several roots, massless bodies, frames and drives.
Mechanism random_mechanism(Random<double>& random, const TreeRecipe& recipe = {});

/// The whole scene, ground and gravity included, displaced by D.
Mechanism displaced(const SE3<>& D, Mechanism mechanism);

/// The three ways in which the geometry of a body may be given.
enum class Way { construction_frame, body_frame, joint_frames };

/// The geometry of a body, told in one way, with an axis of any length and any of its points.
BodyDescription told(const Mechanism& mechanism, const DrawnBody& body, Way way, Random<double>& random);
/// Tells a mechanism: every body in a way of its own.
Description told(const Mechanism& mechanism, Random<double>& random);

/// The same with springs and stops on its joints, of every kind, and springs between its bodies and frames; without losses
/// they keep their energy.
Description with_springs(Description tree, Random<double>& random, bool losses = true);

/// A mechanism that is drawn and told, some of them with springs.
Description random_description(Random<double>& random, const TreeRecipe& recipe = {});

/// While it lives no random mechanism of this thread has more moving bodies. What the first ones are like does not depend
/// on how many there are.
class AtMostBodies {
 public:
  explicit AtMostBodies(int bodies);
  ~AtMostBodies();
  AtMostBodies(const AtMostBodies&) = delete;
  AtMostBodies& operator=(const AtMostBodies&) = delete;

 private:
  int before_;
};
/// How many moving bodies the last random mechanism of this thread was to have.
int last_number_of_bodies();
/// As what it was told, with what was added to that.
const Description& last_description();
void set_last_description(const Description& description);

/// The poses of all frames.
std::vector<SE3<>> poses_of(const Model& model, const std::vector<double>& q);

/// A state of a model and what acts on it.
template <class T> struct State {
  std::vector<T> q, v, a;
  std::vector<AppliedWrench<T>> wrenches = {};

  Loads<T> loads() const { return {.wrenches = wrenches}; }
};

template <class To, class From> std::vector<To> cast(const std::vector<From>& numbers) {
  std::vector<To> out;
  out.reserve(numbers.size());
  for (const From& x : numbers) out.push_back(static_cast<To>(x));
  return out;
}

template <class To, class From> State<To> cast(const State<From>& state) {
  State<To> out{cast<To>(state.q), cast<To>(state.v), cast<To>(state.a)};
  for (const AppliedWrench<From>& W : state.wrenches)
    out.wrenches.emplace_back(W.frame, W.representation, axode::cast<To>(W.m), axode::cast<To>(W.f));
  return out;
}

/// n numbers in [-size, size].
std::vector<double> random_numbers(Random<double>& random, int n, double size = 1);

/// Any configuration, velocities and accelerations of order one, up to four loads on any frames in any
/// representations.
State<double> random_state(const Model& model, Random<double>& random);

}  // namespace axode::test
