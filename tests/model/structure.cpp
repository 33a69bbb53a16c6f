#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "axode/dynamics.hpp"
#include "tests/model/random_mechanism.hpp"

/// How the builder turns bodies and joints into a model: merged, split, ordered and coupled.
namespace axode::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr double to_rounding = 1e-13;

BodyDescription body(std::string name, std::string predecessor, JointKind kind = JointKind::revolute) {
  return {.name = std::move(name),
          .predecessor = std::move(predecessor),
          .joint = {.kind = kind},
          .inertia = MassProperties{.mass = 1}};
}
std::vector<std::string> body_names(const Model& model) {
  std::vector<std::string> names;
  for (int i = 1; i <= model.n_bodies(); ++i) names.push_back(model.body(i).name);
  return names;
}
std::vector<std::string> joint_names(const Model& model) {
  std::vector<std::string> names;
  for (const Joint& joint : model.joints()) names.push_back(joint.name);
  return names;
}
std::vector<std::string> frame_names(const Model& model) {
  std::vector<std::string> names;
  for (const Frame& frame : model.frames()) names.push_back(frame.name);
  return names;
}
std::vector<SE3<>> poses_of(const Model& model, const std::vector<double>& q) {
  Workspace<double> workspace(model);
  std::vector<SE3<>> C(model.n_frames());
  poses(model, workspace, q, C);
  return C;
}
SE3<> pose_of(const Model& model, const std::vector<double>& q, const std::string& frame) {
  return poses_of(model, q)[model.frame_index(frame)];
}
std::vector<double> torques(const Model& model, const std::vector<double>& q, const std::vector<double>& v,
                            const std::vector<double>& a, bool losses = false) {
  Workspace<double> workspace(model);
  std::vector<double> tau(model.nv());
  inverse_dynamics(model, workspace, q, v, a, tau, {.joint_losses = losses});
  return tau;
}

// ----------------------------------------------------------------------------------------------------- order

TEST(Structure, BodiesFollowDepthFirstInDeclaredOrder) {
  const Model model = ModelBuilder()
                          .add(body("left", "root"))
                          .add(body("second root", "ground"))
                          .add(body("left tip", "left"))
                          .add(body("root", "ground"))
                          .add(body("right", "root"))
                          .add(body("on second", "second root"))
                          .add(body("left tip too", "left"))
                          .build();
  EXPECT_THAT(body_names(model),
              ElementsAre("second root", "on second", "root", "left", "left tip", "left tip too", "right"));
  EXPECT_EQ(model.body(4).predecessor, 3);
  EXPECT_EQ(model.body(7).predecessor, 3);
  EXPECT_EQ(model.body(3).predecessor, 0);
}

TEST(Structure, TheOrderOfCoordinatesIsThatOfBodies) {
  const Model model = ModelBuilder()
                          .add(body("tip", "ball"))
                          .add(body("base", "ground", JointKind::free))
                          .add(body("ball", "base", JointKind::spherical))
                          .add(body("table", "base", JointKind::planar))
                          .build();
  EXPECT_THAT(joint_names(model), ElementsAre("base_joint", "ball_joint", "tip_joint", "table_joint"));
  std::vector<std::array<int, 4>> places;
  for (const Joint& joint : model.joints()) places.push_back({joint.iq, joint.nq, joint.iv, joint.nv});
  using Place = std::array<int, 4>;
  EXPECT_THAT(places,
              ElementsAre(Place{0, 7, 0, 6}, Place{7, 4, 6, 3}, Place{11, 1, 9, 1}, Place{12, 3, 10, 3}));
  EXPECT_EQ(model.nq(), 15);
  EXPECT_EQ(model.nv(), 13);
}

TEST(Structure, DeclaringBodiesInAnotherOrderChangesNoMotion) {
  Random<double> random(31);
  for (int trial = 0; trial < 30; ++trial) {
    const Description tree = random_tree(random, 10, all_kinds);
    Description shuffled = tree;
    for (std::size_t i = shuffled.bodies.size(); i > 1; --i)
      std::swap(shuffled.bodies[i - 1],
                shuffled.bodies[static_cast<std::size_t>(random.number(0, static_cast<double>(i)))]);
    const Model a = ModelBuilder(tree).build(), b = ModelBuilder(shuffled).build();
    EXPECT_THAT(body_names(b), testing::UnorderedElementsAreArray(body_names(a)));
    const std::vector<double> q = random_configuration(a, 5);
    std::vector<double> q_b(q.size());
    for (int i = 1; i <= a.n_bodies(); ++i) {
      const Joint &from = a.joint(i), &to = b.joint(b.joint_index(from.name));
      std::copy_n(q.begin() + from.iq, from.nq, q_b.begin() + to.iq);
    }
    const std::vector<SE3<>> C_a = poses_of(a, q), C_b = poses_of(b, q_b);
    for (int f = 0; f < a.n_frames(); ++f)
      EXPECT_LE(distance(C_a[f], C_b[b.frame_index(a.frame(f).name)]), 10 * to_rounding);
  }
}

