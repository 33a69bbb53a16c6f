#include "axode/scalar/sine_cosine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace axode::test {
namespace {

template <class S> class SineAndCosine : public testing::Test {};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(SineAndCosine, Scalars);

/// The error of x in units of the last place of the exact value.
template <class S> double ulps(S x, long double exact) {
  int exponent = 0;
  std::frexp(static_cast<S>(exact), &exponent);
  const double ulp = std::ldexp(1.0, exponent - std::numeric_limits<S>::digits);
  return static_cast<double>(std::abs(static_cast<long double>(x) - exact)) / ulp;
}

template <class S, std::size_t N> double worst(const std::vector<S>& angles) {
  double error = 0;
  for (std::size_t k = 0; k + N <= angles.size(); k += N) {
    const auto r = sine_cosine(Batch<S, N>::load(angles.data() + k));
    for (std::size_t l = 0; l < N; ++l) {
      const long double x = angles[k + l];
      error = std::max({error, ulps(r.sine[l], std::sin(x)), ulps(r.cosine[l], std::cos(x))});
    }
  }
  return error;
}

TYPED_TEST(SineAndCosine, AreWithinTwoUnitsInTheLastPlace) {
  using S = TypeParam;
  std::mt19937_64 engine(1);
  std::vector<S> angles;
  for (const double range : {1e-8, 1.0, 10.0, 1e3, 1e5, 1e6})
    for (int k = 0; k < 64'000; ++k) {
      const double x = std::uniform_real_distribution(-range, range)(engine), quarter = std::acos(-1.0) / 2;
      angles.push_back(static_cast<S>(x));
      angles.push_back(static_cast<S>(std::round(x / quarter) * quarter));  // at these angles the sine or the
                                                                            // cosine is nearly 0
    }
  EXPECT_LE((worst<S, 2>(angles)), 2);
  EXPECT_LE((worst<S, 4>(angles)), 2);
  EXPECT_LE((worst<S, 8>(angles)), 2);
  EXPECT_LE((worst<S, 16>(angles)), 2);
}

TYPED_TEST(SineAndCosine, LeaveLargeAnglesToTheStandardLibraryAndPassOnWhatIsNoAngle) {
  using S = TypeParam;
  const S infinity = std::numeric_limits<S>::infinity();
  const S x[8]{S(1.5e6), S(-3e7), S(1e30), infinity, -infinity, std::numeric_limits<S>::quiet_NaN(),
               S(0),     S(-0.0)};
  const auto r = sine_cosine(Batch<S, 8>::load(x));
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(r.sine[k], std::sin(x[k]));
    EXPECT_EQ(r.cosine[k], std::cos(x[k]));
  }
  for (std::size_t k = 3; k < 6; ++k) {
    EXPECT_TRUE(std::isnan(r.sine[k]));
    EXPECT_TRUE(std::isnan(r.cosine[k]));
  }
  for (std::size_t k = 6; k < 8; ++k) {
    EXPECT_EQ(r.sine[k], S(0));
    EXPECT_EQ(r.cosine[k], S(1));
  }
}

TYPED_TEST(SineAndCosine, AreTheSameInEveryLane) {
  using S = TypeParam;
  std::mt19937_64 engine(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const S x = static_cast<S>(std::uniform_real_distribution(-100.0, 100.0)(engine));
    const auto all = sine_cosine(Batch<S, 8>(x));
    S mixed[8];
    for (S& y : mixed) y = static_cast<S>(std::uniform_real_distribution(-100.0, 100.0)(engine));
    mixed[trial % 8] = x;
    const auto one = sine_cosine(Batch<S, 8>::load(mixed));
    for (std::size_t k = 0; k < 8; ++k) ASSERT_EQ(all.sine[k], one.sine[static_cast<std::size_t>(trial % 8)]);
  }
}

}  // namespace
}  // namespace axode::test
