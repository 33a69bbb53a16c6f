#include "axode/model/building/edited.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "axode/constraints/absolute/joint_state.hpp"
#include "axode/dynamics.hpp"
#include "axode/eigen.hpp"
#include "axode/kinematics.hpp"
#include "axode/model/kinds/joint_kinds.hpp"
#include "tests/lie/relative_error.hpp"
#include "tests/model/random_loops.hpp"
#include "tests/support/random_tree.hpp"

/// Models that are made from other models: with other parameters, another gravity or a payload, or mounted on
/// another mechanism.
namespace axode::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

auto refuses(const std::string& part) { return ThrowsMessage<std::invalid_argument>(HasSubstr(part)); }
auto finds(const std::string& part) { return ThrowsMessage<ModelError>(HasSubstr(part)); }

Model any_model(Random<double>& random, int most_bodies = 20) {
  return ModelBuilder(described(random_mechanism(random, {.most_bodies = most_bodies}), random)).build();
}
std::vector<double> torques(const Model& model, const State<double>& at) {
  Workspace<double> workspace(model);
  std::vector<double> tau(model.nv());
  inverse_dynamics(model, workspace, at.q, at.v, at.a, tau);
  return tau;
}
double largest(const std::vector<double>& x) {
  double found = 0;
  for (const double value : x) found = std::max(found, std::abs(value));
  return found;
}

/// The generalised forces Y pi, from the regressor Y and the parameters pi.
std::vector<double> by_regressor(const Model& model, const State<double>& at, const std::vector<double>& pi) {
  Workspace<double> workspace(model);
  std::vector<double> Y(pi.size() * static_cast<std::size_t>(model.nv())), tau(model.nv());
  regressor(model, workspace, at.q, at.v, at.a, Y);
  for (std::size_t r = 0; r < tau.size(); ++r)
    for (std::size_t k = 0; k < pi.size(); ++k) tau[r] += Y[r * pi.size() + k] * pi[k];
  return tau;
}

TEST(WithParameters, DriveForcesAreTheRegressorTimesTheParameters) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random<double> random(seed);
    Description description = described(random_mechanism(random, {.most_bodies = 20}), random);
    for (BodyDescription& body : description.bodies)  // the regressor does not count these
      for (Dof& dof : body.joint.dof) dof.armature = 0;
    const Model model = ModelBuilder(description).build();
    std::vector<double> pi;
    for (int i = 0; i < model.n_bodies(); ++i) {
      const auto own = inertial_parameters(random.inertia());
      pi.insert(pi.end(), own.begin(), own.end());
    }
    const Model identified = with_parameters(model, pi);
    const State<double> at = random_state(model, random);
    const std::vector<double> tau = torques(identified, at), expected = by_regressor(model, at, pi);
    const double scale = std::max(1.0, largest(expected));
    for (std::size_t k = 0; k < tau.size(); ++k) EXPECT_NEAR(tau[k], expected[k], 1e-10 * scale);
  }
}

TEST(WithParameters, KeepsWhatIsFixedAsFramesAndReturnsWhatItWasGiven) {
  Random<double> random(7);
  const Model model = any_model(random);
  const std::vector<double> pi = inertial_parameters(model);
  const Model again = with_parameters(model, pi);
  ASSERT_EQ(again.n_frames(), model.n_frames());
  for (int f = 0; f < model.n_frames(); ++f) EXPECT_EQ(again.frame(f).name, model.frame(f).name);
  const std::vector<double> back = inertial_parameters(again);
  for (std::size_t k = 0; k < pi.size(); ++k) EXPECT_NEAR(back[k], pi[k], 1e-13 * largest(pi));
}

Model pendulum() {
  return ModelBuilder("pendulum")
      .add({.name = "rod",
            .joint = {.name = "pivot", .kind = JointKind::revolute, .axis = {0, 1, 0}},
            .inertia = MassProperties{.mass = 2, .com = {0.5, 0, 0}, .Theta = {.01, .1, .1, 0, 0, 0}}})
      .add({.name = "tip", .body = "rod", .pose = {{}, {1, 0, 0}}})
      .build();
}