// ---------------------------------------------------------------------------------------------- fixed bodies

TEST(Structure, FixedBodiesMergeAndStayFrames) {
  Random<double> random(32);
  Description tree;
  tree.bodies = {
      random_body(random, 0, "ground", JointKind::revolute), random_body(random, 1, "b0", JointKind::fixed),
      random_body(random, 2, "b1", JointKind::fixed), random_body(random, 3, "b2", JointKind::prismatic)};
  const Model model = ModelBuilder(tree).build();
  EXPECT_THAT(body_names(model), ElementsAre("b0", "b3"));
  EXPECT_THAT(joint_names(model), ElementsAre("j0", "j3"));
  EXPECT_THAT(frame_names(model), ElementsAre("ground", "b0", "b3", "b1", "b2"));
  EXPECT_EQ(model.body(2).predecessor, 1) << "what hangs on a merged body hangs on its carrier";
  EXPECT_EQ(model.frame(model.frame_index("b2")).body, 1);

  Inertia<> M;
  for (const char* name : {"b0", "b1", "b2"}) {
    const auto& from = *std::ranges::find(tree.bodies, name, &BodyDescription::name);
    const SE3<> on_b0 = inverse(reference_pose(tree, "b0")) * reference_pose(tree, name);
    M += transform(on_b0, inertia_from_com(from.inertia->mass, from.inertia->com, from.inertia->Theta));
    EXPECT_LE(distance(model.frame(model.frame_index(name)).pose, on_b0), to_rounding) << name;
  }
  EXPECT_LE(distance(model.body(1).M, M), 1e-12);
  EXPECT_LE(distance(model.body(2).B, inverse(reference_pose(tree, "b0")) * reference_pose(tree, "b3")),
            to_rounding)
      << "B is relative to the carrier";
}

TEST(Structure, FixingABodyEqualsAJointThatRests) {
  Random<double> random(33);
  for (int trial = 0; trial < 50; ++trial) {
    Description moving = random_tree(random, 8, one_dof_kinds), resting = moving;
    std::vector<std::string> fixed;
    for (BodyDescription& b : resting.bodies)
      if (random.number(0, 1) < 0.4) {
        b.joint.kind = JointKind::fixed;
        b.joint.pitch = 0;
        fixed.push_back(b.joint.name);
      }
    const Model a = ModelBuilder(moving).build(), b = ModelBuilder(resting).build();
    std::vector<double> q_a(a.nq()), v_a(a.nv()), dv_a(a.nv()), q_b, v_b, dv_b;
    std::vector<double> kept;
    for (const Joint& joint : b.joints()) {
      const int k = a.joint(a.joint_index(joint.name)).iv;
      q_b.push_back(q_a[k] = random.number(-2, 2));
      v_b.push_back(v_a[k] = random.number(-2, 2));
      dv_b.push_back(dv_a[k] = random.number(-2, 2));
    }
    const std::vector<SE3<>> C_a = poses_of(a, q_a), C_b = poses_of(b, q_b);
    for (int f = 0; f < a.n_frames(); ++f)
      EXPECT_LE(distance(C_a[f], C_b[b.frame_index(a.frame(f).name)]), 100 * to_rounding);
    const std::vector<double> tau_a = torques(a, q_a, v_a, dv_a), tau_b = torques(b, q_b, v_b, dv_b);
    for (const Joint& joint : b.joints())
      EXPECT_NEAR(tau_a[a.joint(a.joint_index(joint.name)).iv], tau_b[joint.iv], 1e-10 * (1 + size(tau_a)));
  }
}

