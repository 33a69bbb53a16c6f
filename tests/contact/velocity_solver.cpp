#include "axode/contact/law/velocity_solver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "axode/contact/law/problem_derivative.hpp"
#include "tests/contact/rigid_problems.hpp"

/// The solver of velocity problems, on problems from easy to hard.
namespace axode::test {
namespace {

struct Solved {
  VelocityProblem problem;
  std::vector<double> lambda;
  VelocitySolution solution;
};
Solved solve(const RigidProblem& rigid) {
  Solved out{rigid.build(), {}, {}};
  VelocitySolver solver;
  solver.reserve(out.problem.nv(), out.problem.rows());
  out.lambda.assign(out.problem.r.size(), 0);
  out.solution = solver.solve(out.problem, out.lambda.data());
  return out;
}

std::vector<RigidProblem> hard_problems() {
  std::vector<double> heavy_top(10, 1.0), alternating(10, 1.0);
  heavy_top.back() = 1e6;
  for (std::size_t k = 1; k < alternating.size(); k += 2) alternating[k] = 1e6;
  return {box_on_plane(2, {}, {1, 0.3, 0}),
          box_on_plane(2, {}, {}),
          box_on_plane(10, {}, {1, 0.3, 0}),
          box_on_plane(10, {0.1, 0.5, 0.3}, {1, 0, -1}),
          stack(std::vector<double>(10, 1.0)),
          stack(std::vector<double>(10, 1.0), 3),
          stack(heavy_top),
          stack(alternating),
          wall(5, 5, 15),
          painleve(1.5),
          wedge(0.2),
          wedge(2),
          arch(32, 0.107, 1),
          arch(32, 0.108, 1)};
}

TEST(VelocitySolver, ReachesTheLawOnHardProblems) {
  for (const RigidProblem& rigid : hard_problems()) {
    const Solved solved = solve(rigid);
    EXPECT_LE(solved.solution.certificate, 1e-12) << rigid.name;
    std::vector<double> scratch(2 * solved.lambda.size() + static_cast<std::size_t>(solved.problem.nv()));
    EXPECT_NEAR(certificate(solved.problem, solved.lambda.data(), scratch.data()),
                solved.solution.certificate, 1e-13)
        << rigid.name;
  }
}

TEST(VelocitySolver, ReachesTheLawOnRandomPiles) {
  for (const double most_friction : {0.4, 1.2, 2.5})
    for (unsigned seed = 0; seed < 20; ++seed) {
      const Solved solved = solve(pile(8, 24, seed, 0.1, most_friction));
      EXPECT_LE(solved.solution.certificate, 1e-9) << "seed " << seed << ", friction to " << most_friction;
    }
}

/// Newton's method fails at most of these, and alternating directions at some.
TEST(VelocitySolver, ReachesTheLawOnDensePiles) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    const Solved solved = solve(pile(8, 40, seed, 0.1, 1.2));
    EXPECT_LE(solved.solution.certificate, 1e-9) << "seed " << seed;
  }
}

TEST(VelocitySolver, AsksItsMonitorBeforeFurtherStarts) {
  int calls = 0;
  for (unsigned seed = 0; seed < 4; ++seed) {
    const VelocityProblem problem = pile(8, 40, seed, 0.1, 1.2).build();
    VelocitySolver solver;
    solver.reserve(problem.nv(), problem.rows());
    std::vector<double> lambda(problem.r.size()), one = lambda, none = lambda;
    const VelocitySolution free = solver.solve(problem, lambda.data());
    const VelocitySolution watched = solver.solve(problem, one.data(), 1e-12, [&] {
      ++calls;
      return true;
    });
    EXPECT_EQ(lambda, one) << "seed " << seed;
    EXPECT_EQ(solver.solve(problem, none.data(), 1e-12, [] { return false; }).restarts, 0) << "seed " << seed;
    EXPECT_EQ(free.restarts, watched.restarts) << "seed " << seed;
  }
  EXPECT_GE(calls, 20);
}

