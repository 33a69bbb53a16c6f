#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "tests/model/random_mechanism.hpp"

/// Random loops on random trees, and their displacements.
namespace axode::test {

/// A random loop of a kind between two bodies or frames. Its geometry is drawn or given by frames, and some
/// entries that may be left out are left out.
inline LoopDescription random_loop(Random<double>& random, LoopKind kind,
                                   const std::array<std::string, 2>& between) {
  const auto chance = [&](double p) { return random.number(0, 1) < p; };
  LoopDescription loop{.between = between, .kind = kind};
  if (chance(0.6)) loop.name = std::string(to_string(kind)) + " of " + between[0] + " and " + between[1];
  loop.axis = random.number(0.1, 10) * random.direction();
  loop.second_axis = random.direction();
  loop.point = random.vector();
  for (Vec3<>& point : loop.points) point = random.vector();
  loop.center = random.vector();
  if (traits(kind).has("pitch")) loop.pitch = random.number(0.1, 0.5);
  if (traits(kind).has("wheel_axis") && chance(0.5)) loop.wheel_axis = random.direction();
  const bool with_frames = chance(0.4);
  if (with_frames) loop.frames = {random.pose(), random.pose()};
  // The frames of two bodies may be parallel in all configurations, so that a wheel would lie flat.
  if (with_frames && chance(0.3) && !loop.wheel_axis) loop.frames.emplace();
  const bool sized = with_frames || chance(0.3);
  if (traits(kind).has("length") && sized) loop.length = random.number(0.1, 2);
  if (traits(kind).has("radius") && sized) loop.radius = random.number(0.1, 2);
  if (traits(kind).has("radii")) loop.radii = {0.3, 0.301};  // a span exists unless the axes nearly coincide
  if (traits(kind).has("angle") && chance(0.5)) loop.angle = random.number(0.3, 2.8);
  return loop;
}

/// The same tree with loops of all kinds between bodies and frames that can move relative to each other, with
/// couplings and passive joints. Every body gets a mass, because loops may be cut only at bodies that have
/// one. A tree that cannot move gets no loops.
inline Description with_loops(Description tree, Random<double>& random) {
  for (BodyDescription& body : tree.bodies) {
    const MassProperties matter = mass_properties(random.inertia());
    if (!body.inertia) body.inertia = matter;
    body.joint.passive = body.joint.kind != JointKind::fixed && random.number(0, 1) < 0.3;
  }
  const Model bare = ModelBuilder(tree).build();
  const auto frame = [&]() -> const Frame& {
    return bare.frame(static_cast<int>(random.number(0, bare.n_frames())));
  };
  for (const LoopTraits& kind : loop_kinds) {
    const Frame &one = frame(), &other = frame();
    if (one.body != other.body) tree.loops.push_back(random_loop(random, kind.kind, {one.name, other.name}));
  }
  for (int k = 0; k < 2; ++k) {
    CouplingDescription coupling{.name = k == 0 ? "gear" : "", .offset = random.number(-1, 1)};
    for (const Joint& joint : bare.joints())
      if (joint.dof.size() == 1 && random.number(0, 1) < 0.4)
        coupling.terms.emplace_back(joint.name, random.number(0.1, 2));
    if (!coupling.terms.empty()) tree.couplings.push_back(std::move(coupling));
  }
  return tree;
}

/// The residual of a coupling; it is 0 if the coupling is closed.
inline double residual(const LoopCoupling& coupling, const std::vector<double>& q) {
  double sum = -coupling.offset;
  for (const LoopCoupling::Term& term : coupling.terms)
    sum += term.factor * q[static_cast<std::size_t>(term.coordinate)];
  return sum;
}
/// The pose of the second frame of a loop in its first frame, from the poses of all frames of the model.
inline SE3<> displacement(const Model& model, const Loop& loop, const std::vector<SE3<>>& C) {
  const auto end = [&](const Loop::End& at) {
    return C[static_cast<std::size_t>(at.body)] * model.body(at.body).S_self * at.F;
  };
  return inverse(end(loop.ends[0])) * end(loop.ends[1]);
}

/// Expects every loop of a part in the whole mechanism too, where its name has a prefix, with the same
/// displacement or residual.
inline void expect_same_loops(const Model& part, const std::vector<double>& q_part, const Model& whole,
                              const std::vector<double>& q_whole, const std::string& prefix = "") {
  const std::vector<SE3<>> C_part = poses_of(part, q_part), C_whole = poses_of(whole, q_whole);
  for (const Loop& loop : part.loops().joints) {
    SCOPED_TRACE(loop.name);
    const auto found = std::ranges::find(whole.loops().joints, prefix + loop.name, &Loop::name);
    ASSERT_NE(found, whole.loops().joints.end());
    EXPECT_EQ(found->kind, loop.kind);
    EXPECT_EQ(found->pitch, loop.pitch);
    EXPECT_EQ(found->wheel, loop.wheel);
    EXPECT_NEAR(found->size, loop.size, 1e-14);
    EXPECT_EQ(found->radii, loop.radii);
    EXPECT_LE(distance(displacement(whole, *found, C_whole), displacement(part, loop, C_part)), 1e-10);
  }
  for (const LoopCoupling& coupling : part.loops().couplings) {
    SCOPED_TRACE(coupling.name);
    const auto found =
        std::ranges::find(whole.loops().couplings, prefix + coupling.name, &LoopCoupling::name);
    ASSERT_NE(found, whole.loops().couplings.end());
    EXPECT_NEAR(residual(*found, q_whole), residual(coupling, q_part), 1e-11);
  }
}

}  // namespace axode::test