TEST(Structure, BodiesFixedToTheGroundCarryMoversButAreNotMoved) {
  const SE3<> on_wall{exp_SO3(Vec3<>{0, 0, 1}), {1, 2, 3}}, arm_on_wall{{}, {0, 0, 0.5}};
  const Model model =
      ModelBuilder()
          .add({.name = "wall", .geometry = InBodyFrame{on_wall}, .inertia = MassProperties{.mass = 100}})
          .add({.name = "bracket",
                .predecessor = "wall",
                .geometry = InBodyFrame{arm_on_wall},
                .inertia = MassProperties{.mass = 10}})
          .add({.name = "arm",
                .predecessor = "bracket",
                .joint = {.kind = JointKind::revolute},
                .geometry = InBodyFrame{},
                .inertia = MassProperties{.mass = 1}})
          .build();
  EXPECT_EQ(model.n_bodies(), 1);
  EXPECT_THAT(frame_names(model), ElementsAre("ground", "arm", "wall", "bracket"));
  EXPECT_EQ(model.total_mass(), 1) << "of what moves";
  EXPECT_EQ(model.body(0).M.m, 110) << "the ground has the rest";
  EXPECT_LE(distance(model.body(1).A, on_wall * arm_on_wall), to_rounding);
  EXPECT_LE(distance(pose_of(model, {0.7}, "bracket"), on_wall * arm_on_wall), to_rounding);
}

TEST(Structure, AModelMayHaveNothingThatMoves) {
  const Model empty = ModelBuilder("nothing").build();
  EXPECT_EQ(empty.n_bodies(), 0);
  EXPECT_EQ(empty.nq(), 0);
  EXPECT_EQ(empty.n_frames(), 1);
  EXPECT_EQ(empty.total_mass(), 0);
  EXPECT_EQ(poses_of(empty, {}).size(), 1u);
  EXPECT_THAT(torques(empty, {}, {}, {}), IsEmpty());
  const Model rock = ModelBuilder().add(body("rock", "ground", JointKind::fixed)).build();
  EXPECT_EQ(rock.n_bodies(), 0);
  EXPECT_THAT(frame_names(rock), ElementsAre("ground", "rock"));
  EXPECT_THAT(neutral(rock), IsEmpty());
}

// ---------------------------------------------------------------------------------------------------- frames

TEST(Structure, FramesSitWhereTheyAreDrawn) {
  Random<double> random(34);
  Description tree;
  tree.bodies = {random_body(random, 0, "ground", JointKind::revolute),
                 random_body(random, 1, "b0", JointKind::fixed),
                 random_body(random, 2, "b1", JointKind::prismatic)};
  std::vector<SE3<>> drawn;
  for (const char* carrier : {"ground", "b0", "b1", "b2"})
    for (const GivenIn in : {GivenIn::body_frame, GivenIn::construction_frame}) {
      drawn.push_back(random.pose());
      const SE3<> A = reference_pose(tree, carrier);
      tree.frames.push_back({.name = numbered('f', static_cast<int>(drawn.size())),
                             .body = carrier,
                             .pose = in == GivenIn::body_frame ? inverse(A) * drawn.back() : drawn.back(),
                             .in = in});
    }
  const Model model = ModelBuilder(tree).build();
  EXPECT_THAT(frame_names(model),
              ElementsAre("ground", "b0", "b2", "b1", "f1", "f2", "f3", "f4", "f5", "f6", "f7", "f8"));
  const std::vector<SE3<>> at_zero = poses_of(model, {0, 0}), moved = poses_of(model, {0.3, -0.4});
  for (int f = 1; f <= 8; ++f) {
    const int k = model.frame_index(numbered('f', f));
    EXPECT_LE(distance(at_zero[k], drawn[f - 1]), 10 * to_rounding);
    EXPECT_LE(distance(moved[k], moved[model.frame(k).body] * model.frame(k).pose), 10 * to_rounding)
        << "frames move with their body";
  }
  EXPECT_EQ(model.frame(model.frame_index("f1")).body, 0);
  EXPECT_EQ(model.frame(model.frame_index("f5")).body, 1) << "on a merged body: on its carrier";
}

TEST(Structure, TheFirstFramesAreTheBodies) {
  Random<double> random(35);
  const Model model = ModelBuilder(random_tree(random, 20, all_kinds)).build();
  for (int i = 0; i <= model.n_bodies(); ++i) {
    EXPECT_EQ(model.frame(i).name, model.body(i).name);
    EXPECT_EQ(model.frame(i).body, i);
    EXPECT_EQ(distance(model.frame(i).pose, SE3<>{}), 0);
  }
}

