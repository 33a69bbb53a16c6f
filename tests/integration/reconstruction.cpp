#include "axode/integration.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "tests/support/refused_arguments.hpp"

/// Poses that are reconstructed from twists: the orders of the methods, for body-fixed and spatial twists.
namespace axode::test {
namespace {

template <class Rep> Twist<Rep> turning(double t) {
  return {{std::sin(2 * t), 1 + t, std::cos(3 * t)}, {t * t, std::cos(t), 0.5 - t}};
}
const SE3<> start{exp_SO3(Vec3<>{0.3, -0.2, 0.9}), {1, 2, 3}};

std::vector<double> steps(int n) {
  std::vector<double> times;
  for (int k = 0; k <= n; ++k) times.push_back(k / static_cast<double>(n));
  return times;
}
double distance(const SE3<>& A, const SE3<>& B) {
  const Screw<> X = log(inverse(A) * B);
  return norm(X.w) + norm(X.v);
}
/// log2 of the ratio of the errors with n and 2 n steps.
template <class Method> double order_of(const Method& method, int n, const SE3<>& exact) {
  return std::log2(distance(method(steps(n)).back(), exact) / distance(method(steps(2 * n)).back(), exact));
}

template <class Rep> void expect_orders() {
  const SE3<> exact = reconstruct<Rep>(start, turning<Rep>, steps(2000), runge_kutta(5)).back();
  for (int order = 1; order <= 5; ++order) {
    SCOPED_TRACE(order);
    const int n = order == 5 ? 32 : 64;
    const double near = order == 5 ? 0.5 : 0.25;  // for steps of this size the method of Dormand and Prince
                                                  // is more exact than its order says
    EXPECT_NEAR(
        order_of([&](const auto& t) { return reconstruct<Rep>(start, turning<Rep>, t, runge_kutta(order)); },
                 n, exact),
        order, near);
    const auto by_cayley = [&](const auto& t) {
      return reconstruct<Rep>(start, turning<Rep>, t, runge_kutta(order), LocalCoordinates::cayley);
    };
    EXPECT_NEAR(order_of(by_cayley, n, exact), order, near);
    EXPECT_NEAR(
        order_of(
            [&](const auto& t) { return reconstruct_apart<Rep>(start, turning<Rep>, t, runge_kutta(order)); },
            n, exact),
        order, near);
  }
  EXPECT_NEAR(
      order_of([&](const auto& t) { return reconstruct_magnus<Rep>(start, turning<Rep>, t); }, 32, exact), 4,
      0.2);
}

TEST(Reconstruction, HasTheOrdersOfItsMethods) {
  expect_orders<BodyFixed>();
  expect_orders<Spatial>();
}

TEST(Reconstruction, OfAConstantTwistIsExact) {
  const auto body = [](double) { return Twist<BodyFixed>{{0.3, 1, -2}, {1, 2, 3}}; };
  const auto spatial = [](double) { return Twist<Spatial>{{0.3, 1, -2}, {1, 2, 3}}; };
  const Screw<> X{{0.3, 1, -2}, {1, 2, 3}};
  for (int order = 1; order <= 5; ++order) {
    EXPECT_LE(
        distance(reconstruct<BodyFixed>(start, body, steps(3), runge_kutta(order)).back(), start * exp(X)),
        1e-14);
    EXPECT_LE(
        distance(reconstruct<Spatial>(start, spatial, steps(3), runge_kutta(order)).back(), exp(X) * start),
        1e-14);
  }
  EXPECT_LE(distance(reconstruct_magnus<BodyFixed>(start, body, steps(3)).back(), start * exp(X)), 1e-14);
  EXPECT_GT(distance(reconstruct_apart<BodyFixed>(start, body, steps(3)).back(), start * exp(X)), 1e-6);
}

TEST(Reconstruction, OfBothTwistsOfAMotionIsThatMotion) {
  const auto pose = [](double t) {
    return start * exp(Screw<>{{std::sin(t), t, t * t}, {1 - t, std::cos(t), t}});
  };
  const auto body = [&](double t) {
    const double h = 1e-3;
    const auto moved = [&](double dt) { return log(inverse(pose(t)) * pose(t + dt)); };
    const Screw<> X =
        (8 / (12 * h)) * (moved(h) - moved(-h)) - (1 / (12 * h)) * (moved(2 * h) - moved(-2 * h));
    return Twist<BodyFixed>{X.w, X.v};
  };
  const auto spatial = [&](double t) {
    const Twist<BodyFixed> V = body(t);
    const Screw<> X = Ad(pose(t), Screw<>{V.w, V.v});
    return Twist<Spatial>{X.w, X.v};
  };
  EXPECT_LE(distance(reconstruct<BodyFixed>(pose(0), body, steps(100)).back(), pose(1)), 1e-8);
  EXPECT_LE(distance(reconstruct<Spatial>(pose(0), spatial, steps(100)).back(), pose(1)), 1e-8);
}

TEST(Reconstruction, RefusesWhatItCannotUse) {
  const auto still = [](double) { return Twist<BodyFixed>{}; };
  const auto message = [&](std::vector<double> times, const Tableau& method = runge_kutta(4)) {
    return message_of([&] { (void)reconstruct<BodyFixed>(start, still, times, method); });
  };
  EXPECT_THAT(message({0, 1, 1}), testing::StartsWith("times[2] is 1; times must be finite and increase"));
  EXPECT_THAT(message({0, std::nan("")}), testing::StartsWith("times[1] is nan"));
  EXPECT_THAT(message({0, 1}, {1, {{}}, {0.5}, {0}}), testing::StartsWith("tableau: b adds up to 0.5"));
  EXPECT_THAT(message({0, 1}, {1, {{}, {0.5}}, {0, 1}, {0, 0.4}}),
              testing::StartsWith("tableau: c[1] is 0.4"));
  EXPECT_EQ(message_of([] { (void)runge_kutta(6); }), "order is 6; expected 1 to 5");
  EXPECT_EQ(reconstruct<BodyFixed>(start, still, {}).size(), 0u);
}

}  // namespace
}  // namespace axode::test
