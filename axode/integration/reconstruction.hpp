#pragma once
#include <array>
#include <concepts>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/integration/tableau.hpp"
#include "axode/lie/twist.hpp"

/// Kinematic reconstruction: the motion C(t) of a body from its twist, by C' = C V^b or C' = V^s C (eq. Vbs).
namespace axode {

/// Times of the steps: each must be finite and greater than the one before. Throws std::invalid_argument.
inline void check_times(std::span<const double> times) {
  for (std::size_t k = 0; k < times.size(); ++k)
    if (!(times[k] - times[k] == 0) || (k > 0 && !(times[k] > times[k - 1])))
      throw std::invalid_argument("times[" + std::to_string(k) + "] is " + std::to_string(times[k]) +
                                  "; times must be finite and increase");
}

/// By Munthe-Kaas' method: a step is C exp(X), or exp(X) C, and X' = dexp_{-X}⁻¹ V^b, or dexp_X⁻¹ V^s (eq. Vdexp), is
/// solved with a tableau. `twist(t)` is a Twist<Rep>, Rep BodyFixed or Spatial. The poses at all times, the first of which
/// is C0; a step lies between any two of them. The order of the tableau.
template <class Rep, std::invocable<double> F>
  requires std::same_as<Rep, BodyFixed> || std::same_as<Rep, Spatial> std::vector<SE3<>> reconstruct(
      const SE3<>& C0, const F& twist, std::span<const double> times,
      const Tableau& method = runge_kutta(4)) {
    check_times(times), check(method);
    const std::size_t stages = method.b.size();
    std::vector<SE3<>> C(times.size());
    std::vector<Screw<>> K(stages);
    for (std::size_t k = 0; k < times.size(); ++k) {
      if (k == 0) {
        C[0] = C0;
        continue;
      }
      const double h = times[k] - times[k - 1];
      const auto sum = [&](const std::vector<double>& weights) {
        Screw<> X{};
        for (std::size_t j = 0; j < weights.size(); ++j) X = X + (h * weights[j]) * K[j];
        return X;
      };
      for (std::size_t i = 0; i < stages; ++i) {
        const Screw<> X = sum(method.a[i]);
        const Twist<Rep> V = twist(times[k - 1] + method.c[i] * h);
        K[i] = dexp_inv(std::same_as<Rep, BodyFixed> ? -X : X, Screw<>{V.w, V.v});
      }
      const SE3<> step = exp(sum(method.b));
      C[k] = std::same_as<Rep, BodyFixed> ? C[k - 1] * step : step * C[k - 1];
    }
    return C;
  }

/// By Magnus' series to fourth order, from two twists in each step: X = h (V_1 + V_2) / 2 ± √3/12 h² [V_1, V_2], + for body-fixed
/// twists. The points of Gauss and Legendre.
template <class Rep, std::invocable<double> F>
  requires std::same_as<Rep, BodyFixed> || std::same_as<Rep, Spatial> std::vector<SE3<>> reconstruct_magnus(
      const SE3<>& C0, const F& twist, std::span<const double> times) {
    check_times(times);
    constexpr double root = 0.28867513459481287;  // √3/6
    std::vector<SE3<>> C(times.size());
    for (std::size_t k = 0; k < times.size(); ++k) {
      if (k == 0) {
        C[0] = C0;
        continue;
      }
      const double h = times[k] - times[k - 1], middle = times[k - 1] + h / 2;
      const Twist<Rep> V_1 = twist(middle - root * h), V_2 = twist(middle + root * h);
      const Screw<> X_1{V_1.w, V_1.v}, X_2{V_2.w, V_2.v};
      const double turn = (std::same_as<Rep, BodyFixed> ? 0.5 : -0.5) * root * h * h;
      const SE3<> step = exp((h / 2) * (X_1 + X_2) + turn * ad(X_1, X_2));
      C[k] = std::same_as<Rep, BodyFixed> ? C[k - 1] * step : step * C[k - 1];
    }
    return C;
  }

/// The same by Munthe-Kaas on SO(3) × R³, where rotation and position are integrated apart; for comparison.
template <class Rep, std::invocable<double> F>
  requires std::same_as<Rep, BodyFixed> || std::same_as<Rep, Spatial> std::vector<SE3<>> reconstruct_apart(
      const SE3<>& C0, const F& twist, std::span<const double> times,
      const Tableau& method = runge_kutta(4)) {
    check_times(times), check(method);
    const std::size_t stages = method.b.size();
    std::vector<SE3<>> C(times.size());
    std::vector<Vec3<>> K(stages), dr(stages);
    for (std::size_t k = 0; k < times.size(); ++k) {
      if (k == 0) {
        C[0] = C0;
        continue;
      }
      const double h = times[k] - times[k - 1];
      const auto sum = [&](const std::vector<double>& weights, const std::vector<Vec3<>>& rates) {
        Vec3<> x{};
        for (std::size_t j = 0; j < weights.size(); ++j) x += (h * weights[j]) * rates[j];
        return x;
      };
      const auto turned = [&](const Vec3<>& x) {
        return std::same_as<Rep, BodyFixed> ? C[k - 1].R * exp_SO3(x) : exp_SO3(x) * C[k - 1].R;
      };
      for (std::size_t i = 0; i < stages; ++i) {
        const Vec3<> x = sum(method.a[i], K), r = C[k - 1].r + sum(method.a[i], dr);
        const Twist<Rep> V = twist(times[k - 1] + method.c[i] * h);
        K[i] = dexp_inv(std::same_as<Rep, BodyFixed> ? -x : x, V.w);
        dr[i] = std::same_as<Rep, BodyFixed> ? turned(x) * V.v : V.v + cross(V.w, r);
      }
      C[k] = {turned(sum(method.b, K)), C[k - 1].r + sum(method.b, dr)};
    }
    return C;
  }

}  // namespace axode