// ------------------------------------------------------------------------- cylindrical and universal joints

TEST(Structure, ACylindricalJointBecomesARotationAndATranslation) {
  BodyDescription rod = body("rod", "ground", JointKind::cylindrical);
  rod.joint.name = "guide";
  rod.joint.dof = {{.lower = -1, .upper = 1, .damping = 2}, {.lower = 0, .upper = 0.5, .armature = 3}};
  const Model model = ModelBuilder().add(body("tip", "rod")).add(rod).build();
  EXPECT_THAT(body_names(model), ElementsAre("guide.sleeve", "rod", "tip"));
  EXPECT_THAT(joint_names(model), ElementsAre("guide.rotation", "guide.translation", "tip_joint"));
  EXPECT_EQ(model.joint(1).kind, Subgroup::revolute);
  EXPECT_EQ(model.joint(2).kind, Subgroup::prismatic);
  EXPECT_EQ(model.body(1).M.m, 0);
  EXPECT_EQ(model.body(2).M.m, 1);
  EXPECT_EQ(model.joint(1).dof[0].damping, 2);
  EXPECT_EQ(model.joint(2).dof[0].armature, 3);
  const CoordinateLimits limit = limits(model);
  EXPECT_EQ(limit.lower[0], -1);
  EXPECT_EQ(limit.lower[1], 0);
  EXPECT_EQ(limit.upper[1], 0.5);
  EXPECT_THAT(model.warnings(), IsEmpty()) << "the sleeve has no mass of its own and needs none";
}

TEST(Structure, AUniversalJointBecomesTwoRotations) {
  BodyDescription shaft = body("shaft", "ground", JointKind::universal);
  shaft.joint.dof = {{.lower = -1, .upper = 1, .friction = 2}, {.lower = -2, .upper = 0.5}};
  const Model model = ModelBuilder().add(shaft).build();
  EXPECT_THAT(body_names(model), ElementsAre("shaft_joint.cross", "shaft"));
  EXPECT_THAT(joint_names(model), ElementsAre("shaft_joint.first", "shaft_joint.second"));
  EXPECT_EQ(model.joint(1).kind, Subgroup::revolute);
  EXPECT_EQ(model.joint(2).kind, Subgroup::revolute);
  EXPECT_EQ(model.joint(1).dof[0].friction, 2);
  EXPECT_EQ(limits(model).lower[1], -2);
}

TEST(Structure, SplitJointsMoveAsTheirTwoScrews) {
  Random<double> random(36);
  for (int trial = 0; trial < 60; ++trial) {
    const JointKind kind = trial % 2 ? JointKind::cylindrical : JointKind::universal;
    Description drawn;
    drawn.bodies = {random_body(random, 0, "ground", JointKind::fixed), random_body(random, 1, "b0", kind)};
    const JointDescription& joint = drawn.bodies[1].joint;
    const Vec3<> first = (1 / norm(joint.axis)) * joint.axis,
                 second = (1 / norm(joint.second_axis)) * joint.second_axis;
    const std::vector<double> q{random.number(-3, 3), random.number(-3, 3)};
    const Screw<> Y1 = screw(first, joint.point);
    const Screw<> Y2 = kind == JointKind::cylindrical ? Screw<>{{}, first} : screw(second, joint.point);
    const SE3<> A = reference_pose(drawn, "b1");
    for (const Way way : ways) {
      const Model model = ModelBuilder(described(drawn, random, [&](auto) { return way; })).build();
      EXPECT_LE(distance(pose_of(model, q, "b1"), exp(q[0] * Y1) * exp(q[1] * Y2) * A), 100 * to_rounding);
      EXPECT_LE(distance(model.body(1).A, A), 10 * to_rounding) << "the body in between starts on the body";
    }
  }
}

// -------------------------------------------------------------------------------------------------- coupling

/// A tree of joints with one degree of freedom, in which j2 follows j0, and j4 follows j2, which comes after
/// it in the description.
Description coupled_tree(Random<double>& random) {
  Description tree = random_tree(random, 6, one_dof_kinds);
  tree.bodies[2].joint.coupling = Coupling{"j0", -2, 0.3};
  tree.bodies[4].joint.coupling = Coupling{"j2", 0.5, -1};
  if (random.number(0, 1) < 0.5) std::ranges::reverse(tree.bodies);
  for (BodyDescription& b : tree.bodies)
    b.joint.dof = {
        {.damping = random.number(0, 1), .friction = random.number(0, 1), .armature = random.number(0, 1)}};
  return tree;
}