TEST(WithParameters, EstimatesThatNoMatterHasAreWarningsAndNonsenseIsAnError) {
  const Model model = pendulum();
  const Model odd = with_parameters(model, std::vector<double>{2, 1, 0, 0, 5, .1, .1, 0, 0, 0});
  ASSERT_EQ(odd.warnings().size(), 1u);
  EXPECT_EQ(odd.warnings()[0].rule, Rule::inertia_not_realisable);
  EXPECT_EQ(inertial_parameters(with_parameters(model, std::vector<double>(10))), std::vector<double>(10));
  EXPECT_THAT([&] { with_parameters(model, std::vector<double>(9)); },
              refuses("pi has 9 entries; expected 10 * n_bodies = 10"));
  EXPECT_THAT(
      [&] {
        with_parameters(model, std::vector<double>{0, 1, 0, 0, 0, 0, 0, 0, 0, 0});
      },
      refuses("body \"rod\" has a first moment of mass but the mass 0"));
  EXPECT_THAT(
      [&] {
        with_parameters(model, std::vector<double>{-1, 0, 0, 0, 1, 1, 1, 0, 0, 0});
      },
      finds("mass is -1 kg"));
  EXPECT_THAT(
      [&] {
        with_parameters(model, std::vector<double>{1, 0, 0, 0, 1, 1, NAN, 0, 0, 0});
      },
      finds("not finite"));
}

TEST(WithGravity, ChangesOnlyTheWeight) {
  const Model model = pendulum(), there = with_gravity(model, {0, 0, -1.62});
  EXPECT_EQ(there.gravity().z, -1.62);
  EXPECT_EQ(model.gravity().z, -9.81);
  const State<double> level{{0}, {0}, {0}};
  EXPECT_NEAR(torques(there, level)[0], torques(model, level)[0] * 1.62 / 9.81, 1e-14);
  EXPECT_THAT([&] { with_gravity(model, {0, NAN, 0}); }, finds("gravity"));
}

TEST(WithPayload, IsTheBodyDrawnThere) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    Random<double> random(seed);
    const Model model = any_model(random, 12);
    const int f = static_cast<int>(seed) % model.n_frames();
    const Frame& at = model.frame(f);
    const Inertia<> M = random.inertia();
    const Model loaded = with_payload(model, at.name, M, "load");
    for (int i = 1; i <= model.n_bodies(); ++i) {
      Inertia<> expected = model.body(i).M;
      if (i == at.body) expected += transform(at.pose, M);
      const auto own = inertial_parameters(loaded.body(i).M), sum = inertial_parameters(expected);
      for (std::size_t k = 0; k < 10; ++k) EXPECT_NEAR(own[k], sum[k], 1e-10);
    }
    const Frame& load = loaded.frame(loaded.frame_index("load"));
    EXPECT_EQ(load.body, at.body);
    EXPECT_LE(distance(load.pose, at.pose), 1e-12);
  }
}

TEST(WithPayload, RefusesWhatCannotBe) {
  const Model model = pendulum();
  const Inertia<> M = inertia_from_com(1.0, Vec3<>{}, Sym3<>{.1, .1, .1, 0, 0, 0});
  EXPECT_THAT([&] { with_payload(model, "tipp", M); }, refuses("did you mean \"tip\""));
  EXPECT_THAT([&] { with_payload(with_payload(model, "tip", M), "tip", M); },
              finds("body \"payload\": the name is taken"));
  const Model doubtful = with_payload(model, "tip", {1, {}, {1, 1, 5, 0, 0, 0}});
  ASSERT_EQ(doubtful.warnings().size(), 1U);
  EXPECT_EQ(doubtful.warnings()[0].element, "body \"payload\"");
  EXPECT_THAT([&] { with_payload(model, "tip", {-1, {}, {1, 1, 1, 0, 0, 0}}); }, finds("mass is -1 kg"));
}

