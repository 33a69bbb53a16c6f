#include <functional>
#include <set>

#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// Wrong arguments of the dynamics are refused; numbers that are none pass through.
namespace axode::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

class DynamicsArguments : public Law {
 protected:
  const Model model = shoulder();
  std::unique_ptr<Subject> subject = test::subject(GetParam(), model);
  Ask ask{.q = {0, 0, 0, 1, 0}, .v = {0, 0, 0, 0}, .a = {0, 0, 0, 0}};
  std::size_t tau_size = 4, W_size = 12;  ///< in numbers

  std::vector<double> torques() { return subject->call("inverse_dynamics", ask, tau_size).numbers; }
  std::vector<double> wrenches() { return subject->call("joint_wrenches", ask, W_size).numbers; }
  void expect_torques(const Refusal& refusal) {
    EXPECT_THAT([&] { torques(); }, refusal);
  }
  void expect_wrenches(const Refusal& refusal) {
    EXPECT_THAT([&] { wrenches(); }, refusal);
  }
  void expect_both(const Refusal& refusal) { expect_torques(refusal), expect_wrenches(refusal); }
};
INSTANTIATE_TEST_SUITE_P(Dynamics, DynamicsArguments, testing::ValuesIn(cases()), name_of);

TEST_P(DynamicsArguments, OfTheWrongSizeAreNamed) {
  ask.q.resize(4);
  expect_both(refused("q", 4, "nq", 5));
  ask.q = {0, 0, 0, 1, 0};
  ask.v.resize(7);
  expect_both(refused("v", 7, "nv", 4));
  ask.v.resize(4);
  ask.a.resize(0);
  expect_both(refused("a", 0, "nv", 4));
  ask.a.resize(4);
  tau_size = 5;
  expect_torques(refused("tau", 5, "nv", 4));
  W_size = 18;
  expect_wrenches(refused("W", 3, "n_bodies", 2));
  tau_size = 4, W_size = 12;
  EXPECT_NO_THROW(torques());
  EXPECT_NO_THROW(wrenches());
}

TEST_P(DynamicsArguments, LoadsOnFramesThatDoNotExistAreRefused) {
  std::vector<AppliedWrench<>> loads;
  for (const int frame : {-1, 3}) {
    loads = {AppliedWrench<>(frame, Wrench<Hybrid>{})};
    ask.loads.wrenches = loads;
    expect_both(testing::ThrowsMessage<std::invalid_argument>(
        testing::AllOf(testing::StartsWith("loads: "), testing::HasSubstr("frame " + std::to_string(frame)),
                       testing::HasSubstr("\"shoulder\" has frames 0 to 2"))));
  }
  loads = {AppliedWrench<>(0, Wrench<Hybrid>{}), AppliedWrench<>(2, Wrench<Mixed>{})};
  ask.loads.wrenches = loads;
  EXPECT_NO_THROW(torques());
}

TEST_P(DynamicsArguments, AWorkspaceOfASmallerModelIsRefused) {
  subject = test::subject(GetParam(), model, one_body());
  expect_both(refused_workspace(1, 2));
}

TEST_P(DynamicsArguments, QuaternionsAreNotNormalisedInSilence) {
  for (const double w : {0.999, 0.0, nan}) {
    ask.q[3] = w;
    expect_both(refused_quaternion("ball"));
  }
}

TEST_P(DynamicsArguments, WhatIsNotANumberPassesThrough) {
  for (std::vector<double>* argument : {&ask.q, &ask.v, &ask.a}) {
    double& last = argument->back();  // of the elbow
    last = nan;
    EXPECT_TRUE(std::isnan(largest(torques())));
    EXPECT_TRUE(std::isnan(largest(wrenches())));
    last = 0;
  }
  const std::vector<AppliedWrench<>> loads{AppliedWrench<>(2, Wrench<Hybrid>{{nan, 0, 0}, {}})};
  ask.loads.wrenches = loads;
  EXPECT_TRUE(std::isnan(largest(torques())));
}

/// Calls every function of the equations of motion with one array of each name; `sizes` may be off.
struct EquationsOfMotionArguments : testing::Test {
  Model model = shoulder();  // nq = 5, nv = 4, two bodies
  Workspace<> workspace{model};
  std::vector<double> q{0, 0, 0, 1, 0}, v = std::vector<double>(4), a = v, tau = v, p = v;
  std::vector<double> out = v, out2 = v, matrix = std::vector<double>(16), tensor = std::vector<double>(64);
  std::vector<double> columns = std::vector<double>(80), energies = std::vector<double>(20),
                      six = std::vector<double>(36);
  std::vector<Twist<BodyFixed>> Y{4}, V{2};
  std::vector<TwistRate<BodyFixed>> dV{2};
  std::vector<Momentum<BodyFixed>> Pi{2};
  std::vector<Momentum<Spatial>> Pi_s{2};
  std::vector<Wrench<Spatial>> dPi{2};

