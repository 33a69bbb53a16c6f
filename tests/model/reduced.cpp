#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "axode/dynamics.hpp"
#include "tests/model/random_loops.hpp"
#include "tests/model/random_mechanism.hpp"

/// Locked joints: the reduced model has the motion, the masses and the loads of the full model with those
/// joints at rest.
namespace axode::test {
namespace {

using testing::ElementsAre;
using testing::ThrowsMessage;
using testing::UnorderedElementsAreArray;

struct Motion {
  std::vector<double> q, v, a;
};

template <class Has> std::vector<std::string> names_of(const Has& things) {
  std::vector<std::string> names;
  for (const auto& thing : things) names.push_back(thing.name);
  return names;
}

/// The motion of the full model in which the joints that the reduced model has not stay at rest at q.
Motion in_full(const Model& full, const std::vector<double>& q, const Model& less, const Motion& motion) {
  Motion out{q, std::vector<double>(full.nv()), std::vector<double>(full.nv())};
  for (const Joint& from : less.joints()) {
    const Joint& to = full.joint(full.joint_index(from.name));
    std::copy_n(motion.q.begin() + from.iq, from.nq, out.q.begin() + to.iq);
    std::copy_n(motion.v.begin() + from.iv, from.nv, out.v.begin() + to.iv);
    std::copy_n(motion.a.begin() + from.iv, from.nv, out.a.begin() + to.iv);
  }
  return out;
}

/// Expects the same poses and twists of every frame and the same forces of every remaining joint, in motion
/// and at rest.
void expect_same_mechanics(const Model& full, const std::vector<double>& q, const Model& less,
                           std::uint64_t seed) {
  Random<double> random(seed);
  EXPECT_THAT(names_of(less.frames()), UnorderedElementsAreArray(names_of(full.frames())))
      << "every frame stays";
  for (const double speed : {0.0, 1.0}) {
    const Motion motion{random_configuration(less, seed), random_numbers(random, less.nv(), speed),
                        random_numbers(random, less.nv(), speed)};
    const Motion all = in_full(full, q, less, motion);
    Workspace<double> workspace(full);
    std::vector<SE3<>> C(full.n_frames()), C_less(less.n_frames());
    std::vector<Twist<BodyFixed>> V(full.n_frames()), V_less(less.n_frames());
    std::vector<double> tau(full.nv()), tau_less(less.nv());
    poses(full, workspace, all.q, C);
    poses(less, workspace, motion.q, C_less);
    twists<BodyFixed>(full, workspace, all.q, all.v, V);
    twists<BodyFixed>(less, workspace, motion.q, motion.v, V_less);
    for (const Frame& frame : full.frames()) {
      const int f = full.frame_index(frame.name), g = less.frame_index(frame.name);
      EXPECT_LE(distance(C[f], C_less[g]), 1e-11) << frame.name;
      EXPECT_LE(distance(V[f], V_less[g]), 1e-11 * (1 + to_eigen(V[f]).norm())) << frame.name;
    }
    inverse_dynamics(full, workspace, all.q, all.v, all.a, tau, {.joint_losses = true});
    inverse_dynamics(less, workspace, motion.q, motion.v, motion.a, tau_less, {.joint_losses = true});
    for (const Joint& joint : less.joints()) {
      const int k = full.joint(full.joint_index(joint.name)).iv;
      for (int d = 0; d < joint.nv; ++d)
        EXPECT_NEAR(tau[k + d], tau_less[joint.iv + d], 1e-11 * (1 + size(tau))) << joint.name;
    }
  }
}

Description tree_with_everything(Random<double>& random) {
  Description tree = random_tree(random, 10, all_kinds);
  tree.bodies.push_back(random_body(random, 10, "b3", JointKind::helical));
  tree.bodies.push_back(random_body(random, 11, "b10", JointKind::revolute));
  tree.bodies[11].joint.coupling = Coupling{"j10", -1.5, 0.2};
  Description described_in_mixed_ways = described(tree, random, [&](auto) {
    return std::array{Way::construction_frame, Way::body_frame,
                      Way::joint_frames}[static_cast<std::size_t>(random.number(0, 3))];
  });
  for (BodyDescription& body : described_in_mixed_ways.bodies) {
    if (random.number(0, 1) < 0.3) {
      body.inertia->in = GivenIn::construction_frame;
      body.inertia->com = random.vector();
    }
    if (body.joint.kind == JointKind::prismatic || body.joint.kind == JointKind::revolute)
      body.joint.dof = {{.lower = -2, .upper = 3, .damping = 0.1, .friction = 0.2, .armature = 0.3}};
  }
  for (int k = 0; k < 4; ++k)
    described_in_mixed_ways.frames.push_back(
        {.name = numbered('f', k),
         .body = k == 0 ? "ground" : numbered('b', 3 * k),
         .pose = random.pose(),
         .in = k % 2 ? GivenIn::body_frame : GivenIn::construction_frame});
  return described_in_mixed_ways;
}

TEST(Reduced, TheRestMovesAndLoadsAsBefore) {
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    Random<double> random(seed);
    const Model full = ModelBuilder(tree_with_everything(random)).build();
    const std::vector<double> q = random_configuration(full, seed);
    std::vector<std::string_view> locked;
    for (const Joint& joint : full.joints())
      if (!joint.leader && random.number(0, 1) < 0.4) locked.push_back(joint.name);
    const Model less = reduced(full, locked, q);
    EXPECT_LE(less.n_bodies(), full.n_bodies() - static_cast<int>(locked.size()));
    expect_same_mechanics(full, q, less, seed);
  }
}

/// Whether the reduced model has no joint left that changes this coupling or loop.
bool is_still(const LoopCoupling& coupling, const Model& full, const Model& less) {
  return std::ranges::none_of(coupling.terms, [&](const LoopCoupling::Term& term) {
    return std::ranges::any_of(less.joints(), [&](const Joint& joint) {
      return full.joint(full.joint_index(joint.name)).iq == term.coordinate;
    });
  });
}
bool is_still(const Loop& loop, const Model& full, const Model& less) {
  const auto carrier = [&](const Loop::End& end) {
    return less.frame(less.frame_index(full.body(end.body).name)).body;
  };
  return carrier(loop.ends[0]) == carrier(loop.ends[1]);
}

TEST(Reduced, LoopsAreClosedAsBeforeAndThoseThatStandStillAreLeftOut) {
  int kept = 0, left_out = 0;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    SCOPED_TRACE(seed);
    Random<double> random(seed);
    const Model full = ModelBuilder(with_loops(tree_with_everything(random), random)).build();
    const std::vector<double> q = random_configuration(full, seed);
    std::vector<std::string_view> locked;
    for (const Joint& joint : full.joints())
      if (!joint.leader && random.number(0, 1) < 0.5) locked.push_back(joint.name);
    const Model less = reduced(full, locked, q);
    const std::vector<double> q_less = random_configuration(less, seed), at_rest(less.nv());
    expect_same_loops(less, q_less, full, in_full(full, q, less, {q_less, at_rest, at_rest}).q);
    const auto check = [&](const auto& loop) {
      const bool is_kept = std::ranges::count(less.loops().all, loop.name, &LoopRows::name) == 1;
      EXPECT_NE(is_kept, is_still(loop, full, less)) << loop.name;
      ++(is_kept ? kept : left_out);
    };
    std::ranges::for_each(full.loops().joints, check);
    std::ranges::for_each(full.loops().couplings, check);
  }
  EXPECT_GT(kept, 500);
  EXPECT_GT(left_out, 100);
}

