#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/integration/local_coordinates.hpp"
#include "axode/integration/tableau.hpp"
#include "axode/lie/cayley.hpp"
#include "axode/lie/twist.hpp"
#include "axode/scalar/text.hpp"

/// Kinematic reconstruction: computes the motion C(t) of a body from its twist by C' = C V^b or C' = V^s C
/// (Müller, eq. Vbs), with Runge-Kutta-Munthe-Kaas methods or Magnus' series. The function twist(t) gives the
/// body-fixed or the spatial twist at time t. The results are the poses at all given times, beginning with
/// C0, and one step leads from each time to the next. Throws std::invalid_argument if times do not increase
/// or are not finite, and if the coefficients of the Runge-Kutta method (its Butcher tableau) are
/// inconsistent.
namespace axode {

/// Twists that are the left or right logarithmic derivative of a pose.
template <class Rep>
concept PoseRate = std::same_as<Rep, BodyFixed> || std::same_as<Rep, Spatial>;

namespace reconstruction {

/// Computes the poses at all times from the pose C0 at the first of them, by C_{k+1} = step(C_k, t_k, h) with
/// h = t_{k+1} - t_k. Throws std::invalid_argument if times do not increase or are not finite.
template <class Step>
std::vector<SE3<>> in_steps(const SE3<>& C0, std::span<const double> times, const Step& step) {
  std::vector<SE3<>> C;
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (!(times[k] - times[k] == 0) || (k > 0 && !(times[k] > times[k - 1])))
      throw std::invalid_argument("times[" + std::to_string(k) + "] is " + to_text(times[k]) +
                                  "; times must be finite and increase");
    C.push_back(k == 0 ? C0 : step(C.back(), times[k - 1], times[k] - times[k - 1]));
  }
  return C;
}
/// The weighted sum h Σ w_j x_j.
template <class X> X sum(const std::vector<double>& weights, double h, const std::vector<X>& x) {
  X out{};
  for (std::size_t j = 0; j < weights.size(); ++j) out = out + (h * weights[j]) * x[j];
  return out;
}
/// The pose C displaced by D: C D if D is body-fixed, D C if it is spatial.
template <PoseRate Rep> SE3<> moved(const SE3<>& C, const SE3<>& D) {
  return std::same_as<Rep, BodyFixed> ? C * D : D * C;
}

}  // namespace reconstruction

/// Computes the motion of a body from its twist by Munthe-Kaas' method: a step is C exp(X), or exp(X) C,
/// where X' = dexp_{-X}⁻¹ V^b, or dexp_X⁻¹ V^s (Müller, eq. Vdexp with erratum 27 of docs/errata.md), is
/// integrated by the Runge-Kutta method of the tableau. With LocalCoordinates::cayley, Cayley's map replaces
/// exp. Returns the poses at all times.
template <PoseRate Rep, std::invocable<double> F>
std::vector<SE3<>> reconstruct(const SE3<>& C0, const F& twist, std::span<const double> times,
                               const Tableau& method = runge_kutta(4),
                               LocalCoordinates coordinates = LocalCoordinates::exponential) {
  check(method);
  const bool by_exp = coordinates == LocalCoordinates::exponential;
  std::vector<Screw<>> K(method.b.size());
  return reconstruction::in_steps(C0, times, [&](const SE3<>& C, double t, double h) {
    for (std::size_t i = 0; i < K.size(); ++i) {
      const Screw<> X = reconstruction::sum(method.a[i], h, K);
      const Twist<Rep> V = twist(t + method.c[i] * h);
      const Screw<> Y = std::same_as<Rep, BodyFixed> ? -X : X, Z{V.w, V.v};
      K[i] = by_exp ? dexp_inv(Y, Z) : dcay_inv(Y, Z);
    }
    const Screw<> X = reconstruction::sum(method.b, h, K);
    return reconstruction::moved<Rep>(C, by_exp ? exp(X) : cay(X));
  });
}

/// The two Gauss-Legendre points of a step, in units of the length of the step.
inline constexpr std::array<double, 2> magnus_points{0.5 - 0.28867513459481287, 0.5 + 0.28867513459481287};

/// Computes the motion of a body from its twist by Magnus' series to fourth order, and returns the poses at
/// all times. A step of length h is C exp(X) for body-fixed and exp(X) C for spatial twists. There X = h (V_1
/// + V_2) / 2 ± √3/12 h² [V_1, V_2], with the twists V_1 and V_2 at the two Gauss-Legendre points of the
/// step, + for body-fixed and - for spatial twists.
template <PoseRate Rep, std::invocable<double> F>
std::vector<SE3<>> reconstruct_magnus(const SE3<>& C0, const F& twist, std::span<const double> times) {
  constexpr double root = magnus_points[1] - 0.5;  // √3/6
  return reconstruction::in_steps(C0, times, [&](const SE3<>& C, double t, double h) {
    const Twist<Rep> V_1 = twist(t + magnus_points[0] * h), V_2 = twist(t + magnus_points[1] * h);
    const Screw<> X_1{V_1.w, V_1.v}, X_2{V_2.w, V_2.v};
    const double turn = (std::same_as<Rep, BodyFixed> ? 0.5 : -0.5) * root * h * h;
    return reconstruction::moved<Rep>(C, exp((h / 2) * (X_1 + X_2) + turn * ad(X_1, X_2)));
  });
}

/// Computes the motion of a body from its twist by Munthe-Kaas' method on SO(3) × R³, for comparison with
/// SE(3): rotation and position are integrated separately. Returns the poses at all times.
template <PoseRate Rep, std::invocable<double> F>
std::vector<SE3<>> reconstruct_apart(const SE3<>& C0, const F& twist, std::span<const double> times,
                                     const Tableau& method = runge_kutta(4)) {
  check(method);
  constexpr bool body_fixed = std::same_as<Rep, BodyFixed>;
  std::vector<Vec3<>> K(method.b.size()), dr(K.size());
  return reconstruction::in_steps(C0, times, [&](const SE3<>& C, double t, double h) {
    const auto turned = [&](const Vec3<>& x) { return body_fixed ? C.R * exp_SO3(x) : exp_SO3(x) * C.R; };
    for (std::size_t i = 0; i < K.size(); ++i) {
      const Vec3<> x = reconstruction::sum(method.a[i], h, K);
      const Twist<Rep> V = twist(t + method.c[i] * h);
      K[i] = dexp_inv(body_fixed ? -x : x, V.w);
      dr[i] = body_fixed ? turned(x) * V.v : V.v + cross(V.w, C.r + reconstruction::sum(method.a[i], h, dr));
    }
    return SE3<>{turned(reconstruction::sum(method.b, h, K)), C.r + reconstruction::sum(method.b, h, dr)};
  });
}

}  // namespace axode
