#include "axode/constraints/loop_system/row_cholesky.hpp"

#include <gtest/gtest.h>

#include "tests/laws/law.hpp"

namespace axode::test {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

/// Solves A x = b for the b that is stored beside the matrix, and for one that is passed alone.
TEST(RowCholesky, SolvesForARightSideBesideTheMatrixAndForOthers) {
  Random<double> random(1);
  for (int m = 1; m <= 25; ++m) {
    SCOPED_TRACE(m);
    const MatrixXd B = matrix(m, random_numbers(random, m * (m + 3)));
    const MatrixXd A = B * B.transpose();
    const VectorXd b = vector(random_numbers(random, m)), c = vector(random_numbers(random, m));
    RowCholesky<double> factor;
    factor.resize(m);
    factor.matrix().topLeftCorner(m, m) = A.triangularView<Eigen::Upper>();
    factor.matrix().col(m) = b;
    factor.factorize(m);
    VectorXd x = VectorXd::Zero(RowCholesky<double>::room(m));
    factor.solve_right_side(m, x);
    const double size = A.norm();
    EXPECT_LT((A * x.head(m) - b).norm(), 1e-14 * size * (1 + x.norm()));
    x.setZero(), x.head(m) = c;
    factor.solve(m, x);
    EXPECT_LT((A * x.head(m) - c).norm(), 1e-14 * size * (1 + x.norm()));
    EXPECT_EQ(x.tail(x.size() - m).norm(), 0);
  }
}

TEST(RowCholesky, StopsAtAPivotThatIsNotSound) {
  RowCholesky<double> factor;
  factor.resize(3);
  factor.matrix().topLeftCorner(3, 3) << 4, 2, 2, 0, 2, 1, 0, 0, 1;  // its pivots are 4, 1 and 0
  std::vector<double> pivots;
  EXPECT_FALSE(factor.factorize(3, [&](Eigen::Index, double D) {
    pivots.push_back(D);
    return D > 1e-3;
  }));
  EXPECT_EQ(pivots, (std::vector<double>{4, 1, 0}));
}

}  // namespace
}  // namespace axode::test
