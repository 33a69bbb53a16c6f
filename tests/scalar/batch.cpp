#include "axode/scalar/batch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "axode/lie/se3.hpp"
#include "axode/scalar/sine_cosine.hpp"

namespace axode::test {
namespace {

template <class B> class BatchOfNumbers : public testing::Test {};
using Batches = testing::Types<Batch<double, 2>, Batch<double, 4>, Batch<double, 8>, Batch<float, 4>,
                               Batch<float, 8>, Batch<float, 16>>;
TYPED_TEST_SUITE(BatchOfNumbers, Batches);

template <class S, std::size_t N> S number(const Batch<S, N>&);

TYPED_TEST(BatchOfNumbers, ComputesEveryLaneByItself) {
  using B = TypeParam;
  using S = decltype(number(B{}));
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<S> uniform(S(0.1), S(3));
  constexpr std::size_t N = sizeof(B) / sizeof(S);
  for (int trial = 0; trial < 200; ++trial) {
    S a[N], b[N];
    for (std::size_t k = 0; k < N; ++k) a[k] = uniform(engine), b[k] = uniform(engine);
    const B x = B::load(a), y = B::load(b);
    for (std::size_t k = 0; k < N; ++k) {
      EXPECT_EQ((x + y)[k], a[k] + b[k]);
      EXPECT_EQ((x - y)[k], a[k] - b[k]);
      EXPECT_EQ((x * y)[k], a[k] * b[k]);
      EXPECT_EQ((x / y)[k], a[k] / b[k]);
      EXPECT_EQ((-x)[k], -a[k]);
      EXPECT_EQ(sqrt(x)[k], std::sqrt(a[k]));
      EXPECT_EQ(atan2(x, y)[k], std::atan2(a[k], b[k]));
      EXPECT_EQ((x < y)[k], a[k] < b[k]);
      EXPECT_EQ((x > y)[k], a[k] > b[k]);
      EXPECT_EQ(select(x < y, x, y)[k], std::min(a[k], b[k]));
      EXPECT_EQ((x < y || !(x < y))[k], true);
      EXPECT_EQ((x < y && x > y)[k], false);
      EXPECT_EQ(B(2.5)[k], S(2.5));
    }
    S stored[N];
    x.store(stored);
    for (std::size_t k = 0; k < N; ++k) EXPECT_EQ(stored[k], a[k]);
    EXPECT_EQ(any(x > B(S(4))), false);
    S one_large[N];
    x.store(one_large);
    one_large[static_cast<std::size_t>(trial) % N] = 5;
    EXPECT_EQ(any(B::load(one_large) > B(S(4))), true);
  }
}

TYPED_TEST(BatchOfNumbers, CarriesRigidMotions) {
  using B = TypeParam;
  using S = decltype(number(B{}));
  const SE3<S> one{rotation_to(Vec3<S>{S(0.6), S(0), S(0.8)}), {S(1), S(2), S(3)}};
  const auto spread = [](const Vec3<S>& a) { return Vec3<B>{B(a.x), B(a.y), B(a.z)}; };
  const SE3<B> many{{spread(one.R.x), spread(one.R.y), spread(one.R.z)}, spread(one.r)};
  const Vec3<S> point = one * one.r;
  const Vec3<B> points = many * many.r;
  for (std::size_t k = 0; k < sizeof(B) / sizeof(S); ++k) {
    EXPECT_NEAR(points.x[k], point.x, 1e-5);
    EXPECT_NEAR(points.y[k], point.y, 1e-5);
    EXPECT_NEAR(points.z[k], point.z, 1e-5);
  }
}

}  // namespace
}  // namespace axode::test
