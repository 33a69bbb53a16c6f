#include "tests/model/random_loops.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/constraints/loop_system/independent_rows.hpp"
#include "axode/dynamics.hpp"
#include "tests/laws/law.hpp"

/// Loops of all kinds and couplings on random trees, in configurations where the loops are not closed.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;
using Eigen::MatrixXd, Eigen::VectorXd;

/// A random tree with loops of all kinds, or with one of these if there shall be `few`. The rows of a single
/// loop are mostly independent.
struct LoopedTree {
  explicit LoopedTree(std::uint64_t seed, bool few = false)
      : random(seed),
        model([&] {
          Description d = with_loops(described(random_mechanism(random, {.most_bodies = 8}), random), random);
          if (few && !d.loops.empty()) {
            d.loops = {d.loops[seed / 2 % d.loops.size()]};
            d.couplings.clear();
          }
          return ModelBuilder(d).build();
        }()),
        loops(model),
        q(random_configuration(model, seed)),
        v(random_numbers(random, model.nv())) {}
  std::size_t rows() const { return static_cast<std::size_t>(model.loops().rows); }
  std::size_t residuals() const { return static_cast<std::size_t>(model.loops().residuals); }

  /// The configuration after the time t with constant velocities, so that a = 0.
  Numbers moved(double t) const { return integrate(model, q, numbers(t * vector(v))); }
  template <class F> VectorXd difference(const F& f) const {
    const double h = 1e-3;
    return (8 * (f(moved(h)) - f(moved(-h))) - (f(moved(2 * h)) - f(moved(-2 * h)))) / (12 * h);
  }

  Random<double> random;
  Model model;
  LoopWorkspace<double> loops;
  Numbers q, v;
};

TEST(RandomLoops, BiasIsTheRateOfTheRows) {
  for_seeds(60, [](std::uint64_t seed) {
    LoopedTree tree(seed);
    Numbers gamma(tree.rows()), A(tree.rows() * tree.v.size());
    const VectorXd slip = tree.difference([&](const Numbers& there) {
      loop_jacobian(tree.model, tree.loops, there, A);
      return VectorXd(matrix(static_cast<int>(tree.rows()), A) * vector(tree.v));
    });
    loop_bias(tree.model, tree.loops, tree.q, tree.v, gamma);
    for (std::size_t k = 0; k < gamma.size(); ++k)
      EXPECT_NEAR(gamma[k], slip[static_cast<Eigen::Index>(k)], 1e-7 * (1 + slip.cwiseAbs().maxCoeff())) << k;
  });
}

TEST(RandomLoops, ResidualsHaveTheirRates) {
  int seen = 0;
  for_seeds(60, [&](std::uint64_t seed) {
    LoopedTree tree(seed);
    Numbers r(tree.residuals()), R(tree.residuals() * tree.v.size());
    const VectorXd rate = tree.difference([&](const Numbers& there) {
      loop_residual(tree.model, tree.loops, there, r);
      return vector(r);
    });
    loop_residual(tree.model, tree.loops, tree.q, r);
    loop_residual_jacobian(tree.model, tree.loops, tree.q, R);
    const VectorXd said = matrix(static_cast<int>(r.size()), R) * vector(tree.v);
    for (const LoopRows& loop : tree.model.loops().all) {
      const VectorXd own = vector(r).segment(loop.first_residual, loop.residuals);
      if (own.norm() > 1.5) continue;  // the residual may jump where it is half a turn or half a lead
      ++seen;
      EXPECT_LT((said - rate).segment(loop.first_residual, loop.residuals).norm(), 1e-6 * (1 + said.norm()))
          << loop.name;
    }
  });
  EXPECT_GE(seen, 5);
}

TEST(RandomLoops, HessianProductsAreRatesOfJacobians) {
  int seen = 0;
  for_seeds(60, [&](std::uint64_t seed) {
    LoopedTree tree(seed);
    Numbers lambda = random_numbers(tree.random, static_cast<int>(tree.residuals()), 1);
    Numbers r(tree.residuals()), R(tree.residuals() * tree.v.size()), product(tree.v.size());
    loop_residual(tree.model, tree.loops, tree.q, r);
    for (const LoopRows& loop : tree.model.loops().all) {
      const bool jumps = vector(r).segment(loop.first_residual, loop.residuals).norm() > 1.5;
      for (int k = 0; k < loop.residuals; ++k)  // the residual jumps where it is half a turn or half a lead
        if (jumps) lambda[static_cast<std::size_t>(loop.first_residual + k)] = 0;
      seen += !jumps;
    }
    const VectorXd rate = tree.difference([&](const Numbers& there) {
      loop_residual_jacobian(tree.model, tree.loops, there, R);
      return VectorXd(matrix(static_cast<int>(r.size()), R).transpose() * vector(lambda));
    });
    loop_hessian_product(tree.model, tree.loops, tree.q, lambda, tree.v, product);
    EXPECT_LT((vector(product) - rate).norm(), 1e-6 * (1 + rate.norm()));
  });
  EXPECT_GE(seen, 5);
}