/// Springs of a reduced mechanism have the force of the whole one: terms of locked joints are part of the
/// rest, and a preload, which is the tension as drawn, becomes a rest.
TEST(Reduced, SpringsKeepTheirForces) {
  Random<double> random(5);
  Description d;
  d.bodies = {random_body(random, 0, "ground", JointKind::revolute),
              random_body(random, 1, "b0", JointKind::revolute)};
  const std::string moving = joint_name(d.bodies[0]), still = joint_name(d.bodies[1]);
  SpringDescription sum{.kind = SpringKind::joints, .stiffness = 7, .rest = 0.3};
  sum.terms = {{moving, 2.0}, {still, -1.0}};
  d.springs.push_back(sum);
  sum.terms = {{still, 1.0}};
  d.springs.push_back(sum);
  for (const double preload : {1.0, 1e4}) {  // the rest of the second one is negative
    SpringDescription line{
        .between = {"ground", "b1"}, .points = {Vec3<>{1, 2, 3}, Vec3<>{}}, .stiffness = 50};
    line.preload = preload;
    d.springs.push_back(line);
    line.curve = TableCurve{{-1, 0, 1000}, {-3, 0, 20000}};
    d.springs.push_back(line);
    line.curve = LinearCurve{50};
    d.springs.push_back(line);
    line.curve = PolynomialCurve{{0, 30, 0, 1e-3}};
    d.springs.push_back(line);
    line.acts = Acts::in_tension;
    d.springs.push_back(line);
    line.damping = 5;
    d.springs.push_back(line);
  }
  const Model full = ModelBuilder(d).build();
  std::vector<double> q(2);
  q[static_cast<std::size_t>(full.joint(full.joint_index(still)).iq)] = 0.4;
  const std::string_view locked[] = {still};
  const Model less = reduced(full, locked, q);
  const auto& before = full.springs().elements;
  const auto& after = less.springs().elements;
  ASSERT_EQ(after.size(), before.size() - 1);
  EXPECT_NEAR(tension(after[0].law, 2 * 0.7, 0.0).f, tension(before[0].law, 2 * 0.7 - 0.4, 0.0).f, 1e-14);
  for (std::size_t k = 2; k < before.size(); ++k)
    for (const double x : {0.1, 2.0, 9.0})
      for (const double dx : {0.0, -1e3, -1e6}) {
        const double F = tension(before[k].law, x, dx).f;
        EXPECT_NEAR(tension(after[k - 1].law, x, dx).f, F, 1e-12 * std::abs(F)) << before[k].name;
      }
}

