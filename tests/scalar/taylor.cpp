#include "axode/scalar/taylor.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "axode/lie.hpp"

/// Truncated power series: functions of the variable t carry their derivatives at a point.
namespace axode::test {
namespace {

constexpr std::size_t orders = 6;  // values and derivatives up to the fifth
using Series = Taylor<double, orders>;
using Derivatives = std::array<double, orders>;

Series variable(double at) { return Series({at, 1.0}); }

void expect_derivatives(const Series& f, const Derivatives& expected) {
  for (std::size_t k = 0; k < orders; ++k) {
    EXPECT_NEAR(derivative(f, k), expected[k], 1e-13 * (1 + std::abs(expected[k]))) << "derivative " << k;
  }
}

TEST(Taylor, Polynomials) {
  const Series t = variable(2);
  expect_derivatives(t * t * t - 4 * t + 1, {1, 8, 12, 6, 0, 0});
  expect_derivatives(-t, {-2, -1, 0, 0, 0, 0});
  Series sum = t;
  sum += t * t;
  sum -= 3;
  expect_derivatives(sum, {3, 5, 2, 0, 0, 0});
}

TEST(Taylor, Quotients) {
  const double x = 1.5;
  const Series t = variable(x);
  expect_derivatives(1 / t, {1 / x, -1 / (x * x), 2 / std::pow(x, 3), -6 / std::pow(x, 4),
                             24 / std::pow(x, 5), -120 / std::pow(x, 6)});
  expect_derivatives((t * t - 1) / (t + 1), {x - 1, 1, 0, 0, 0, 0});
}

TEST(Taylor, SquareRoots) {
  const double x = 0.7, r = std::sqrt(x);
  expect_derivatives(sqrt(variable(x)), {r, 0.5 / r, -0.25 / (r * x), 0.375 / (r * x * x),
                                         -0.9375 / (r * std::pow(x, 3)), 3.28125 / (r * std::pow(x, 4))});
}

TEST(Taylor, SinesAndCosines) {
  const double x = 0.4, s = std::sin(3 * x), c = std::cos(3 * x);
  expect_derivatives(sin(3 * variable(x)), {s, 3 * c, -9 * s, -27 * c, 81 * s, 243 * c});
  expect_derivatives(cos(3 * variable(x)), {c, -3 * s, -9 * c, 27 * s, 81 * c, -243 * s});
}

TEST(Taylor, ArcusTangens) {
  const double x = 0.6, u = 1 / (1 + x * x);
  const Derivatives arctangent{std::atan(x),
                               u,
                               -2 * x * u * u,
                               (6 * x * x - 2) * std::pow(u, 3),
                               24 * x * (1 - x * x) * std::pow(u, 4),
                               24 * (5 * std::pow(x, 4) - 10 * x * x + 1) * std::pow(u, 5)};
  expect_derivatives(atan2(variable(x), 1), arctangent);
  expect_derivatives(atan2(2 * variable(x), 2), arctangent);
  const Series t = variable(2.8);  // an angle that increases steadily, through the third quadrant
  expect_derivatives(atan2(sin(t), cos(t)), {2.8, 1, 0, 0, 0, 0});
  expect_derivatives(atan2(sin(-t), cos(-t)), {-2.8, -1, 0, 0, 0, 0});
}

TEST(Taylor, IdentitiesOfTheFunctions) {
  const Series t = variable(0.3), f = 1 + t * sin(t) / (2 + cos(t));
  expect_derivatives(sin(f) * sin(f) + cos(f) * cos(f), {1, 0, 0, 0, 0, 0});
  expect_derivatives(sqrt(f) * sqrt(f) - f, {});
  expect_derivatives(sin(f + f) - 2 * sin(f) * cos(f), {});
  expect_derivatives(f / (1 / f) - f * f, {});
}

TEST(Taylor, ComparisonAndSelectLookAtTheValue) {
  const Series t = variable(1), u({1.0, -5.0}), larger = t + 1;
  EXPECT_TRUE(t < larger && larger > t && !(t < u) && !(u < t));
  expect_derivatives(select(t < larger, t, larger), {1, 1, 0, 0, 0, 0});
  expect_derivatives(select(larger < t, t, larger), {2, 1, 0, 0, 0, 0});
}

TEST(Taylor, SeriesOfSeriesGivePartialDerivatives) {
  using Inner = Taylor<double, 3>;
  using Outer = Taylor<Inner, 3>;
  const Outer x = Inner({0.5, 1.0}), y({Inner(0.2), Inner(1.0)});
  const Outer f = sin(x * y) / x;
  EXPECT_NEAR(f.c[0].c[0], std::sin(0.1) / 0.5, 1e-15);
  EXPECT_NEAR(f.c[1].c[0], std::cos(0.1), 1e-15);             // ∂f/∂y = cos(xy)
  EXPECT_NEAR(f.c[1].c[1], -0.2 * std::sin(0.1), 1e-15);      // ∂²f/∂y∂x = -y sin(xy)
  EXPECT_NEAR(2 * f.c[2].c[0], -0.5 * std::sin(0.1), 1e-15);  // ∂²f/∂y² = -x sin(xy)
}

/// log(exp(X(t))) must give back every coefficient of X(t), whatever the angle of X(0).
template <std::size_t N> void expect_exp_log_round_trip(double angle, double bound) {
  using T = Taylor<double, N>;
  const Vec3<> e{2.0 / 3, -1.0 / 3, 2.0 / 3};
  const Screw<T> X{{T({angle * e.x, 0.3, -0.2}), T({angle * e.y, -0.7, 0.8}), T({angle * e.z, 0.4, 0.3})},
                   {T({0.1, 0.6, 0.7}), T({0.5, -0.5, -0.3}), T({-0.9, 0.2, 0.4})}};
  const Screw<T> Y = log(exp(X));
  const std::array<T, 6> errors{Y.w.x - X.w.x, Y.w.y - X.w.y, Y.w.z - X.w.z,
                                Y.v.x - X.v.x, Y.v.y - X.v.y, Y.v.z - X.v.z};
  for (const T& error : errors)
    for (std::size_t k = 0; k < N; ++k)
      EXPECT_LE(std::abs(error.c[k]), bound) << "angle " << angle << ", order " << k;
}

TEST(TaylorThroughTheGroup, LogInvertsExpToEveryOrderAtEveryAngle) {
  for (const double angle : {0.0,  1e-12, 1e-8, 1e-5,  1e-3, 0.01,  0.02, 0.05, 0.1, 0.3, 0.44,
                             0.45, 0.5,   0.9,  0.999, 1.0,  1.001, 1.5,  2.0,  3.0, 3.1}) {
    expect_exp_log_round_trip<6>(angle, 1e-14);
    expect_exp_log_round_trip<10>(angle, 1e-12);
  }
}

TEST(TaylorThroughTheGroup, DexpAndItsInverseAreFiniteAtZero) {
  using T = Taylor<double, 5>;
  const Vec3<T> slow{T({0.0, 0.3}), T({0.0, -0.2}), T({0.0, 0.5})};
  const Screw<T> X{slow, {T(1), T(2), T(3)}}, Z{{T(1), T(0), T(2)}, {T(0), T(1), T(0)}};
  const Screw<T> back = dexp_inv(X, dexp(X, Z));
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(back.w.x.c[k], Z.w.x.c[k], 1e-15);
    EXPECT_NEAR(back.v.y.c[k], Z.v.y.c[k], 1e-15);
  }
}

TEST(TaylorThroughTheGroup, AQuaternionThroughHalfATurnIsFinite) {
  using T = Taylor<double, 4>;
  const T angle({3.141592653589793 - 1e-9, -0.5});
  const Vec3<T> xi = log_quaternion(exp_quaternion(Vec3<T>{angle, T(0), T(0)}));
  EXPECT_NEAR(xi.x.c[0], angle.c[0], 1e-15);
  EXPECT_NEAR(xi.x.c[1], -0.5, 1e-15);
  EXPECT_NEAR(xi.x.c[2], 0, 1e-15);
}

}  // namespace
}  // namespace axode::test