MatrixXd masses_of(LoopedTree& tree) {
  Workspace<double> workspace(tree.model, cut_tree);
  Numbers M(tree.v.size() * tree.v.size());
  axode::mass_matrix(tree.model, workspace, tree.q, M);
  return matrix(tree.model.nv(), M);
}

/// Whether rows A of loops depend on each other in the metric M⁻¹ of the masses, in which the library judges
/// them.
bool depend(const MatrixXd& A, const MatrixXd& M) {
  const MatrixXd weighted = M.llt().matrixL().solve(A.transpose());
  Eigen::ColPivHouseholderQR<MatrixXd> independent;
  independent.setThreshold(1e-3);
  return independent.compute(weighted.colwise().normalized()).rank() < A.rows();
}

/// Motions fulfil the rows of the loops, and the constraint forces are combinations of these rows, so that
/// they do no work on velocities that the rows allow. Rows that depend on each other are included.
TEST(RandomLoops, MotionsKeepTheRowsAndForcesAreTheirs) {
  int moving = 0, kept = 0;
  for_seeds(60, [&](std::uint64_t seed) {
    LoopedTree tree(seed, seed % 2 == 0);
    const Numbers tau = random_numbers(tree.random, tree.model.nv(), 10);
    Workspace<double> workspace(tree.model, cut_tree);
    Numbers v(tree.v.size()), a(v.size()), lambda(tree.rows()), A(tree.rows() * v.size()), gamma(tree.rows());
    if (!impact(tree.model, tree.loops, tree.q, tree.v, 0.0, v).ok()) return;
    ++moving;
    ASSERT_TRUE(forward_dynamics(tree.model, tree.loops, tree.q, v, tau, a, lambda).ok());
    Numbers force(v.size());
    inverse_dynamics(tree.model, workspace, tree.q, v, a, force);
    loop_jacobian(tree.model, tree.loops, tree.q, A);
    const MatrixXd rows = matrix(static_cast<int>(tree.rows()), A);
    const VectorXd closing = rows.transpose() * vector(lambda);
    const double size = 1 + closing.norm() + vector(force).norm();
    EXPECT_LT((vector(force) - vector(tau) - closing).norm(), 1e-9 * size);
    if (tree.rows() == 0 || depend(rows, masses_of(tree))) return;  // dependent rows cannot all be fulfilled
    loop_bias(tree.model, tree.loops, tree.q, v, gamma);
    EXPECT_LT((rows * vector(a) + vector(gamma)).norm(),
              1e-6 * (1 + vector(gamma).norm() + vector(a).norm()));
    ++kept;
  });
  EXPECT_GE(moving, 5);
  EXPECT_GE(kept, 5);
}

TEST(RandomLoops, RankDoesNotDependOnWhatWasAskedBefore) {
  int seen = 0;
  for_seeds(30, [&](std::uint64_t seed) {
    const LoopedTree tree(seed);
    const auto kept = [](LoopSystem<double>& system, const Numbers& q) {
      system.update_kinematics(q.data());
      return IndependentRows<double>(system, ConstraintLevel::velocity).independent;
    };
    LoopSystem<double> system(tree.model), other(tree.model);
    const std::vector<int> expected = kept(system, tree.q);
    Numbers x(tree.v.size());
    if (!other.projection_step(tree.q.data(), x.data()).ok()) return;
    EXPECT_EQ(kept(other, tree.q), expected);
    ++seen;
  });
  EXPECT_GE(seen, 5);
}

TEST(RandomLoops, FloatsFollow) {
  for_seeds(20, [](std::uint64_t seed) {
    LoopedTree tree(seed);
    LoopWorkspace<float> single(tree.model);
    const std::vector<float> q = cast<float>(tree.q), v = cast<float>(tree.v);
    std::vector<float> A_single(tree.rows() * v.size()), gamma_single(tree.rows());
    Numbers A(A_single.size()), gamma(tree.rows());
    loop_jacobian(tree.model, single, q, A_single);
    loop_jacobian(tree.model, tree.loops, cast<double>(q), A);
    loop_bias(tree.model, single, q, v, gamma_single);
    loop_bias(tree.model, tree.loops, cast<double>(q), cast<double>(v), gamma);
    const auto close = [](const std::vector<float>& x, const Numbers& y) {
      const VectorXd expected = vector(y);
      EXPECT_LT((vector(cast<double>(x)) - expected).norm(), 1e-4 * (1 + expected.norm()));
    };
    close(A_single, A), close(gamma_single, gamma);
  });
}

TEST(LoopWorkspaces, AreOfOneModel) {
  const Model one = ModelBuilder("one").build(), other = ModelBuilder("other").build();
  LoopWorkspace<double> workspace(one);
  Numbers r;
  const Model copy = one;
  EXPECT_NO_THROW(loop_residual(copy, workspace, Numbers{}, r));
  EXPECT_THROW(loop_residual(other, workspace, Numbers{}, r), std::invalid_argument);
}

}  // namespace
}  // namespace axode::test