  std::vector<std::function<void()>> calls{
      [this] { static_cast<void>(forward_dynamics(model, workspace, q, v, tau, out)); },
      [this] { mass_matrix(model, workspace, q, matrix); },
      [this] { static_cast<void>(inverse_mass_matrix(model, workspace, q, matrix)); },
      [this] { mass_matrix_partials(model, workspace, q, tensor); },
      [this] { static_cast<void>(inverse_mass_matrix_partials(model, workspace, q, tensor)); },
      [this] { coriolis_vector(model, workspace, q, v, out); },
      [this] { gravity_torques(model, workspace, q, out); },
      [this] { generalized_loads(model, workspace, q, v, {}, out); },
      [this] { coriolis_matrix(model, workspace, q, v, CoriolisForm::paper, matrix); },
      [this] { christoffel(model, workspace, q, tensor); },
      [this] { static_cast<void>(impulse_response(model, workspace, q, 1, Y)); },
      [this] { static_cast<void>(inverse_operational_space_inertia(model, workspace, q, 1, six)); },
      [this] { static_cast<void>(operational_space_inertia(model, workspace, q, 1, six)); },
      [this] { momenta(model, workspace, q, v, out); },
      [this] { static_cast<void>(momentum_form(model, workspace, q, p, tau, out, out2)); },
      [this] { body_momenta(model, workspace, q, v, Pi); },
      [this] { static_cast<void>(twist_form<BodyFixed>(model, workspace, q, V, tau, out, dV)); },
      [this] { static_cast<void>(spatial_momentum_form(model, workspace, q, Pi_s, tau, out, dPi)); },
      [this] { static_cast<void>(spatial_momentum(model, workspace, q, v)); },
      [this] { static_cast<void>(centroidal_momentum(model, workspace, q, v)); },
      [this] { static_cast<void>(kinetic_energy(model, workspace, q, v)); },
      [this] { static_cast<void>(potential_energy(model, workspace, q)); },
      [this] { static_cast<void>(centroidal_inertia(model, workspace, q)); },
      [this] { regressor(model, workspace, q, v, a, columns); },
      [this] { kinetic_energy_regressor(model, workspace, q, v, energies); },
      [this] { potential_energy_regressor(model, workspace, q, energies); },
  };
  /// What the calls that refuse say.
  std::set<std::string> refusals() {
    std::set<std::string> said;
    for (const auto& call : calls) {
      try {
        call();
      } catch (const std::invalid_argument& error) {
        said.insert(error.what());
      }
    }
    return said;
  }
};

TEST_F(EquationsOfMotionArguments, OfTheRightSizeAreTaken) { EXPECT_THAT(refusals(), testing::IsEmpty()); }

TEST_F(EquationsOfMotionArguments, OfTheWrongSizeAreNamed) {
  const auto off = [&](auto& argument, std::size_t size) {
    const auto before = argument;
    argument.resize(size);
    const std::set<std::string> said = refusals();
    argument = before;
    return said;
  };
  using testing::ElementsAre;
  EXPECT_THAT(off(q, 4), ElementsAre("q has 4 entries; expected nq = 5"));
  EXPECT_THAT(off(v, 3), ElementsAre("v has 3 entries; expected nv = 4"));
  EXPECT_THAT(off(a, 3), ElementsAre("a has 3 entries; expected nv = 4"));
  EXPECT_THAT(off(tau, 5), ElementsAre("tau has 5 entries; expected nv = 4"));
  EXPECT_THAT(off(p, 0), ElementsAre("p has 0 entries; expected nv = 4"));
  EXPECT_THAT(off(out2, 3), ElementsAre("dp has 3 entries; expected nv = 4"));
  EXPECT_THAT(off(V, 1), ElementsAre("V has 1 entries; expected n_bodies = 2"));
  EXPECT_THAT(off(dV, 3), ElementsAre("dV has 3 entries; expected n_bodies = 2"));
  EXPECT_THAT(off(Pi, 3), ElementsAre("Pi has 3 entries; expected n_bodies = 2"));
  EXPECT_THAT(off(Pi_s, 3), ElementsAre("Pi has 3 entries; expected n_bodies = 2"));
  EXPECT_THAT(off(dPi, 3), ElementsAre("dPi has 3 entries; expected n_bodies = 2"));
  EXPECT_THAT(off(out, 3),
              ElementsAre("C v has 3 entries; expected nv = 4", "Q has 3 entries; expected nv = 4",
                          "a has 3 entries; expected nv = 4", "g has 3 entries; expected nv = 4",
                          "p has 3 entries; expected nv = 4", "v has 3 entries; expected nv = 4"));
  EXPECT_THAT(off(matrix, 15), ElementsAre("C has 15 entries; expected nv * nv = 16",
                                           "M has 15 entries; expected nv * nv = 16",
                                           "M_inverse has 15 entries; expected nv * nv = 16"));
  EXPECT_THAT(off(tensor, 65), ElementsAre("Gamma has 65 entries; expected nv * nv * nv = 64",
                                           "dM has 65 entries; expected nv * nv * nv = 64",
                                           "dM^-1 has 65 entries; expected nv * nv * nv = 64"));
  EXPECT_THAT(off(Y, 3), ElementsAre("Y has 3 entries; expected nv = 4"));
  EXPECT_THAT(off(six, 6), ElementsAre("J M^-1 J^T has 6 entries; expected 6 * 6 = 36",
                                       "Lambda has 6 entries; expected 6 * 6 = 36"));
  EXPECT_THAT(off(columns, 40), ElementsAre("Y has 40 entries; expected nv * 10 * n_bodies = 80"));
  EXPECT_THAT(off(energies, 10), ElementsAre("y has 10 entries; expected 10 * n_bodies = 20"));
}

