#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <numbers>

#include "axode/derivatives.hpp"
#include "axode/dynamics.hpp"
#include "axode/eigen.hpp"
#include "axode/io.hpp"
#include "tests/support/refused_arguments.hpp"

/// Linear systems that are known from textbooks, and equilibria.
namespace axode::test {
namespace {

constexpr double gravity = 9.81;
using Numbers = std::vector<double>;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct System {
  Matrix A, B;
};
System linearized(const Model& model, const Numbers& q, const Numbers& v, const Loads<>& loads = {}) {
  System linear{Matrix(2 * model.nv(), 2 * model.nv()), Matrix(2 * model.nv(), model.nv())};
  Workspace<> workspace(model);
  const Numbers tau(v.size());
  EXPECT_TRUE(linearize(model, workspace, q, v, tau, {as_span(linear.A), as_span(linear.B)}, loads).ok());
  return linear;
}
Matrix square(int n, std::initializer_list<double> entries) {
  Matrix out(n, n);
  std::copy(entries.begin(), entries.end(), out.data());
  return out;
}

/// A pendulum with a mass m on a rod of length l and a rotor of inertia I on its hinge.
Model pendulum(double m, double l, double I, double damping) {
  return ModelBuilder()
      .add({.name = "bob",
            .joint = {.name = "hinge",
                      .kind = JointKind::revolute,
                      .axis = {0, -1, 0},
                      .dof = {{.damping = damping, .armature = I}}},
            .inertia = MassProperties{.mass = m, .com = {0, 0, -l}}})
      .build();
}

TEST(Linearization, OfAPendulumHasItsFrequencyAndItsDampingRatio) {
  const double m = 2, l = 0.5, I = 0.3, d = 0.7, J = m * l * l + I;
  const Model model = pendulum(m, l, I, d);
  const double omega = std::sqrt(m * gravity * l / J), zeta = d / (2 * J * omega);
  const System free = linearized(model, {0}, {0}),
               damped = linearized(model, {0}, {0}, {.joint_losses = true});
  EXPECT_TRUE(free.A.isApprox(square(2, {0, 1, -omega * omega, 0}), 1e-14));
  EXPECT_NEAR(free.B(1, 0), 1 / J, 1e-15);
  EXPECT_EQ(free.B(0, 0), 0);
  const std::complex<double> lambda = damped.A.eigenvalues()[0];
  EXPECT_NEAR(std::abs(lambda), omega, 1e-13);
  EXPECT_NEAR(-lambda.real() / std::abs(lambda), zeta, 1e-14);
  const System upright = linearized(model, {std::numbers::pi}, {0});
  EXPECT_NEAR(upright.A(1, 0), omega * omega, 1e-13);
}

/// A body that moves freely in space without gravity.
Model drifting() {
  return ModelBuilder()
      .gravity({0, 0, 0})
      .add({.name = "body",
            .joint = {.kind = JointKind::free},
            .inertia = MassProperties{.mass = 3, .Theta = {1, 2, 3, 0, 0, 0}}})
      .build();
}

TEST(Linearization, OfABodyThatDriftsIsNilpotent) {
  const Model model = drifting();
  const System linear = linearized(model, neutral(model), Numbers(6));
  Matrix expected = Matrix::Zero(12, 12);
  expected.topRightCorner(6, 6).setIdentity();
  EXPECT_EQ(linear.A, expected);
  EXPECT_EQ(linear.A * linear.A, Matrix::Zero(12, 12));
}

TEST(Linearization, OfABodyThatSpinsHasTheBracketsOfItsTwist) {  // Euler's equations about a principal axis
  const Model model = drifting();
  const double spin = 2;
  const System linear = linearized(model, neutral(model), {0, 0, spin, 0, 0, 0});
  Matrix ad = Matrix::Zero(6, 6);
  for (const int half : {0, 3}) ad(half, half + 1) = -spin, ad(half + 1, half) = spin;
  EXPECT_EQ(Matrix(linear.A.topLeftCorner(6, 6)), Matrix(-ad));
  // ω_x' = (Θ_y - Θ_z)/Θ_x ω_y ω_z, ω_y' = (Θ_z - Θ_x)/Θ_y ω_z ω_x
  EXPECT_NEAR(linear.A(6, 7), (2 - 3) / 1.0 * spin, 1e-15);
  EXPECT_NEAR(linear.A(7, 6), (3 - 1) / 2.0 * spin, 1e-15);
  EXPECT_TRUE(linear.A.bottomLeftCorner(6, 6).isZero(0));
}

// ----------------------------------------------------------------------------------------------- equilibrium

using enum EquilibriumStatus;

Model example(const std::string& file, Base base = Base::as_described) {
  return load(AXODE_SOURCE_DIR "/examples/robots/" + file, base);
}

/// The largest force that is missing for an equilibrium at a configuration.
double residual_of(const Model& model, const Numbers& q, const Numbers& tau, const Loads<>& loads = {}) {
  Workspace<> workspace(model);
  const Numbers rest(tau.size());
  Eigen::VectorXd r(model.nv());
  inverse_dynamics(model, workspace, q, rest, rest, as_span(r), loads);
  return (r - as_eigen(std::span<const double>(tau))).norm();
}

TEST(Equilibrium, OfADoublePendulumHangsOrStandsOnItsHead) {
  const Model model = example("double_pendulum.toml");
  const double pi = std::numbers::pi;
  const std::vector<std::pair<Numbers, Numbers>> found_from{
      {{0, 0}, {0.4, -0.3}}, {{pi, 0}, {2.8, 0.2}}, {{0, pi}, {0.1, 3}}, {{pi, -pi}, {3, -3}}};
  for (const auto& [expected, q0] : found_from) {
    const EquilibriumResult found = equilibrium(model, q0);
    EXPECT_EQ(found.status, solved);
    EXPECT_LE(found.iterations, 10);
    EXPECT_NEAR(found.q[0], expected[0], 1e-9);
    EXPECT_NEAR(found.q[1], expected[1], 1e-9);
    EXPECT_LE(residual_of(model, found.q, {0, 0}), 1e-9);
  }
}

TEST(Equilibrium, IsWhereTheForcesThatThereAreHoldTheArm) {
  const Model arm = example("arm7.toml");
  int found_near = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Numbers goal = random_configuration(arm, seed), rest(7);
    const AppliedWrench<> weight(arm.frame_index("flange"), Representation::hybrid, {}, {0, 0, -50});
    const Loads<> loads{{&weight, 1}};
    Workspace<> workspace(arm);
    Numbers tau(7), q0(goal);
    inverse_dynamics(arm, workspace, goal, rest, rest, tau, loads);
    for (double& angle : q0) angle += 0.02;
    const EquilibriumResult found = equilibrium(arm, q0, tau, loads);
    EXPECT_EQ(found.status == solved, found.residual <= 1e-9) << seed;
    EXPECT_NEAR(found.residual, residual_of(arm, found.q, tau, loads), 1e-12) << seed;
    found_near += found.status == solved;
  }
  EXPECT_GE(found_near, 195);
}

TEST(Equilibrium, OfMechanismsOfEveryKindIsFoundAgain) {
  const Model machine = example("machine.toml", Base::fixed);
  const Numbers goal = random_configuration(machine, 3), rest(static_cast<std::size_t>(machine.nv()));
  Workspace<> workspace(machine);
  Numbers tau(rest);
  gravity_torques(machine, workspace, goal, tau);
  const Numbers q0 = integrate(machine, goal, Numbers(rest.size(), 0.05));
  const EquilibriumResult found = equilibrium(machine, q0, tau);
  EXPECT_EQ(found.status, solved);
  EXPECT_LE(residual_of(machine, found.q, tau), 1e-9);
}

TEST(Equilibrium, IsAskedForInVainWhereThereIsNone) {
  const Model humanoid = example("humanoid.urdf", Base::free);
  const EquilibriumResult falling = equilibrium(humanoid, neutral(humanoid));
  EXPECT_EQ(falling.status, stalled);
  EXPECT_NEAR(falling.residual, humanoid.total_mass() * gravity, 1);
  const Model pendulum = test::pendulum(1, 1, 0, 0);
  EXPECT_EQ(equilibrium(pendulum, Numbers{0.3}, Numbers{10}).status, stalled);  // m g l = 9.81
  EXPECT_EQ(equilibrium(pendulum, Numbers{0.3}, {}, {}, {.iterations = 1}).status, iteration_limit);
}

TEST(Equilibrium, StaysWhereItIs) {
  const Model body = drifting();
  const Numbers q0 = random_configuration(body, 5);
  const EquilibriumResult found = equilibrium(body, q0);
  EXPECT_EQ(found.status, solved);
  EXPECT_EQ(found.iterations, 0);
  EXPECT_EQ(found.q, q0);
}

TEST(Equilibrium, OfWhatMakesNoSenseIsRefused) {
  const Model model = pendulum(1, 1, 0, 0);
  const auto of = [&](const Numbers& q0, const Numbers& tau, EquilibriumOptions options = {}) {
    return message_of([&] { (void)equilibrium(model, q0, tau, {}, options); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(of({0, 0}, {}), "q0 has 2 entries; expected nq = 1");
  EXPECT_EQ(of({0}, {0, 0}), "tau has 2 entries; expected nv = 1");
  EXPECT_EQ(of({nan}, {}), "equilibrium: q0 is not finite");
  EXPECT_EQ(of({0}, {nan}), "equilibrium: tau is not finite");
  EXPECT_EQ(of({0}, {}, {.tolerance = 0}), "equilibrium: tolerance is 0; it must be positive");
  EXPECT_EQ(of({0}, {}, {.iterations = 0}), "equilibrium: iterations is 0; it must be positive");
  const AppliedWrench<> push(7, Representation::body, {}, {});
  EXPECT_THAT(message_of([&] {
                (void)equilibrium(model, Numbers{0}, {}, {{&push, 1}});
              }),
              testing::HasSubstr("7"));
}

}  // namespace
}  // namespace axode::test
