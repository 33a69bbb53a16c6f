#pragma once
#include <array>
#include <cstddef>

#include "axode/lie/vec3.hpp"

/// The coefficients of exp, dexp and dexp⁻¹ on SO(3) and SE(3), accurate at every angle.
///
/// On so(3) each of these maps is an operator P_ξ = I + β(s) ξ̃ + γ(s) ξ̃² with s = ‖ξ‖². On se(3), dexp and
/// dexp⁻¹ have P_ξ in their two diagonal 3×3 blocks, and the derivative of P_ξ along the linear part in the
/// third block (principle of transference). Therefore directional derivatives need β and γ with their first
/// and second derivatives by s.
namespace axode {

/// An operator P_ξ = I + β(s) ξ̃ + γ(s) ξ̃² on so(3) with s = ‖ξ‖²; beta[k] is the k-th derivative of β by s.
template <class T> struct ScrewOperator { std::array<T, 3> beta, gamma; };

/// Computes P_ξ z for the operator P_ξ = I + β(s) ξ̃ + γ(s) ξ̃² with s = ‖ξ‖².
template <class T> constexpr Vec3<T> apply(const ScrewOperator<T>& P, const Vec3<T>& xi, const Vec3<T>& z) {
  const Vec3<T> xi_z = cross(xi, z);
  return z + P.beta[0] * xi_z + P.gamma[0] * cross(xi, xi_z);
}

/// Computes the derivative of P_ξ z along η, where P_ξ = I + β(s) ξ̃ + γ(s) ξ̃² on so(3) with s = ‖ξ‖².
template <class T>
constexpr Vec3<T> apply(const ScrewOperator<T>& P, const Vec3<T>& xi, const Vec3<T>& eta, const Vec3<T>& z) {
  const T ds = T(2) * dot(xi, eta);
  const Vec3<T> xi_z = cross(xi, z), eta_z = cross(eta, z);
  return P.beta[0] * eta_z + P.gamma[0] * (cross(xi, eta_z) + cross(eta, xi_z)) +
         ds * (P.beta[1] * xi_z + P.gamma[1] * cross(xi, xi_z));
}

/// The second derivative of P_ξ z along η and ζ, where P_ξ = I + β(s) ξ̃ + γ(s) ξ̃² on so(3) with s = ‖ξ‖².
template <class T>
constexpr Vec3<T> apply(const ScrewOperator<T>& P, const Vec3<T>& xi, const Vec3<T>& eta, const Vec3<T>& zeta,
                        const Vec3<T>& z) {
  const T s_eta = T(2) * dot(xi, eta), s_zeta = T(2) * dot(xi, zeta), s_both = T(2) * dot(eta, zeta);
  const Vec3<T> xi_z = cross(xi, z), eta_z = cross(eta, z), zeta_z = cross(zeta, z);
  const Vec3<T> N = cross(xi, xi_z), N_eta = cross(xi, eta_z) + cross(eta, xi_z),
                N_zeta = cross(xi, zeta_z) + cross(zeta, xi_z);
  return P.gamma[0] * (cross(eta, zeta_z) + cross(zeta, eta_z)) +
         P.beta[1] * (s_both * xi_z + s_eta * zeta_z + s_zeta * eta_z) +
         P.gamma[1] * (s_both * N + s_eta * N_zeta + s_zeta * N_eta) +
         (s_eta * s_zeta) * (P.beta[2] * xi_z + P.gamma[2] * N);
}

namespace series {

/// The s = θ² below which power series in s replace the closed forms, which lose digits there.
inline constexpr double radius = 1.0;
inline constexpr std::size_t terms = 15;
using Coefficients = std::array<double, terms>;

/// The coefficients of Σ_k (-1)^k s^k / (2k + m)! with s = θ², which is sin θ/θ for m = 1, (1 - cos θ)/θ² for
/// m = 2 and (θ - sin θ)/θ³ for m = 3.
constexpr Coefficients alternating_factorials(int m) {
  Coefficients c{};
  double term = 1.0;
  for (int f = 2; f <= m; ++f) term /= f;
  for (std::size_t k = 0; k < terms; ++k) {
    c[k] = term;
    const double f = static_cast<double>(2 * k) + m;
    term /= -(f + 1.0) * (f + 2.0);
  }
  return c;
}

/// The coefficients of (1 - θ/2 cot(θ/2))/θ² = Σ_k 2 ζ(2k + 2)/(2π)^(2k + 2) s^k with s = θ². They are
/// |B_{2k+2}|/(2k + 2)! with Bernoulli's numbers B.
inline constexpr Coefficients cotangent = {
    8.33333333333333333333e-2,  1.38888888888888888889e-3,  3.30687830687830687831e-5,
    8.26719576719576719577e-7,  2.08767569878680989792e-8,  5.28419013868749318485e-10,
    1.33825365306846788328e-11, 3.38968029632258286683e-13, 8.58606205627784456414e-15,
    2.17486869855806187304e-16, 5.5090028283602295152e-18,  1.39544646858125233407e-19,
    3.53470703962946747169e-21, 8.9535174270375468504e-23,  2.26795245233768306031e-24};

/// The coefficients of arcsin(x)/(x √(1 - x²)) = Σ_k (2k)!!/(2k + 1)!! s^k with s = x², for log.
constexpr Coefficients arcsine() {
  Coefficients c{1.0};
  for (std::size_t k = 1; k < terms; ++k) {
    const double f = static_cast<double>(2 * k);
    c[k] = c[k - 1] * f / (f + 1.0);
  }
  return c;
}

/// The coefficients of the derivative of a power series in s with respect to s.
constexpr Coefficients derivative(const Coefficients& c) {
  Coefficients d{};
  for (std::size_t k = 0; k + 1 < terms; ++k) d[k] = static_cast<double>(k + 1) * c[k + 1];
  return d;
}

/// The coefficients of a series and of its first two derivatives with respect to s.
using Table = std::array<Coefficients, 3>;
constexpr Table with_derivatives(const Coefficients& c) {
  return {c, derivative(c), derivative(derivative(c))};
}

inline constexpr Table a = with_derivatives(alternating_factorials(1));
inline constexpr Table b = with_derivatives(alternating_factorials(2));
inline constexpr Table c = with_derivatives(alternating_factorials(3));
inline constexpr Table g = with_derivatives(cotangent);
inline constexpr Coefficients half_angle_over_sine = arcsine();

/// Σ_k coefficients[k] s^k, by Horner's rule.
template <class T> constexpr T sum(const Coefficients& coefficients, const T& s) {
  T y = T(coefficients[terms - 1]);
  for (std::size_t k = terms - 1; k-- > 0;) y = y * s + T(coefficients[k]);
  return y;
}

}  // namespace series

/// The values f, f', f'' of functions of s = θ²: a = sin θ/θ, b = (1 - cos θ)/θ², c = (θ - sin θ)/θ³ and g =
/// (1 - θ/2 cot(θ/2))/θ².
template <class T> class ExponentialCoefficients {
 public:
  using Values = std::array<T, 3>;

  explicit constexpr ExponentialCoefficients(const T& s)
      : s_(s), x_(select(s < T(series::radius), T(1), s)) {  // the closed forms remain finite
    const T theta = sqrt(x_), i = T(1) / (T(2) * x_), half_sine = sin(T(0.5) * theta);
    const T a0 = sin(theta) / theta, b0 = T(2) * half_sine * half_sine / x_, c0 = (T(1) - a0) / x_;
    const T a1 = (cos(theta) - a0) * i, b1 = (a0 - T(2) * b0) * i, c1 = (b0 - T(3) * c0) * i;
    const T a2 = (T(-0.5) * a0 - T(3) * a1) * i, b2 = (a1 - T(4) * b1) * i, c2 = (b1 - T(5) * c1) * i;
    a_ = {a0, a1, a2};
    b_ = {b0, b1, b2};
    c_ = {c0, c1, c2};
  }
  constexpr Values a() const { return choose(series::a, a_); }
  constexpr Values b() const { return choose(series::b, b_); }
  constexpr Values c() const { return choose(series::c, c_); }
  constexpr Values g() const {
    const T h = T(1) / (T(2) * b_[0]);  // u = θ/2 cot(θ/2) = a/(2b), g = (1 - u)/s
    const T u0 = a_[0] * h, u1 = (a_[1] - T(2) * u0 * b_[1]) * h,
            u2 = (a_[2] - T(4) * u1 * b_[1] - T(2) * u0 * b_[2]) * h;
    const T g0 = (T(1) - u0) / x_, g1 = (-u1 - g0) / x_, g2 = (-u2 - T(2) * g1) / x_;
    return choose(series::g, {g0, g1, g2});
  }

 private:
  constexpr Values choose(const series::Table& table, const Values& closed) const {
    const auto near = s_ < T(series::radius);
    return {select(near, series::sum(table[0], s_), closed[0]),
            select(near, series::sum(table[1], s_), closed[1]),
            select(near, series::sum(table[2], s_), closed[2])};
  }

  T s_, x_;
  Values a_, b_, c_;  ///< the closed forms
};

/// exp_ξ = I + (sin θ/θ) ξ̃ + ((1 - cos θ)/θ²) ξ̃² for s = θ² = ‖ξ‖².
template <class T> constexpr ScrewOperator<T> exp_operator(const T& s) {
  const ExponentialCoefficients<T> k(s);
  return {k.a(), k.b()};
}
/// dexp_ξ = I + ((1 - cos θ)/θ²) ξ̃ + ((θ - sin θ)/θ³) ξ̃² for s = θ² = ‖ξ‖².
template <class T> constexpr ScrewOperator<T> dexp_operator(const T& s) {
  const ExponentialCoefficients<T> k(s);
  return {k.b(), k.c()};
}
/// dexp_ξ⁻¹ = I - ξ̃/2 + ((1 - θ/2 cot(θ/2))/θ²) ξ̃² for s = θ² = ‖ξ‖².
template <class T> constexpr ScrewOperator<T> dexp_inv_operator(const T& s) {
  const ExponentialCoefficients<T> k(s);
  return {{T(-0.5), T(0), T(0)}, k.g()};
}

}  // namespace axode