TEST_F(EquationsOfMotionArguments, AWorkspaceOfASmallerModelIsRefused) {
  workspace = Workspace<>(one_body());
  const std::set<std::string> said = refusals();
  ASSERT_EQ(said.size(), 1u);
  EXPECT_THAT(*said.begin(), testing::StartsWith("workspace: made for 1 bodies"));
}

TEST_F(EquationsOfMotionArguments, AWorkspaceKnowsOfCouplings) {
  Description description = model.description();
  for (int k = 0; k < 2; ++k) {
    BodyDescription finger{.name = "finger " + std::to_string(k), .predecessor = "forearm"};
    finger.joint = {.name = finger.name + " joint", .kind = JointKind::revolute};
    if (k == 1) finger.joint.coupling = Coupling{"finger 0 joint", 1, 0};
    finger.inertia = MassProperties{.mass = 0.1, .com = {0.01, 0, 0}, .Theta = {1e-4, 1e-4, 1e-4}};
    description.bodies.push_back(finger);
  }
  const Model coupled = ModelBuilder(description).build();
  Description free_fingers = description;
  free_fingers.bodies.back().joint.coupling.reset();
  Workspace<> other(ModelBuilder(free_fingers).build());
  std::vector<double> q5 = neutral(coupled), v5(5), a5(5);
  EXPECT_THROW(static_cast<void>(forward_dynamics(coupled, other, q5, v5, v5, a5)), std::invalid_argument);
  Workspace<> own(coupled);
  EXPECT_TRUE(forward_dynamics(coupled, own, q5, v5, v5, a5).ok());
}

TEST_F(EquationsOfMotionArguments, AMassMatrixThatIsSingularNamesTheJoint) {
  const Model massless =
      ModelBuilder("crane")
          .add({.name = "mast",
                .joint = {.name = "slew", .kind = JointKind::revolute},
                .inertia = MassProperties{.mass = 1, .com = {1, 0, 0}, .Theta = {1, 1, 1}}})
          .add({.name = "hook",
                .predecessor = "mast",
                .joint = {.name = "swivel", .kind = JointKind::revolute}})
          .build();
  Workspace<> own(massless);
  const std::vector<double> zero(2);
  std::vector<double> x(2), y(2), M(4);
  const Solvability solvability = forward_dynamics(massless, own, zero, zero, zero, x);
  ASSERT_FALSE(solvability.ok());
  EXPECT_EQ(to_string(massless, solvability),
            "the mass matrix is singular: with the other joints free, joint \"swivel\" of body \"hook\" "
            "moves no mass; mass or armature helps, or a joint that is locked, see reduced");
  EXPECT_TRUE(std::isnan(x[0]) && std::isnan(x[1]));
  EXPECT_EQ(inverse_mass_matrix(massless, own, zero, M).singular_body, 2);
  MassMatrixFactor<> factor(massless);
  mass_matrix(massless, own, zero, M);
  EXPECT_EQ(factor.factorize(M).singular_body, 2);
  EXPECT_EQ(momentum_form(massless, own, zero, zero, zero, x, y).singular_body, 2);
}

}  // namespace
}  // namespace axode::test