TEST(Append, PutsTheOtherMechanismWhereTheFrameIs) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random<double> random(seed);
    const Model arm = any_model(random, 10), hand = any_model(random, 10);
    const Frame& flange = arm.frame(static_cast<int>(random.number(0, arm.n_frames())));
    const Model both = append(arm, flange.name, hand, "hand ");
    ASSERT_EQ(both.nq(), arm.nq() + hand.nq());
    ASSERT_EQ(both.n_frames(), arm.n_frames() + hand.n_frames() - 1);

    const std::vector<double> q_arm = random_configuration(arm, seed),
                              q_hand = random_configuration(hand, seed);
    std::vector<double> q(both.nq());
    const auto carry = [&](const Model& part, const std::string& prefix, const std::vector<double>& from) {
      for (const Joint& joint : part.joints()) {
        const Joint& same = both.joint(both.joint_index(prefix + joint.name));
        ASSERT_EQ(same.nq, joint.nq);
        for (int k = 0; k < joint.nq; ++k) q[same.iq + k] = from[joint.iq + k];
      }
    };
    carry(arm, "", q_arm), carry(hand, "hand ", q_hand);
    const std::vector<SE3<>> C = poses_of(both, q), C_arm = poses_of(arm, q_arm),
                             C_hand = poses_of(hand, q_hand);
    const SE3<> mount = C_arm[arm.frame_index(flange.name)];
    for (int f = 0; f < arm.n_frames(); ++f)
      EXPECT_LE(distance(C[both.frame_index(arm.frame(f).name)], C_arm[f]), 1e-11);
    for (int f = 1; f < hand.n_frames(); ++f)
      EXPECT_LE(distance(C[both.frame_index("hand " + hand.frame(f).name)], mount * C_hand[f]), 1e-10);
    for (int i = 1; i <= hand.n_bodies(); ++i) {
      const auto own = inertial_parameters(both.body(both.body_index("hand " + hand.body(i).name)).M),
                 given = inertial_parameters(hand.body(i).M);
      for (std::size_t k = 0; k < 10; ++k) EXPECT_NEAR(own[k], given[k], 1e-10);
    }
  }
}

Model any_model_with_loops(Random<double>& random) {
  const Description tree = described(random_mechanism(random, {.most_bodies = 10}), random);
  return ModelBuilder(with_loops(tree, random)).build();
}

TEST(Append, LoopsOfBothAreClosedAsBefore) {
  std::size_t loops = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random<double> random(seed);
    const Model arm = any_model_with_loops(random), hand = any_model_with_loops(random);
    const Frame& flange = arm.frame(static_cast<int>(random.number(0, arm.n_frames())));
    const Model both = append(arm, flange.name, hand, "hand ");
    ASSERT_EQ(both.loops().all.size(), arm.loops().all.size() + hand.loops().all.size());
    loops += both.loops().all.size();
    const std::vector<double> q = random_configuration(both, seed);
    const auto of = [&](const Model& part, const std::string& prefix) {
      std::vector<double> own(part.nq());
      for (const Joint& joint : part.joints()) {
        const Joint& same = both.joint(both.joint_index(prefix + joint.name));
        EXPECT_EQ(same.passive, joint.passive);
        std::copy_n(q.begin() + same.iq, same.nq, own.begin() + joint.iq);
      }
      return own;
    };
    expect_same_loops(arm, of(arm, ""), both, q);
    expect_same_loops(hand, of(hand, "hand "), both, q, "hand ");
  }
  EXPECT_GT(loops, 600U);
}

/// The state of the model `to` in which its bodies have the poses and twists that they have in a state of
/// `from`. Both models have the same bodies.
JointState in_coordinates_of(const Model& to, const Model& from, const std::vector<double>& q,
                             const std::vector<double>& v, std::span<const double> near = {}) {
  Workspace<double> workspace(from);
  std::vector<SE3<>> C(from.n_frames());
  std::vector<Twist<BodyFixed>> V(from.n_frames());
  poses(from, workspace, q, C);
  twists<BodyFixed>(from, workspace, q, v, V);
  std::vector<SE3<>> C_to(1);
  std::vector<Twist<BodyFixed>> V_to(1);
  for (int i = 1; i <= to.n_bodies(); ++i) {
    const auto f = static_cast<std::size_t>(from.frame_index(to.body(i).name));
    C_to.push_back(C[f]), V_to.push_back(V[f]);
  }
  return joint_state(to, C_to, V_to, near);
}

