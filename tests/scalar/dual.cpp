#include "axode/scalar/dual.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "axode/lie.hpp"
#include "axode/scalar/taylor.hpp"

/// Dual numbers: functions of two variables x and y carry their gradient.
namespace axode::test {
namespace {

using Gradient = Dual<double, 2>;
const double x0 = 1.3, y0 = -0.6;
const Gradient x(x0, {1, 0}), y(y0, {0, 1});

void expect_dual(const Gradient& f, double value, double df_dx, double df_dy) {
  EXPECT_DOUBLE_EQ(f.x, value);
  EXPECT_NEAR(f.dx[0], df_dx, 1e-15 * (1 + std::abs(df_dx)));
  EXPECT_NEAR(f.dx[1], df_dy, 1e-15 * (1 + std::abs(df_dy)));
}

TEST(Dual, SumsAndProducts) {
  expect_dual(x + y, x0 + y0, 1, 1);
  expect_dual(x - y, x0 - y0, 1, -1);
  expect_dual(-x, -x0, -1, 0);
  expect_dual(x * y, x0 * y0, y0, x0);
  expect_dual(3 * x * x - 2 * y + 1, 3 * x0 * x0 - 2 * y0 + 1, 6 * x0, -2);
  Gradient sum = x;
  sum += y;
  sum -= x * y;
  expect_dual(sum, x0 + y0 - x0 * y0, 1 - y0, 1 - x0);
}

TEST(Dual, ConstantsHaveNoDerivative) {
  expect_dual(Gradient(2.5), 2.5, 0, 0);
  expect_dual(Gradient(3), 3, 0, 0);
  expect_dual(Gradient(), 0, 0, 0);
}

TEST(Dual, Quotients) {
  expect_dual(x / y, x0 / y0, 1 / y0, -x0 / (y0 * y0));
  expect_dual(1 / x, 1 / x0, -1 / (x0 * x0), 0);
}

TEST(Dual, SquareRoots) {
  expect_dual(sqrt(x * x + y * y), std::hypot(x0, y0), x0 / std::hypot(x0, y0), y0 / std::hypot(x0, y0));
}

TEST(Dual, SinesAndCosines) {
  expect_dual(sin(2 * x), std::sin(2 * x0), 2 * std::cos(2 * x0), 0);
  expect_dual(cos(x * y), std::cos(x0 * y0), -y0 * std::sin(x0 * y0), -x0 * std::sin(x0 * y0));
}

TEST(Dual, ArcusTangens) {
  const double r2 = x0 * x0 + y0 * y0;
  expect_dual(atan2(y, x), std::atan2(y0, x0), -y0 / r2, x0 / r2);
  expect_dual(atan2(y, -x), std::atan2(y0, -x0), y0 / r2, -x0 / r2);
  expect_dual(atan2(sin(3 * x), cos(3 * x)), std::atan2(std::sin(3 * x0), std::cos(3 * x0)), 3, 0);
}

TEST(Dual, ComparisonAndSelectLookAtTheValue) {
  const Gradient same(x0, {5, 5});
  EXPECT_TRUE(y < x && x > y);
  EXPECT_FALSE(same < x || x < same);
  expect_dual(select(y < x, x, y), x0, 1, 0);
  expect_dual(select(x < y, x, y), y0, 0, 1);
}

TEST(Dual, NestedCarriesSecondDerivatives) {
  using Second = Dual<Dual<double, 2>, 2>;
  const Second u(x, {1, 0}), v(y, {0, 1});
  const Second f = sin(u * v) / u + sqrt(u) * v + atan2(v, u);
  const double s = std::sin(x0 * y0), c = std::cos(x0 * y0), r4 = std::pow(x0 * x0 + y0 * y0, 2);
  EXPECT_NEAR(f.x.x, s / x0 + std::sqrt(x0) * y0 + std::atan2(y0, x0), 1e-15);
  EXPECT_NEAR(f.dx[1].dx[1], -x0 * s - 2 * x0 * y0 / r4, 1e-14);
  EXPECT_NEAR(f.dx[0].dx[1], -y0 * s + 0.5 / std::sqrt(x0) + (y0 * y0 - x0 * x0) / r4, 1e-14);
  EXPECT_NEAR(f.dx[0].dx[0],
              -y0 * y0 * s / x0 - 2 * y0 * c / (x0 * x0) + 2 * s / std::pow(x0, 3) -
                  0.25 * y0 * std::pow(x0, -1.5) + 2 * x0 * y0 / r4,
              1e-14);
  EXPECT_DOUBLE_EQ(f.dx[0].dx[1], f.dx[1].dx[0]);
  EXPECT_DOUBLE_EQ(f.x.dx[0], f.dx[0].x) << "both levels carry the gradient";
  EXPECT_EQ(Second(7).x.x, 7);
}

TEST(Dual, OfSeriesCarriesTheDerivativeOfEveryCoefficient) {
  using Series = Taylor<double, 4>;
  const Series t({0.5, 1.0});
  const Dual<Series, 1> a(Series(2.0), {Series(1.0)});  // d/da of sin(a t) at a = 2
  const auto f = sin(a * Dual<Series, 1>(t));
  EXPECT_NEAR(f.dx[0].c[0], 0.5 * std::cos(1.0), 1e-15);
  EXPECT_NEAR(f.dx[0].c[1], std::cos(1.0) - 2 * 0.5 * std::sin(1.0), 1e-15);
}

/// The derivative of exp at X = 0 is the identity, and log is its inverse. Nothing is divided by the angle
/// there.
TEST(DualThroughTheGroup, ExpAndLogAreSmoothAtZero) {
  using T = Dual<double, 6>;
  const auto variable = [](std::size_t k, double value) {
    T out(value);
    out.dx[k] = 1;
    return out;
  };
  const Screw<T> X{{variable(0, 0), variable(1, 0), variable(2, 0)},
                   {variable(3, 0), variable(4, 0), variable(5, 0)}};
  const SE3<T> C = exp(X);
  EXPECT_EQ(C.R.x.y.dx, (std::array<double, 6>{0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(C.R.z.x.dx, (std::array<double, 6>{0, 1, 0, 0, 0, 0}));
  EXPECT_EQ(C.r.y.dx, (std::array<double, 6>{0, 0, 0, 0, 1, 0}));
  const Screw<T> Y = log(C);
  const T back[6] = {Y.w.x, Y.w.y, Y.w.z, Y.v.x, Y.v.y, Y.v.z};
  for (std::size_t r = 0; r < 6; ++r)
    for (std::size_t c = 0; c < 6; ++c) EXPECT_EQ(back[r].dx[c], r == c) << r << ' ' << c;
}

TEST(DualThroughTheGroup, SecondDerivativesOfExpAtZeroAreThoseOfItsSeries) {
  using T = Dual<Dual<double, 1>, 1>;
  const T t({0.0, {1.0}}, {1.0});  // exp(t e_z): cos t, sin t and their second derivatives at 0
  const SO3<T> R = exp_SO3(Vec3<T>{T(0), T(0), t});
  EXPECT_EQ(R.x.x.dx[0].dx[0], -1);
  EXPECT_EQ(R.x.y.dx[0].dx[0], 0);
  EXPECT_EQ(R.x.y.dx[0].x, 1);
  const Quaternion<T> a = exp_quaternion(Vec3<T>{T(0), T(0), t});
  EXPECT_EQ(a.w.dx[0].dx[0], -0.25);
  EXPECT_EQ(a.z.dx[0].x, 0.5);
}

TEST(DualThroughTheGroup, LogInvertsExpWithItsDerivativesAtEveryAngle) {
  using T = Dual<Dual<double, 1>, 1>;
  for (const double angle : {0.0, 1e-12, 1e-8, 1e-3, 0.1, 0.44, 0.999, 1.0, 1.001, 2.0, 3.0, 3.1}) {
    const auto entry = [](double value, double slope_1, double slope_2) {
      return T({value, {slope_1}}, {Dual<double, 1>(slope_2)});
    };
    const Screw<T> X{
        {entry(angle * 2 / 3, 0.3, -0.2), entry(-angle / 3, -0.7, 0.8), entry(angle * 2 / 3, 0.4, 0.3)},
        {entry(0.1, 0.6, 0.7), entry(0.5, -0.5, -0.3), entry(-0.9, 0.2, 0.4)}};
    const Screw<T> error = log(exp(X)) - X;
    for (const T& e : {error.w.x, error.w.y, error.w.z, error.v.x, error.v.y, error.v.z})
      for (const double part : {e.x.x, e.x.dx[0], e.dx[0].x, e.dx[0].dx[0]})
        EXPECT_LE(std::abs(part), 2e-14) << "angle " << angle;
  }
}

}  // namespace
}  // namespace axode::test