TEST(Structure, ACoupledJointHasNoCoordinateOfItsOwn) {
  Random<double> random(37);
  for (int trial = 0; trial < 20; ++trial) {
    const Model model = ModelBuilder(coupled_tree(random)).build();
    EXPECT_EQ(model.n_bodies(), 6);
    EXPECT_EQ(model.nq(), 4);
    EXPECT_EQ(model.nv(), 4);
    const int leader = model.joint_index("j0");
    EXPECT_FALSE(model.joint(leader).leader);
    const auto expect_follows = [&](const char* name, double ratio, double offset) {
      const Joint& joint = model.joint(model.joint_index(name));
      ASSERT_TRUE(joint.leader);
      EXPECT_EQ(joint.leader->joint, leader) << "chains of couplings are resolved";
      EXPECT_DOUBLE_EQ(joint.leader->ratio, ratio);
      EXPECT_DOUBLE_EQ(joint.leader->offset, offset);
      EXPECT_EQ(joint.nq, 0);
      EXPECT_EQ(joint.nv, 0);
      EXPECT_EQ(joint.iq, model.joint(leader).iq);
      EXPECT_EQ(joint.iv, model.joint(leader).iv);
      const Tree<double>& tree = model.tree<double>();
      const int i = model.joint_index(name);
      EXPECT_EQ(tree->iq[i], tree->iq[leader]);
      EXPECT_DOUBLE_EQ(tree.ratio[i], ratio);
      EXPECT_DOUBLE_EQ(tree.offset[i], offset);
    };
    expect_follows("j2", -2, 0.3);
    expect_follows("j4", -1, 0.5 * 0.3 - 1);
  }
}

TEST(Structure, ACoupledJointMovesAndLoadsItsLeader) {
  Random<double> random(38);
  for (int trial = 0; trial < 50; ++trial) {
    const Description tree = coupled_tree(random);
    Description independent = tree;
    for (BodyDescription& b : independent.bodies) b.joint.coupling.reset();
    const Model a = ModelBuilder(tree).build(), b = ModelBuilder(independent).build();
    const std::vector<double> q = random_numbers(random, a.nq()), v = random_numbers(random, a.nv()),
                              dv = random_numbers(random, a.nv());
    std::vector<double> q_b(b.nq()), v_b(b.nv()), dv_b(b.nv());
    for (int i = 1; i <= a.n_bodies(); ++i) {
      const Joint& joint = a.joint(i);
      const double k = joint.leader ? joint.leader->ratio : 1, c = joint.leader ? joint.leader->offset : 0;
      q_b[b.joint(i).iq] = k * q[joint.iq] + c;
      v_b[b.joint(i).iv] = k * v[joint.iv];
      dv_b[b.joint(i).iv] = k * dv[joint.iv];
    }
    const std::vector<SE3<>> C_a = poses_of(a, q), C_b = poses_of(b, q_b);
    for (int f = 0; f < a.n_frames(); ++f) EXPECT_LE(distance(C_a[f], C_b[f]), 10 * to_rounding);
    for (const bool losses : {false, true}) {
      const std::vector<double> tau = torques(a, q, v, dv, losses),
                                tau_b = torques(b, q_b, v_b, dv_b, losses);
      std::vector<double> power_equivalent(a.nv());
      for (int i = 1; i <= a.n_bodies(); ++i)
        power_equivalent[a.joint(i).iv] +=
            (a.joint(i).leader ? a.joint(i).leader->ratio : 1) * tau_b[b.joint(i).iv];
      EXPECT_LE(distance(tau, power_equivalent), 1e-11 * (1 + size(tau)))
          << "armature and losses come with the square and the absolute value of the ratio";
    }
  }
}