TEST(VelocitySolver, ReachesTheLawOnAWallOfAHundredBricks) {
  const Solved solved = solve(wall(10, 10, 15));
  EXPECT_LE(solved.solution.certificate, 1e-12);
  EXPECT_LE(solved.solution.factorizations, 50);
}

/// Starting from the solution of a nearby problem, the solver knows the branches and needs few
/// factorisations.
TEST(VelocitySolver, TakesFewFactorsFromANearSolution) {
  for (const RigidProblem& rigid : {stack(std::vector<double>(10, 1.0)), box_on_plane(2, {}, {1, 0.3, 0})}) {
    Solved solved = solve(rigid);
    solved.problem.w *= 1.001;
    VelocitySolver solver;
    solver.reserve(solved.problem.nv(), solved.problem.rows());
    const VelocitySolution solution = solver.solve(solved.problem, solved.lambda.data());
    EXPECT_LE(solution.certificate, 1e-12) << rigid.name;
    EXPECT_LE(solution.factorizations, 2) << rigid.name;
  }
}

/// A solver that keeps its factors makes none for a problem that is near the last one.
TEST(VelocitySolver, SolvesANearProblemWithTheFactorsItHasKept) {
  Solved solved = solve(box_on_plane(2, {}, {1, 0.3, 0}));
  VelocitySolver solver;
  solver.reserve(solved.problem.nv(), solved.problem.rows());
  solver.keeps_factors = true;
  const auto solve_near = [&] {
    solved.problem.w *= 1 + 1e-6;
    const VelocitySolution solution = solver.solve(solved.problem, solved.lambda.data());
    EXPECT_LE(solution.certificate, 1e-12);
    return solution.factorizations;
  };
  EXPECT_GE(solve_near(), 1);
  EXPECT_EQ(solve_near(), 0);
  solver.forget_factors();
  EXPECT_GE(solve_near(), 1);
}

TEST(VelocitySolver, TakesNoStepFromItsOwnSolution) {
  for (const RigidProblem& rigid : {stack(std::vector<double>(10, 1.0), 3), painleve(1.5)}) {
    Solved solved = solve(rigid);
    VelocitySolver solver;
    solver.reserve(solved.problem.nv(), solved.problem.rows());
    EXPECT_EQ(solver.solve(solved.problem, solved.lambda.data()).factorizations, 0) << rigid.name;
  }
}

/// A contact has one scale: its normal entry of the Delassus operator or half of its largest (D11.6).
TEST(Certificate, ScalesAContactByItsNormalRowOrHalfOfItsLargest) {
  for (const auto& [normal, tangential, expected] : {std::array{1.0, 3.0, 4.5}, std::array{3.0, 4.0, 9.0}}) {
    VelocityProblem problem(3);
    const std::vector<int> support{0, 1, 2};
    double* Y = problem.add(ContactLaw::contact, 3, support);
    std::fill_n(Y, 9, 0.0);
    Y[0] = normal;
    Y[4] = Y[8] = tangential;
    std::ranges::fill(problem.c, 1);
    std::ranges::fill(problem.r, 0);
    problem.finish();
    EXPECT_EQ(problem.squared_scales(), std::vector<double>(3, expected));
  }
}

/// Units of mass and time do not change the certificate of given multipliers.
TEST(Certificate, HasNoUnit) {
  const RigidProblem rigid = pile(5, 12, 3, 0.1, 1.0);
  VelocityProblem problem = rigid.build();
  std::vector<double> lambda(problem.r.size()), scratch(2 * lambda.size() + 30);
  for (std::size_t k = 0; k < lambda.size(); ++k) lambda[k] = std::sin(1.0 + static_cast<double>(k));
  const double expected = certificate(problem, lambda.data(), scratch.data());
  RigidProblem heavy = rigid;
  for (RigidBody& body : heavy.bodies) {
    body.mass *= 1024;
    body.inertia = 1024.0 * body.inertia;
  }
  for (double& x : lambda) x *= 1024;
  EXPECT_NEAR(certificate(heavy.build(), lambda.data(), scratch.data()), expected, 1e-12 * expected);
}