/// A random tree with one body joined to the ground, which is free or fixed. Joints with several velocities
/// have no limits, springs or losses along single axes, because these axes would depend on the direction of
/// the joint.
Model tree_to_reroot(Random<double>& random, bool free) {
  Description tree = described(
      random_mechanism(random, {.most_bodies = 12, .always_mass = true, .one_free_root = true}), random);
  for (BodyDescription& body : tree.bodies)
    if (traits(body.joint.kind).dof > 1) body.joint.dof.clear();
  return ModelBuilder(free ? tree : with_fixed_base(tree)).build();
}
std::string any_body(const Model& model, Random<double>& random) {
  return model.description()
      .bodies[static_cast<std::size_t>(
          random.number(0, static_cast<double>(model.description().bodies.size())))]
      .name;
}

TEST(Rerooted, AFloatingMechanismMovesAsBefore) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random<double> random(seed);
    const Model model = tree_to_reroot(random, true), other = rerooted(model, any_body(model, random));
    ASSERT_EQ(other.nv(), model.nv());
    const std::vector<double> q = random_configuration(model, seed), v = random_numbers(random, model.nv());
    const JointState at = in_coordinates_of(other, model, q, v);
    EXPECT_LE(at.position_residual, 1e-9);
    EXPECT_LE(at.velocity_residual, 1e-9);

    // The velocities of the two models are related by v' = X v, and their forces by τ = Xᵀ τ'.
    const Eigen::Index nv = model.nv();
    Eigen::MatrixXd X(nv, nv);
    for (Eigen::Index k = 0; k < nv; ++k) {
      const Eigen::VectorXd one = Eigen::VectorXd::Unit(nv, k);
      const std::vector<double> column = in_coordinates_of(other, model, q, {one.begin(), one.end()}, at.q).v;
      X.col(k) = Eigen::Map<const Eigen::VectorXd>(column.data(), nv);
    }
    Workspace<double> workspace(model), other_workspace(other);
    std::vector<double> M(static_cast<std::size_t>(nv * nv)), M_other(M.size());
    mass_matrix(model, workspace, q, M), mass_matrix(other, other_workspace, at.q, M_other);
    using Square = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
    const Eigen::MatrixXd expected = Square(M.data(), nv, nv),
                          found = X.transpose() * Square(M_other.data(), nv, nv) * X;
    EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff());

    // Equivalent drive forces accelerate all bodies in the same way.
    const std::vector<double> tau = random_numbers(random, model.nv(), 10);
    const Eigen::VectorXd tau_other =
        X.transpose().partialPivLu().solve(Eigen::Map<const Eigen::VectorXd>(tau.data(), nv));
    std::vector<double> a(v.size()), a_other(v.size());
    ASSERT_TRUE(forward_dynamics(model, workspace, q, v, tau, a).ok());
    ASSERT_TRUE(forward_dynamics(other, other_workspace, at.q, at.v,
                                 std::vector<double>(tau_other.begin(), tau_other.end()), a_other)
                    .ok());
    std::vector<TwistRate<BodyFixed>> dV(model.n_frames()), dV_other(dV.size());
    accelerations<BodyFixed>(model, workspace, q, v, a, dV);
    accelerations<BodyFixed>(other, other_workspace, at.q, at.v, a_other, dV_other);
    double scale = 1;
    for (const TwistRate<BodyFixed>& each : dV) scale = std::max({scale, norm(each.w), norm(each.v)});
    for (int f = 1; f < model.n_frames(); ++f) {
      const TwistRate<BodyFixed>&own = dV[f], &its = dV_other[other.frame_index(model.frame(f).name)];
      EXPECT_LE(std::max(norm(own.w - its.w), norm(own.v - its.v)), 1e-8 * scale) << model.frame(f).name;
    }
  }
}