TEST(Structure, DriveInertiaAndLossesOfCoupledJointsAddUpOnTheLeader) {
  const auto link = [](const char* name, std::optional<Coupling> coupling) {
    BodyDescription b = body(name, "ground");
    b.joint.coupling = std::move(coupling);
    b.joint.dof = {{.damping = 2, .friction = 3, .armature = 5}};
    return b;
  };
  const Model model = ModelBuilder()
                          .add(link("half", Coupling{"leader_joint", -0.5, 1}))
                          .add(link("leader", {}))
                          .add(link("sixth", Coupling{"half_joint", 1.0 / 3}))
                          .build();
  const Tree<double>& tree = model.tree<double>();
  ASSERT_EQ(tree->nv, 1);
  EXPECT_DOUBLE_EQ(tree.damping[0], 2 * (1 + 1 / 4.0 + 1 / 36.0));
  EXPECT_DOUBLE_EQ(tree.friction[0], 3 * (1 + 1 / 2.0 + 1 / 6.0));
  EXPECT_DOUBLE_EQ(tree.armature[0], 5 * (1 + 1 / 4.0 + 1 / 36.0));
}

TEST(Structure, DriveInertiaAndLossesOfEveryDegreeOfFreedomStayInPlace) {
  BodyDescription ball = body("ball", "ground", JointKind::spherical),
                  base = body("base", "ground", JointKind::free);
  ball.joint.dof = {{.damping = 1}, {.friction = 2}, {.armature = 3}};
  base.joint.dof.resize(6);
  base.joint.dof[4].armature = 7;
  const Model model = ModelBuilder().add(ball).add(base).build();
  EXPECT_THAT(model.tree<double>().damping, ElementsAre(1, 0, 0, 0, 0, 0, 0, 0, 0));
  EXPECT_THAT(model.tree<double>().friction, ElementsAre(0, 2, 0, 0, 0, 0, 0, 0, 0));
  EXPECT_THAT(model.tree<double>().armature, ElementsAre(0, 0, 3, 0, 0, 0, 0, 7, 0));
}

TEST(Structure, RunsOfOneKindCoverEveryJointOnce) {
  Random<double> random(39);
  for (int trial = 0; trial < 30; ++trial) {
    Description description = random_tree(random, 20, all_kinds);
    description.bodies.push_back(random_body(random, 20, "ground", JointKind::revolute));
    description.bodies.push_back(random_body(random, 21, "b20", JointKind::helical));
    description.bodies[21].joint.coupling = Coupling{"j20"};
    const Model model = ModelBuilder(description).build();
    const Tree<double>& tree = model.tree<double>();
    std::vector<int> seen(tree->n + 1);
    bool coupled_before = false;
    int next = 0;
    for (const JointGroup& group : tree->joint_groups) {
      EXPECT_EQ(group.begin, next);
      EXPECT_LT(group.begin, group.end);
      EXPECT_GE(group.coupled, coupled_before) << "coupled ones come last";
      coupled_before = group.coupled, next = group.end;
      for (int k = group.begin; k < group.end; ++k) {
        const Joint& joint = model.joint(tree->by_kind[k]);
        EXPECT_EQ(joint.kind, group.kind);
        EXPECT_EQ(joint.leader.has_value(), group.coupled);
        ++seen[tree->by_kind[k]];
      }
    }
    EXPECT_EQ(next, tree->n);
    EXPECT_EQ(std::count(seen.begin() + 1, seen.end(), 1), tree->n);
  }
}

// ------------------------------------------------------------------------------------------------- free base

TEST(Structure, AFreeBaseIsSetFreeWhereItWasFixed) {
  Random<double> random(40);
  Description robot;
  robot.bodies = {random_body(random, 0, "ground", JointKind::fixed),
                  random_body(random, 1, "b0", JointKind::revolute)};
  for (const Way way : ways) {
    const Description fixed = described(robot, random, [&](auto) { return way; });
    const Model held = ModelBuilder(fixed).build(), loose = ModelBuilder(with_free_base(fixed)).build();
    EXPECT_THAT(joint_names(loose), ElementsAre("free_base", "j1"));
    EXPECT_EQ(loose.joint(1).kind, Subgroup::free);
    EXPECT_EQ(loose.nq(), held.nq() + 7);
    const std::vector<SE3<>> C_held = poses_of(held, {0.4}),
                             C_loose = poses_of(loose, {0, 0, 0, 1, 0, 0, 0, 0.4});
    for (const Frame& frame : held.frames())
      EXPECT_LE(distance(C_held[held.frame_index(frame.name)], C_loose[loose.frame_index(frame.name)]),
                10 * to_rounding);
    EXPECT_NEAR(loose.total_mass(), robot.bodies[0].inertia->mass + robot.bodies[1].inertia->mass,
                to_rounding);
  }
}

}  // namespace
}  // namespace axode::test
