#include <map>

#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/dynamics.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/random_loops.hpp"
#include "tests/support/series.hpp"

/// Laws of the functions that count loops, on mechanisms with loops of all kinds, some of them redundant.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;
using Eigen::MatrixXd, Eigen::VectorXd;

/// A mechanism with loops and the Jacobian A of its loops at its state.
struct Closed : ClosedMechanism {
  explicit Closed(std::uint64_t seed)
      : Closed(Random<double>(seed), elsewhere(seed, {.most_bodies = 12, .loops = 1})) {}
  Closed(Random<double> random, const TreeRecipe& recipe)
      : ClosedMechanism(closed_mechanism(random, recipe)),
        longest(std::max(1.0, recipe.scale)),
        loops(model) {
    Numbers all(rows() * state.v.size());
    loop_jacobian(model, loops, state.q, all);
    A = matrix(static_cast<int>(rows()), all);
  }
  std::size_t rows() const { return static_cast<std::size_t>(model.loops().rows); }
  /// An estimate of the size of the terms in the balance of forces, which may cancel each other, for
  /// multipliers lambda.
  double size_of_forces(const Numbers& lambda) {
    Workspace<double> workspace(model, cut_tree);
    Numbers M(state.v.size() * state.v.size());
    mass_matrix(model, workspace, state.q, M);
    return std::max({largest(tau), largest(M) * largest(state.a), largest_entry(A) * largest(lambda)});
  }

  double longest;  ///< the order of the lengths, at least 1 m
  LoopWorkspace<double> loops;
  MatrixXd A;
};

TEST(Loops, AreClosedAndStayClosed) {
  Comparison residual("r", 1e-12), velocities("A v", 1e-9), accelerations("A a + γ", 1e-9);
  std::map<LoopKind, int> seen;
  std::size_t couplings = 0;
  for_seeds(200, [&](std::uint64_t seed) {
    Closed closed(seed);
    const auto& [q, v, a, wrenches] = closed.state;
    Numbers r(static_cast<std::size_t>(closed.model.loops().residuals)), gamma(closed.rows());
    loop_residual(closed.model, closed.loops, q, r);
    residual.expect_equal(r, Numbers(r.size()), closed.longest);
    velocities.expect_equal(VectorXd(closed.A * vector(v)), VectorXd(VectorXd::Zero(closed.A.rows())),
                            std::max(1.0, largest_entry(closed.A)));
    loop_bias(closed.model, closed.loops, q, v, gamma);
    accelerations.expect_equal(VectorXd(closed.A * vector(a) + vector(gamma)),
                               VectorXd(VectorXd::Zero(closed.A.rows())),
                               std::max({largest(gamma), largest_entry(closed.A) * largest(a), 1.0}));
    for (const Loop& loop : closed.model.loops().joints) ++seen[loop.kind];
    couplings += closed.model.loops().couplings.size();
  });
  EXPECT_GT(couplings, 0u);
  for (const LoopTraits& kind : loop_kinds) EXPECT_GT(seen[kind.kind], 0) << kind.name;
}

TEST(Loops, DrivesLoadsAndMultipliersMakeTheAccelerations) {
  Comparison forces("τ + Aᵀ λ", 1e-9);
  for_seeds(200, [&](std::uint64_t seed) {
    Closed closed(seed);
    const auto& [q, v, a, wrenches] = closed.state;
    Numbers lambda(closed.rows()), a_again(a.size()), needed(a.size());
    ASSERT_TRUE(
        forward_dynamics(closed.model, closed.loops, q, v, closed.tau, a_again, lambda, closed.state.loads())
            .ok());
    Workspace<double> workspace(closed.model, cut_tree);
    inverse_dynamics(closed.model, workspace, q, v, a_again, needed, closed.state.loads());
    const VectorXd by_loops = closed.A.transpose() * vector(lambda);
    forces.expect_equal(VectorXd(vector(closed.tau) + by_loops), vector(needed),
                        closed.size_of_forces(lambda));
  });
}

TEST(Loops, DoNoWork) {
  Comparison power("power", 1e-8);
  for_seeds(200, [&](std::uint64_t seed) {
    Closed closed(seed);
    const auto& [q, v, a, wrenches] = closed.state;
    Workspace<double> workspace(closed.model, cut_tree);
    Numbers fed(wrenches.size());
    load_powers(closed.model, workspace, q, v, closed.state.loads(), fed);
    double sum = 0, scale = closed.size_of_forces({}) * largest(v);
    const auto feed = [&](double P) { sum += P, scale = std::max(scale, std::abs(P)); };
    for (std::size_t c = 0; c < v.size(); ++c) feed(closed.tau[c] * v[c]);
    for (const double P : fed) feed(P);
    power.expect_equal(sum, rate_of_energy(Representation::body, closed.model, closed.state), scale);
  });
}

// In mechanisms of millimetres the entries of A and of the velocities differ most in size.
TEST(Loops, InverseDynamicsFindsTheLeastDrivesThatMakeTheAccelerations) {
  Comparison accelerations("a", 1e-7), drives("tau", 1e-8);
  int with_passive = 0;
  for_seeds(1000, [&](std::uint64_t seed) {
    Closed closed(Random<double>(seed), {.loops = 1, .scale = 1e-3});
    const auto& [q, v, a, wrenches] = closed.state;
    const Loads<> loads = closed.state.loads();
    const std::vector<char>& driven = closed.model.loops().driven;
    Numbers tau(a.size()), a_again(a.size()), tau_again(a.size());
    EXPECT_LT(inverse_dynamics(closed.model, closed.loops, q, v, a, tau, {}, {}, loads), 1e-9);
    for (std::size_t c = 0; c < tau.size(); ++c) EXPECT_TRUE(driven[c] || tau[c] == 0);
    EXPECT_LE(vector(tau).norm(), vector(closed.tau).norm() * (1 + 1e-9));
    ASSERT_TRUE(forward_dynamics(closed.model, closed.loops, q, v, tau, a_again, {}, loads).ok());
    accelerations.expect_equal(a_again, a, 1);
    EXPECT_LT(inverse_dynamics(closed.model, closed.loops, q, v, a_again, tau_again, {}, {}, loads), 1e-9);
    drives.expect_equal(tau_again, tau);
    with_passive += std::ranges::count(driven, 0) > 0;
  });
  EXPECT_GT(with_passive, 0);
}

TEST(Loops, ThatOthersImplyChangeNoMotion) {
  Comparison accelerations("a", 1e-7);
  int redundant = 0;
  for_seeds(200, [&](std::uint64_t seed) {
    Closed closed(seed);
    Description once = closed.description;
    std::erase_if(once.loops, [](const LoopDescription& loop) {
      return loop.name.ends_with(" again") || loop.name.starts_with("restated ");
    });
    if (once.loops.size() == closed.description.loops.size()) return;
    ++redundant;
    const Model model = ModelBuilder(once).build();
    LoopWorkspace<double> loops(model);
    Numbers a(closed.state.a.size());
    ASSERT_TRUE(forward_dynamics(model, loops, closed.state.q, closed.state.v, closed.tau, a, {},
                                 closed.state.loads())
                    .ok());
    accelerations.expect_equal(a, closed.state.a, 1);
  });
  EXPECT_GT(redundant, 5);
}

}  // namespace
}  // namespace axode::test
