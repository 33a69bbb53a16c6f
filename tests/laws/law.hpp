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

/// Laws are tested for every representation and scalar, over random trees with fixed seeds; a failure prints
/// the seed. A law is compiled once: what it speaks of are numbers that a Subject makes.
namespace axode::test {

/// A law that holds in the given ways: `class Balances : public Law {}` and LAW(Balances, cases());
using Law = testing::TestWithParam<Case>;

/// law(seed) for the seeds 1, 2, ... until one fails, which is repeated with fewer bodies, see smallest_failure().
/// AXODE_RANDOM_TREES overrides how many.
template <class F> void for_seeds(int count, const F& law) {
  if (const char* chosen = std::getenv("AXODE_RANDOM_TREES")) count = std::max(1, std::atoi(chosen));
  for (int seed = 1; seed <= count && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto repeat = [&] { law(static_cast<std::uint64_t>(seed)); };
    repeat();
    if (testing::Test::HasFailure()) ADD_FAILURE() << smallest_failure(repeat);
  }
}

/// Two inverses of M agree as far as the condition of M lets either be known; where that is to less than a tenth, nothing can be
/// compared but that both are finite.
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