TEST(Rerooted, CoordinatesOfJointsOfOneVelocityAndNamesStay) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    Random<double> random(seed);
    Description tree = tree_to_reroot(random, seed % 2 == 0).description();
    for (BodyDescription& body : tree.bodies)
      if (body.joint.coupling) body.joint.coupling->offset = 0;  // so that all joints can be at 0
    const Model model = ModelBuilder(tree).build(), other = rerooted(model, any_body(model, random));
    const std::vector<double> q = random_configuration(model, seed);
    ASSERT_EQ(other.n_bodies(), model.n_bodies());
    if (model.n_bodies() == 0) continue;
    std::vector<double> one = neutral(model), same = neutral(other);
    for (const Joint& joint : model.joints()) {
      const Joint& its = other.joint(other.joint_index(joint.name));
      EXPECT_EQ(its.nq, joint.nq);
      EXPECT_EQ(its.leader.has_value(), joint.leader.has_value());
      if (joint.nq == 1) one[joint.iq] = same[its.iq] = q[joint.iq];
    }
    // Seen from any one body, all others are where they were before; at the coordinates 0 also in space.
    const std::vector<SE3<>> C = poses_of(model, one), C_other = poses_of(other, same),
                             C_0 = poses_of(model, neutral(model)),
                             C_other_0 = poses_of(other, neutral(other));
    const std::string& first = model.body(1).name;
    const SE3<> here = C[model.frame_index(first)], there = C_other[other.frame_index(first)];
    for (int f = 1; f < model.n_frames(); ++f) {
      const int g = other.frame_index(model.frame(f).name);
      if (model.frame(f).body != 0) {
        EXPECT_LE(distance(inverse(here) * C[f], inverse(there) * C_other[g]), 1e-10);
      }
      EXPECT_LE(distance(C_0[f], C_other_0[g]), 1e-10);
    }
  }
}

TEST(Rerooted, ClosesLoopsAsBefore) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    Random<double> random(seed);
    const Description tree = tree_to_reroot(random, true).description();
    const Model model = ModelBuilder(with_loops(tree, random)).build(),
                other = rerooted(model, any_body(model, random));
    const std::vector<double> q = random_configuration(model, seed), v(model.nv());
    expect_same_loops(model, q, other, in_coordinates_of(other, model, q, v).q);
  }
}

TEST(Rerooted, RefusesWhatWouldBeAnotherMechanism) {
  EXPECT_THAT([] { rerooted(pendulum(), "rodd"); },
              refuses("body \"rodd\" is not described; did you mean \"rod\""));
  EXPECT_THAT(
      [] { rerooted(pendulum(), "rod"); },
      refuses("body \"rod\" hangs on the ground by the joint \"pivot\", which is revolute; only a root"));
  const auto floating = [](const Dof& dof) {
    Description two =
        append(
            ModelBuilder("").add(BodyDescription{.name = "hull", .joint = {.kind = JointKind::free}}).build(),
            "hull", pendulum())
            .description();
    two.bodies[1].joint.kind = JointKind::spherical, two.bodies[1].joint.dof = {dof, dof, dof};
    return ModelBuilder(two).build();
  };
  EXPECT_NO_THROW(rerooted(floating({.damping = 1, .armature = 1, .stiffness = 1}), "rod"));
  EXPECT_THAT([&] { rerooted(floating({.upper = 1}), "rod"); },
              refuses("joint \"pivot\" is spherical and has limits, losses, springs or armatures"));
  EXPECT_NO_THROW(rerooted(floating({.upper = 1}), "hull"));
}

TEST(Edits, KeepLoops) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    Random<double> random(seed);
    const Model model = any_model_with_loops(random);
    const std::vector<double> q = random_configuration(model, seed);
    const std::string at = model.frame(static_cast<int>(random.number(0, model.n_frames()))).name;
    for (const Model& edited : {with_parameters(model, inertial_parameters(model)), with_gravity(model, {}),
                                with_payload(model, at, random.inertia(), "load")}) {
      EXPECT_EQ(edited.loops().rows, model.loops().rows);
      EXPECT_EQ(edited.loops().driven, model.loops().driven);
      expect_same_loops(model, q, edited, q);
    }
  }
}

