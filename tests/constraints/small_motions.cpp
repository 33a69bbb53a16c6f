#include <gmock/gmock.h>

#include "axode/constraints/assembly.hpp"
#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/constraints/equilibrium.hpp"
#include "axode/constraints/independent/independent_equations.hpp"
#include "axode/constraints/independent/independent_linearization.hpp"
#include "axode/dynamics.hpp"
#include "axode/kinematics.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/laws/law.hpp"

/// Small motions and equilibria of mechanisms with loops.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;
using Eigen::MatrixXd, Eigen::VectorXd;

struct DrawnMechanism {
  const char* name;
  Description (*drawn)();
};
Description sprung(Description d) {
  for (BodyDescription& body : d.bodies)
    body.joint.dof.assign(static_cast<std::size_t>(traits(body.joint.kind).dof), {.damping = 0.6});
  d.bodies[2].joint.dof = {{.damping = 0.4, .stiffness = 3, .rest = 0.2}};
  d.springs.push_back({.between = {"ground", d.bodies.back().name},
                       .points = {Vec3<>{0.3, 2, 0.1}, Vec3<>{0.5, 0.4, 0.9}},
                       .stiffness = 20,
                       .rest = 0.4,
                       .damping = 0.7});
  return d;
}
const DrawnMechanism drawn_mechanisms[] = {{"FourBar", [] { return sprung(four_bar()); }},
                                           {"Bricard", [] { return sprung(bricard()); }},
                                           {"SliderCrank", [] { return sprung(slider_crank()); }},
                                           {"Gough", [] { return sprung(gough()); }}};

VectorXd of(const std::vector<int>& velocities, const VectorXd& x) { return x(velocities); }

class SmallMotions : public testing::TestWithParam<DrawnMechanism> {
 protected:
  const Model model = ModelBuilder(GetParam().drawn()).build();
  LoopWorkspace<double> loops{model};
  Workspace<double> workspace{model, cut_tree};
  const Numbers still = Numbers(static_cast<std::size_t>(model.nv()));

  Numbers closed(const Numbers& near, std::span<const int> held = {}) const {
    AssemblyResult found = assemble(model, near, {}, {.held = held});
    EXPECT_EQ(found.status, AssemblyStatus::closed) << to_string(model, found);
    return found.q;
  }
  VectorXd accelerations(const Numbers& q, const Numbers& v, const Numbers& tau, const Loads<>& loads) {
    Numbers forces = tau, a(v.size());
    add_spring_forces(model, workspace, q, v, forces);
    EXPECT_TRUE(forward_dynamics(model, loops, q, v, forces, a, {}, loads).ok());
    return vector(a);
  }
};

/// The lower half of ẋ = A x + B δτ gives the change of accelerations from a moving state to closed states in
/// its neighbourhood.
TEST_P(SmallMotions, HaveAccelerationsOfClosedNeighbours) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Random<double> random(seed);
    const Numbers q = closed(integrate(model, neutral(model), random_numbers(random, model.nv(), 0.1)));
    const IndependentEquations y = independent_equations(model, q, still);
    const auto k = static_cast<int>(y.velocities.size());
    const VectorXd rate = vector(random_numbers(random, k));
    const Numbers v = numbers(y.N * rate), tau = random_numbers(random, model.nv(), 10);
    State<double> pushed = random_state(model, random);
    const Loads<> loads{pushed.wrenches, seed % 2 == 1};
    const IndependentLinearization linear = independent_linearization(model, q, v, tau, y.velocities, loads);
    ASSERT_TRUE(linear.solvability.ok());
    ASSERT_EQ(linear.velocities, y.velocities);
    EXPECT_LT(largest_entry(linear.N - y.N), 1e-9);

    VectorXd x(2 * k);
    x << vector(random_numbers(random, k)), vector(random_numbers(random, k));
    const Numbers dtau = random_numbers(random, model.nv());
    VectorXd velocities_rate;
    const auto lower = [&](double t) -> VectorXd {
      const Numbers q_t = closed(integrate(model, q, numbers(t * (linear.N * x.head(k)))), linear.velocities);
      const MatrixXd N_t = independent_equations(model, q_t, Numbers(v.size()), linear.velocities).N;
      const VectorXd v_t = N_t * (rate + t * x.tail(k));
      velocities_rate = v_t;
      return of(linear.velocities,
                accelerations(q_t, numbers(v_t), numbers(vector(tau) + t * vector(dtau)), loads));
    };
    const double h = 1e-4;
    VectorXd change = VectorXd::Zero(k), change_of_v = VectorXd::Zero(model.nv());
    for (const auto& [t, weight] : {std::pair{h, 8.0}, {-h, -8.0}, {2 * h, -1.0}, {-2 * h, 1.0}}) {
      change += weight / (12 * h) * lower(t);
      change_of_v += weight / (12 * h) * velocities_rate;
    }
    const VectorXd said = (linear.A * x + linear.B * vector(dtau)).tail(k);
    EXPECT_LT((said - change).norm(), 1e-6 * (1 + change.norm()));
    const VectorXd said_v = linear.N * x.tail(k) + linear.D * x.head(k);
    EXPECT_LT((said_v - change_of_v).norm(), 1e-6 * (1 + change_of_v.norm()));
  }
}