TEST(Reduced, OneJointOfEveryKindCanBeLocked) {
  for (const JointKind kind : all_kinds) {
    if (kind == JointKind::fixed) continue;
    Random<double> random(71);
    Description tree;
    tree.bodies = {random_body(random, 0, "ground", JointKind::revolute), random_body(random, 1, "b0", kind),
                   random_body(random, 2, "b1", JointKind::prismatic)};
    const Model full = ModelBuilder(tree).build();
    const std::vector<double> q = random_configuration(full, 9);
    for (const Joint& joint : full.joints()) {
      const std::string_view locked[] = {joint.name};
      const Model less = reduced(full, locked, q);
      EXPECT_EQ(less.n_bodies(), full.n_bodies() - 1);
      EXPECT_EQ(less.nv(), full.nv() - joint.nv);
      expect_same_mechanics(full, q, less, 1);
    }
  }
}

TEST(Reduced, HalfOfACylindricalJointMayStay) {
  const Model full = ModelBuilder()
                         .add({.name = "rod",
                               .joint = {.name = "guide", .kind = JointKind::cylindrical},
                               .inertia = MassProperties{.mass = 2}})
                         .build();
  const std::string_view translation[] = {"guide.translation"}, rotation[] = {"guide.rotation"};
  const std::vector<double> q{0.3, 0.5};
  const Model turning = reduced(full, translation, q), sliding = reduced(full, rotation, q);
  EXPECT_THAT(names_of(turning.joints()), ElementsAre("guide.rotation"));
  EXPECT_THAT(names_of(sliding.joints()), ElementsAre("guide.translation"));
  EXPECT_EQ(turning.total_mass(), 2);
  EXPECT_EQ(turning.frame(turning.frame_index("rod")).body, 1);
  expect_same_mechanics(full, q, turning, 1);
  expect_same_mechanics(full, q, sliding, 1);
}

TEST(Reduced, WhoFollowsALockedJointIsLockedWithIt) {
  Random<double> random(72);
  Description tree = random_tree(random, 6, one_dof_kinds);
  tree.bodies[3].joint.coupling = Coupling{"j1", 2, 0.1};
  tree.bodies[5].joint.coupling = Coupling{"j3", -1, 0.4};
  const Model full = ModelBuilder(tree).build();
  const std::vector<double> q = random_configuration(full, 3);
  const std::string_view leader[] = {"j1"}, other[] = {"j0"};
  const Model less = reduced(full, leader, q), led = reduced(full, other, q);
  EXPECT_THAT(names_of(less.joints()), testing::UnorderedElementsAre("j0", "j2", "j4"));
  EXPECT_EQ(less.nq(), 3);
  expect_same_mechanics(full, q, less, 1);
  EXPECT_EQ(led.nq(), 3);
  EXPECT_EQ(led.n_bodies(), 5) << "couplings of the others stay";
  EXPECT_DOUBLE_EQ(led.joint(led.joint_index("j5")).leader->ratio, -2);
  expect_same_mechanics(full, q, led, 2);
}

TEST(Reduced, AFreeBaseCanBeLockedWhereItIs) {
  Random<double> random(73);
  Description robot;
  robot.bodies = {random_body(random, 0, "ground", JointKind::fixed),
                  random_body(random, 1, "b0", JointKind::spherical),
                  random_body(random, 2, "b1", JointKind::revolute)};
  const Model full = ModelBuilder(with_free_base(robot)).build();
  const std::vector<double> q = random_configuration(full, 4);
  const std::string_view base[] = {"free_base"}, ball[] = {"j1"}, both[] = {"free_base", "j1"};
  for (const auto locked : {std::span<const std::string_view>(base), std::span<const std::string_view>(ball),
                            std::span<const std::string_view>(both)})
    expect_same_mechanics(full, q, reduced(full, locked, q), 1);
  EXPECT_EQ(reduced(full, both, q).nq(), 1);
}