TEST(Append, NamesOfLoopsAndCouplingsAndTheirDefaultsCount) {
  Description two = pendulum().description();
  BodyDescription other = two.bodies[0];
  other.name = "other rod", other.joint.name = "other pivot";
  two.bodies.push_back(other);
  two.loops.push_back({.between = {"rod", "other rod"}, .kind = LoopKind::spherical});
  two.couplings.push_back({.name = "gear", .terms = {{"pivot", 1}, {"other pivot", -1}}});
  const Model model = ModelBuilder(two).build();
  EXPECT_THAT([&] { append(model, "tip", model); }, refuses("\"tip\", \"loop 1\", \"gear\"; give a prefix"));
  const Model twice = append(model, "tip", model, "2 ");
  std::vector<std::string> names;
  for (const LoopRows& loop : twice.loops().all) names.push_back(loop.name);
  EXPECT_THAT(names, ElementsAre("loop 1", "2 loop 1", "gear", "2 gear"));
}

TEST(Append, ByAJointIsTheOtherMechanismOnAMovingGround) {
  for (const JointTraits& kind : joint_kinds) {
    SCOPED_TRACE(kind.name);
    Random<double> random(static_cast<std::uint64_t>(kind.kind) + 1);
    const Model arm = any_model(random, 8), hand = any_model(random, 8);
    const Frame& flange = arm.frame(static_cast<int>(random.number(0, arm.n_frames())));
    const JointDescription wrist{.kind = kind.kind,
                                 .axis = {0.3, -0.4, 1},
                                 .second_axis = {1, 0.2, -0.1},
                                 .point = {0.2, 0.1, -0.3},
                                 .pitch = kind.kind == JointKind::helical ? 0.1 : 0};
    const Model both = append(arm, flange.name, hand, "hand ", wrist);
    ASSERT_EQ(both.nv(), arm.nv() + hand.nv() + kind.dof);

    // The wrist, drawn alone on the ground.
    const Model alone = ModelBuilder("wrist")
                            .add(BodyDescription{.name = "hand mount.base",
                                                 .joint =
                                                     [&] {
                                                       JointDescription joint = wrist;
                                                       joint.name = "hand mount";
                                                       return joint;
                                                     }(),
                                                 .geometry = InBodyFrame{}})
                            .build();
    const std::vector<double> q = random_configuration(both, 5);
    const auto of = [&](const Model& part, const std::string& prefix) {
      std::vector<double> own(part.nq());
      for (const Joint& joint : part.joints())
        if (joint.nq > 0)
          std::copy_n(q.begin() + both.joint(both.joint_index(prefix + joint.name)).iq, joint.nq,
                      own.begin() + joint.iq);
      return own;
    };
    const std::vector<SE3<>> C = poses_of(both, q), C_arm = poses_of(arm, of(arm, "")),
                             C_hand = poses_of(hand, of(hand, "hand ")),
                             C_wrist = poses_of(alone, of(alone, ""));
    const SE3<> mount = C_arm[arm.frame_index(flange.name)] * C_wrist.back();
    for (int f = 1; f < hand.n_frames(); ++f)
      EXPECT_LE(distance(C[both.frame_index("hand " + hand.frame(f).name)], mount * C_hand[f]), 1e-10);
    if (kind.kind != JointKind::fixed) {
      EXPECT_LE(distance(C[both.frame_index("hand mount.base")], mount), 1e-11);
      EXPECT_THAT(
          [&] { append(both, flange.name, pendulum(), "", {.name = "hand mount", .kind = kind.kind}); },
          finds("the name is taken"));
    }
  }
}

TEST(Append, NeedsNamesOfItsOwn) {
  const Model model = pendulum();
  EXPECT_THAT(
      [&] { append(model, "tip", model); },
      refuses("append: both models have \"rod\", \"pivot\", \"tip\"; give a prefix that makes them differ"));
  EXPECT_THAT([&] { append(model, "tipp", model, "2 "); }, refuses("did you mean \"tip\""));
  const Model twice = append(model, "tip", model, "2 ");
  EXPECT_EQ(twice.body(2).name, "2 rod");
  EXPECT_EQ(twice.joint(2).name, "2 pivot");
  EXPECT_EQ(twice.frame(twice.frame_index("2 tip")).name, "2 tip");
}

}  // namespace
}  // namespace axode::test