/// Nor do masses and velocities whose squares overflow or vanish.
TEST(Certificate, IsThatOfNumbersOfAnySize) {
  const auto of_size = [](double size) {
    VelocityProblem problem(1);
    const std::vector<int> support{0};
    *problem.add(ContactLaw::stop, 1, support) = 1;
    problem.finish();
    problem.w[0] = -size;
    const double lambda = size / 2;
    std::vector<double> scratch(10);
    return certificate(problem, &lambda, scratch.data());
  };
  EXPECT_NEAR(of_size(1), 1.0 / 3, 1e-15);
  for (const double size : {1e-300, 1e-170, 1e170, 1e300}) EXPECT_NEAR(of_size(size), 1.0 / 3, 1e-15) << size;
}

TEST(VelocitySolver, SaysThatNumbersAreNotFinite) {
  VelocityProblem problem = box_on_plane(2, {}, {1, 0.3, 0}).build();
  problem.w[2] = std::numeric_limits<double>::quiet_NaN();
  VelocitySolver solver;
  solver.reserve(problem.nv(), problem.rows());
  std::vector<double> lambda(problem.r.size());
  EXPECT_FALSE(solver.solve(problem, lambda.data()).holds(1e300));
}

/// The derivative of the motion along changes of w or of r against differences.
TEST(ProblemDerivative, IsThatOfDifferences) {
  int compared = 0;
  for (const RigidProblem& rigid :
       {box_on_plane(2, {}, {1, 0.3, 0}), painleve(0.5), pile(4, 6, 1, 0.1, 0.6), pile(4, 6, 7, 0.1, 0.6)}) {
    const Solved solved = solve(rigid);
    ASSERT_LE(solved.solution.certificate, 1e-12);
    const int nv = solved.problem.nv(), m = solved.problem.rows();
    VelocitySolver solver;
    solver.reserve(nv, m);
    const double step = 1e-5 * solved.problem.w.norm();
    for (const bool by_w : {true, false}) {
      const int n = by_w ? nv : m;
      const Eigen::MatrixXd dx = Eigen::MatrixXd::Identity(nv, n) * (by_w ? 1 : 0),
                            du = Eigen::MatrixXd::Identity(m, n) * (by_w ? 0 : 1);
      const ProblemDerivative found = differentiate(solved.problem, solved.lambda.data(), dx, du);
      EXPECT_FALSE(found.at_kink) << rigid.name;
      if (!found.unique) continue;
      ++compared;
      const auto motion = [&](int k, double by) -> Eigen::VectorXd {
        VelocityProblem problem = solved.problem;
        problem.w += by * dx.col(k);
        for (int row = 0; row < m; ++row) problem.r[static_cast<std::size_t>(row)] += by * du(row, k);
        std::vector<double> lambda = solved.lambda;
        EXPECT_LE(solver.solve(problem, lambda.data(), 1e-15).certificate, 1e-12);
        Eigen::VectorXd x = problem.w;
        problem.add_product(1, lambda.data(), x.data());
        return x;
      };
      for (int k = 0; k < n; ++k) {
        const Eigen::VectorXd difference = (motion(k, step) - motion(k, -step)) / (2 * step);
        EXPECT_LE((difference - found.motion.col(k)).norm(), 1e-6) << rigid.name << ", direction " << k;
      }
    }
  }
  EXPECT_GE(compared, 5);
}

/// Friction of redundant contacts that slide and turn depends on their share of the load.
TEST(ProblemDerivative, SaysThatAShareOfTheLoadDecides) {
  const Solved solved = solve(box_on_plane(2, {0, 0, 3}, {1, 0.3, 0}));
  const Eigen::MatrixXd dx = Eigen::MatrixXd::Identity(6, 6), du = Eigen::MatrixXd::Zero(12, 6);
  EXPECT_FALSE(differentiate(solved.problem, solved.lambda.data(), dx, du).unique);
}

}  // namespace
}  // namespace axode::test