TEST(Reduced, NothingLockedIsTheSameModel) {
  Random<double> random(74);
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    const Model full = ModelBuilder(tree_with_everything(random)).build();
    const Model same = reduced(full, {}, random_configuration(full, seed));
    EXPECT_EQ(names_of(same.joints()), names_of(full.joints()));
    EXPECT_EQ(names_of(same.frames()), names_of(full.frames()));
    EXPECT_EQ(limits(same).lower, limits(full).lower);
    for (int i = 0; i <= full.n_bodies(); ++i) {
      EXPECT_LE(distance(same.tree<double>().B[i], full.tree<double>().B[i]), 1e-12);
      EXPECT_LE(distance(same.tree<double>().M[i], full.tree<double>().M[i]), 1e-11);
    }
    EXPECT_EQ(same.tree<double>().armature, full.tree<double>().armature);
  }
}

TEST(Reduced, EverythingLockedStandsStill) {
  Random<double> random(75);
  const Model full = ModelBuilder(tree_with_everything(random)).build();
  std::vector<std::string_view> all;
  for (const Joint& joint : full.joints())
    if (!joint.leader) all.push_back(joint.name);
  const std::vector<double> q = random_configuration(full, 5);
  const Model still = reduced(full, all, q);
  EXPECT_EQ(still.n_bodies(), 0);
  EXPECT_EQ(still.n_frames(), full.n_frames());
  EXPECT_NEAR(still.body(0).M.m, full.total_mass() + full.body(0).M.m, 1e-12);
  expect_same_mechanics(full, q, still, 1);
}

TEST(Reduced, LockingInStepsIsLockingAtOnce) {
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    Random<double> random(seed);
    const Model full = ModelBuilder(random_tree(random, 6, multi_dof_kinds)).build();
    const std::vector<double> q = random_configuration(full, seed);
    const std::string_view two[] = {"j1", "j4"}, first[] = {"j1"}, second[] = {"j4"};
    const Model at_once = reduced(full, two, q), once = reduced(full, first, q);
    std::vector<double> q_once;
    for (const Joint& joint : once.joints()) {
      const Joint& from = full.joint(full.joint_index(joint.name));
      q_once.insert(q_once.end(), q.begin() + from.iq, q.begin() + from.iq + from.nq);
    }
    const Model twice = reduced(once, second, q_once);
    EXPECT_EQ(names_of(twice.joints()), names_of(at_once.joints()));
    for (int i = 0; i <= twice.n_bodies(); ++i) {
      EXPECT_LE(distance(twice.tree<double>().B[i], at_once.tree<double>().B[i]), 1e-12);
      EXPECT_LE(distance(twice.tree<double>().M[i], at_once.tree<double>().M[i]), 1e-11);
    }
  }
}

TEST(Reduced, TheFullModelStaysAndTheReducedOneCanBeEdited) {
  Random<double> random(76);
  const Model full = ModelBuilder(random_tree(random, 5, one_dof_kinds)).build();
  const std::string_view locked[] = {"j2"};
  const Model less = reduced(full, locked, random_configuration(full, 1));
  EXPECT_EQ(full.n_bodies(), 5);
  ModelBuilder builder(less);
  builder.body("b2").inertia->mass += 3;
  EXPECT_NEAR(builder.build().total_mass(), full.total_mass() + 3, 1e-12);
  EXPECT_EQ(less.gravity().x, full.gravity().x);
}

TEST(Reduced, WhatCannotBeLockedIsNamed) {
  Random<double> random(77);
  Description tree = random_tree(random, 4, one_dof_kinds);
  tree.bodies[3].joint.coupling = Coupling{"j1"};
  const Model model = ModelBuilder(tree).build();
  const std::vector<double> q(3);
  const auto lock = [&](std::string_view name) {
    return [&model, &q, name] { (void)reduced(model, std::span(&name, 1), q); };
  };
  const auto throws = [](const char* message) { return ThrowsMessage<std::invalid_argument>(message); };
  EXPECT_THAT(lock("j3"), throws("reduced: joint \"j3\" follows joint \"j1\"; lock \"j1\""));
  EXPECT_THAT(lock("k2"), throws("model \"random tree\" has no joint \"k2\"; did you mean \"j2\"?"));
  EXPECT_THAT([&] { (void)reduced(model, {}, std::vector<double>(5)); },
              throws("q has 5 entries; expected nq = 3"));
  BodyDescription ball = random_body(random, 0, "ground", JointKind::spherical);
  EXPECT_THAT(
      [&] {
        (void)reduced(ModelBuilder().add(ball).build(), {}, std::vector<double>{0, 0, 0, 3});
      },
      throws("q: the quaternion of joint \"j0\" has norm 3; it must be 1 to 1e-06"));
}

}  // namespace
}  // namespace axode::test
