#include <cmath>
#include <functional>

#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// The functions that have no row of the catalogue refuse wrong arguments and accept NaN. The same laws for
/// all rows are in EveryFunction.
namespace axode::test {
namespace {

class DynamicsArguments : public Law {};
INSTANTIATE_TEST_SUITE_P(Dynamics, DynamicsArguments, testing::ValuesIn(cases()), name_of);

TEST_P(DynamicsArguments, PassThroughWhereTheyAreNotNumbers) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const Model model = shoulder();
  const auto subject = test::subject(GetParam(), model);
  Ask ask{.q = {0, 0, 0, 1, 0}, .v = {0, 0, 0, 0}, .a = {0, 0, 0, 0}};
  const auto is_none = [&](const char* function) {
    return std::isnan(largest(subject->call(function, ask).numbers));
  };
  const auto of_the_forearm_alone = [&](const char* function) {  // the results for the ground and two bodies
    const std::vector<double> all = subject->call(function, ask).numbers;
    const auto end = all.end() - static_cast<std::ptrdiff_t>(all.size() / 3);
    return !std::isnan(largest({all.begin(), end})) && std::isnan(largest({end, all.end()}));
  };
  for (std::vector<double>* const argument : {&ask.q, &ask.v, &ask.a}) {
    double& last = argument->back();  // the number of the elbow
    last = nan;
    EXPECT_TRUE(is_none("inverse_dynamics"));
    EXPECT_TRUE(is_none("joint_wrenches"));
    if (argument == &ask.q) {
      EXPECT_TRUE(of_the_forearm_alone("poses"));
    }
    if (argument == &ask.v) {
      EXPECT_TRUE(of_the_forearm_alone("twists"));
    }
    EXPECT_TRUE(of_the_forearm_alone("accelerations"));
    last = 0;
  }
  const std::vector<AppliedWrench<>> loads{AppliedWrench<>(2, Wrench<Hybrid>{{nan, 0, 0}, {}})};
  ask.loads.wrenches = loads;
  EXPECT_TRUE(is_none("inverse_dynamics"));
}

TEST(DynamicsArgument, FormsOfTheStateOfBodiesNameTheirOwn) {
  const Model model = shoulder(), other = one_body();
  const std::vector<double> q{0, 0, 0, 1, 0};
  std::vector<double> tau(4), v(4);
  std::vector<Twist<BodyFixed>> V{2};
  std::vector<TwistRate<BodyFixed>> dV{2};
  std::vector<Momentum<Spatial>> Pi{2};
  std::vector<Wrench<Spatial>> dPi{2};
  Workspace<> own(model), foreign(other);
  Workspace<>* workspace = &own;
  const std::function<void()> by_twists = [&] {
    static_cast<void>(twist_form<BodyFixed>(model, *workspace, q, V, tau, v, dV));
  };
  const std::function<void()> by_momenta = [&] {
    static_cast<void>(spatial_momentum_form(model, *workspace, q, Pi, tau, v, dPi));
  };
  EXPECT_NO_THROW(by_twists());
  EXPECT_NO_THROW(by_momenta());
  const auto off = [&](auto& argument, std::size_t size, const auto& call, const Refusal& refusal) {
    const auto before = argument;
    argument.resize(size);
    EXPECT_THAT(call, refusal);
    argument = before;
  };
  off(V, 1, by_twists, refused("V", 1, "n_bodies", 2));
  off(dV, 3, by_twists, refused("dV", 3, "n_bodies", 2));
  off(Pi, 3, by_momenta, refused("Pi", 3, "n_bodies", 2));
  off(dPi, 3, by_momenta, refused("dPi", 3, "n_bodies", 2));
  for (const auto* const call : {&by_twists, &by_momenta}) {
    off(tau, 5, *call, refused("tau", 5, "nv", 4));
    off(v, 3, *call, refused("v", 3, "nv", 4));
    workspace = &foreign;
    EXPECT_THAT(*call, refused_workspace(1, 2));
    workspace = &own;
  }
}

TEST(DynamicsArgument, AWorkspaceKnowsOfCouplings) {
  Description description = shoulder().description();
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

TEST(DynamicsArgument, AMassMatrixThatIsSingularNamesTheJoint) {
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
            "moves no mass; give it mass, give the joint armature, or lock the joint, see reduced");
  EXPECT_TRUE(std::isnan(x[0]) && std::isnan(x[1]));
  EXPECT_EQ(inverse_mass_matrix(massless, own, zero, M).singular_body, 2);
  MassMatrixFactor<> factor(massless);
  mass_matrix(massless, own, zero, M);
  EXPECT_EQ(factor.factorize(M).singular_body, 2);
  EXPECT_EQ(momentum_form(massless, own, zero, zero, zero, x, y).singular_body, 2);
}

}  // namespace
}  // namespace axode::test