/// The upper half gives the rate of a displacement while both motions go on.
TEST_P(SmallMotions, HaveDisplacementsThatGoOn) {
  Random<double> random(5);
  const Numbers q = closed(integrate(model, neutral(model), random_numbers(random, model.nv(), 0.1)));
  const IndependentEquations y = independent_equations(model, q, still);
  const auto k = static_cast<int>(y.velocities.size());
  const Numbers v = numbers(y.N * vector(random_numbers(random, k)));
  const IndependentLinearization linear =
      independent_linearization(model, q, v, Numbers(v.size()), y.velocities);
  VectorXd x(2 * k);
  x << vector(random_numbers(random, k)), vector(random_numbers(random, k));
  const VectorXd apart = linear.N * x.head(k), faster = linear.N * x.tail(k) + linear.D * x.head(k);
  const double h = 1e-3;
  const auto later = [&](double t, double e) {
    const Numbers other = integrate(model, q, numbers(e * apart));
    return VectorXd(vector(difference(model, integrate(model, q, numbers(t * vector(v))),
                                      integrate(model, other, numbers(t * (vector(v) + e * faster))))) /
                    e);
  };
  const auto rate = [&](double e) -> VectorXd { return (later(h, e) - later(-h, e)) / (2 * h); };
  const VectorXd change = of(linear.velocities, (rate(h) + rate(-h)) / 2);
  EXPECT_LT(((linear.A * x).head(k) - change).norm(), 1e-5 * (1 + change.norm()));
}

TEST_P(SmallMotions, ComeToRestWhereForcesHoldThem) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Random<double> random(seed);
    const Numbers there = closed(integrate(model, neutral(model), random_numbers(random, model.nv(), 0.1)));
    Numbers tau = still, springs = still;
    inverse_dynamics(model, workspace, there, still, still, tau);
    spring_forces(model, workspace, there, still, springs);
    tau = numbers(vector(tau) - vector(springs));
    const EquilibriumResult found =
        equilibrium(model, integrate(model, there, random_numbers(random, model.nv(), 0.02)), tau);
    EXPECT_EQ(found.status, EquilibriumStatus::solved) << found.residual;
    EXPECT_LE(found.iterations, 8);
    EXPECT_LT(accelerations(found.q, still, tau, {}).norm(), 1e-7);
    Numbers r(static_cast<std::size_t>(model.loops().residuals));
    loop_residual(model, loops, found.q, r);
    EXPECT_LT(vector(r).norm(), 1e-10);
  }
}

INSTANTIATE_TEST_SUITE_P(, SmallMotions, testing::ValuesIn(drawn_mechanisms),
                         [](const auto& info) { return std::string(info.param.name); });

/// Two cranks of length 1 that hang from the ground, with a coupler between them. It swings like a pendulum
/// whose frequency is known.
Model parallelogram() {
  const Vec3<> z{0, 0, 1};
  return ModelBuilder(ring({{0, 0, 0}, {0, -1, 0}, {2, -1, 0}, {2, 0, 0}}, {z, z, z, z})).build();
}

TEST(SmallMotionsOfAParallelogram, HaveTheFrequencyOnPaper) {
  const Model model = parallelogram();
  const Numbers q = neutral(model), still(3);
  const double of_a_crank = 1.01 / 12 + 0.25, squared = 2 * 9.81 / (2 * of_a_crank + 1);
  for (const int velocity : {0, 1, 2}) {  // the result does not depend on which velocity is the independent
                                          // one
    const IndependentLinearization linear =
        independent_linearization(model, q, still, still, std::array{velocity});
    EXPECT_NEAR(linear.A(1, 0), -squared, 1e-10);
    EXPECT_NEAR(linear.A(1, 1), 0, 1e-12);
    EXPECT_LT(largest_entry(linear.D), 1e-12);
  }
}

TEST(SmallMotionsOfAParallelogram, SwingAboutTheEquilibriumThatIsFound) {
  const Model model = parallelogram();
  const AssemblyResult tilted = assemble(model, Numbers{0.9, -0.9, 0.9}, {}, {.held = std::array{0}});
  ASSERT_EQ(tilted.status, AssemblyStatus::closed);
  const EquilibriumResult found = equilibrium(model, tilted.q);
  EXPECT_EQ(found.status, EquilibriumStatus::solved);
  EXPECT_LT(vector(found.q).norm(), 1e-8);
}

TEST(SmallMotionsOfAParallelogram, AreRefusedInWords) {
  const Model model = parallelogram();
  const Numbers q = neutral(model), still(3);
  EXPECT_THAT([&] { (void)independent_linearization(model, q, still, Numbers(2)); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("tau")));
  EXPECT_THAT(
      [&] {
        (void)independent_linearization(model, q, still, still, std::array{0, 1});
      },
      testing::ThrowsMessage<std::invalid_argument>(
          "velocities holds 2; the loops leave 1 independent here"));
}

TEST(Equilibria, OfLoopsThatDoNotCloseAreOpen) {
  Description d = slider_crank();
  d.loops[0].frames = {SE3<>{{}, {2, 0, 0}}, SE3<>{{}, {2, 9, 0}}};  // nine metres off the slider's axis
  const Model model = ModelBuilder(d).build();
  const EquilibriumResult found = equilibrium(model, neutral(model));
  EXPECT_EQ(found.status, EquilibriumStatus::open);
  EXPECT_EQ(to_string(found.status), "open");
}

}  // namespace
}  // namespace axode::test
