#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "tests/support/comparison.hpp"
#include "tests/support/dense.hpp"
#include "tests/support/smallest_failure.hpp"
#include "tests/support/trial.hpp"

/// Laws are tested for every representation and scalar type, on random trees with fixed seeds; a failure
/// prints its seed. The code of a law is compiled once, because it works on the numbers that a Subject
/// returns.
namespace axode::test {

/// A law for several ways to compute: `class Balances : public Law {}` and LAW(Balances, cases());
using Law = testing::TestWithParam<Case>;

/// Calls law(seed) for the seeds 1, 2, ..., `count` until one fails. That one is repeated with fewer bodies,
/// see smallest_failure(). The variable AXODE_RANDOM_TREES overrides `count`.
template <class F> void for_seeds(int count, const F& law) {
  if (const char* chosen = std::getenv("AXODE_RANDOM_TREES")) count = std::max(1, std::atoi(chosen));
  for (int seed = 1; seed <= count && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto repeat = [&] { law(static_cast<std::uint64_t>(seed)); };
    repeat();
    if (testing::Test::HasFailure()) ADD_FAILURE() << smallest_failure(repeat);
  }
}

/// Expects that two inverses of M agree to the accuracy that the condition of M allows. If that is worse than
/// a tenth, only expects that both are finite.
template <class Numbers>
void expect_same_inverse(const Numbers& one, const Numbers& other, const Numbers& M, double agreement) {
  const auto largest = [](const Numbers& matrix) {
    double x = 0;
    for (const auto entry : matrix) x = std::max(x, std::abs(static_cast<double>(entry)));
    return x;
  };
  const double scale = largest(other),
               tolerance = agreement * scale * std::max(1.0, scale * largest(M) * 1e-2);
  for (std::size_t k = 0; k < other.size(); ++k) {
    EXPECT_TRUE(std::isfinite(one[k]) && std::isfinite(other[k]));
    if (tolerance < 0.1 * scale) {
      EXPECT_NEAR(one[k], other[k], tolerance);
    }
  }
}

}  // namespace axode::test
