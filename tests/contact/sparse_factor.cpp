#include "axode/contact/law/sparse_factor.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <random>

/// The factorisation along groups of indices, against dense ones.
namespace axode::test {
namespace {

using Groups = std::vector<std::vector<int>>;

/// Groups of intervals of 1 to 6 indices, as bodies have.
Groups random_groups(std::mt19937& random, int n, int count) {
  const auto up_to = [&](int k) { return std::uniform_int_distribution<>(1, k)(random); };
  Groups groups(static_cast<std::size_t>(count));
  for (std::vector<int>& group : groups) {
    std::vector<char> in(static_cast<std::size_t>(n), 0);
    for (int intervals = up_to(4); intervals > 0; --intervals) {
      const int first = up_to(n) - 1, last = std::min(n, first + up_to(6));
      std::fill(in.begin() + first, in.begin() + last, 1);
    }
    for (int i = 0; i < n; ++i)
      if (in[static_cast<std::size_t>(i)]) group.push_back(i);
  }
  return groups;
}

void set_groups(SparseFactor& factor, int n, const Groups& groups) {
  factor.begin(n);
  for (const std::vector<int>& group : groups) factor.add_group(group);
  factor.analyse();
}

/// Adds random parts to all groups, and returns the matrix.
Eigen::MatrixXd fill(SparseFactor& factor, int n, const Groups& groups, bool symmetric,
                     std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n);
  factor.clear(symmetric);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const int rows = static_cast<int>(groups[g].size()), columns = 1 + static_cast<int>(g) % 5;
    Eigen::MatrixXd P = Eigen::MatrixXd::Zero(SparseFactor::padded(rows), columns), Q = P;
    for (int k = 0; k < columns; ++k)
      for (int i = 0; i < rows; ++i) {
        P(i, k) = normal(random);
        Q(i, k) = symmetric ? P(i, k) : normal(random);
      }
    factor.add(static_cast<int>(g), P.data(), Q.data(), columns);
    const Eigen::MatrixXd part = P * Q.transpose();
    A(groups[g], groups[g]) += part.topLeftCorner(rows, rows);
  }
  factor.factorize();
  return A;
}

TEST(SparseFactor, SolvesAsADenseFactorDoes) {
  std::mt19937 random(1);
  SparseFactor factor;
  factor.reserve(60, 20);
  int negative = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const int n = std::uniform_int_distribution<>(1, 60)(random);
    const Groups groups = random_groups(random, n, std::uniform_int_distribution<>(0, 20)(random));
    set_groups(factor, n, groups);
    const Eigen::MatrixXd A = fill(factor, n, groups, trial % 2 == 0, random);
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(n, -1, 2);
    Eigen::VectorXd x = b;
    factor.solve(x.data());
    EXPECT_LE((A * x - b).norm(), 1e-10 * (A.norm() * x.norm() + b.norm())) << "trial " << trial;
    EXPECT_EQ(factor.is_negative(), A.determinant() < 0) << "trial " << trial;
    negative += factor.is_negative() ? 1 : 0;
  }
  EXPECT_GT(negative, 100);
}

/// A chain of blocks and a body with branches have no fill-in: the cost is linear.
TEST(SparseFactor, CostsAsMuchAsItsBranches) {
  const auto cost = [](int blocks, bool chain) {
    Groups groups;
    for (int k = 1; k < blocks; ++k) {
      std::vector<int> group;
      for (const int block : {chain ? k - 1 : 0, k})
        for (int i = 0; i < 6; ++i) group.push_back(6 * block + i);
      groups.push_back(group);
    }
    SparseFactor factor;
    factor.reserve(6 * blocks, blocks);
    set_groups(factor, 6 * blocks, groups);
    return factor.cost();
  };
  for (const bool chain : {true, false}) EXPECT_LE(cost(80, chain), 2.2 * cost(40, chain));
}

TEST(SparseFactor, OfAnEmptyMatrixCostsNothing) {
  SparseFactor factor;
  factor.reserve(0, 0);
  set_groups(factor, 0, {});
  EXPECT_EQ(factor.cost(), 0);
}

TEST(SparseFactor, SaysThatAMatrixIsSingular) {
  SparseFactor factor;
  factor.reserve(2, 1);
  set_groups(factor, 2, {{0, 1}});
  for (const bool symmetric : {true, false}) {
    factor.clear(symmetric);
    const std::array<double, 4> P{1, 0, 0, 0}, minus{-1, 0, 0, 0};
    factor.add(0, P.data(), minus.data(), 1);
    factor.factorize();
    std::array<double, 2> x{1, 1};
    factor.solve(x.data());
    EXPECT_FALSE(std::isfinite(x[0]));
  }
}

}  // namespace
}  // namespace axode::test
