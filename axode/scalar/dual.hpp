#pragma once
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <type_traits>

#include "axode/lie/scalar.hpp"

namespace axode {

/// A dual number: a number and its derivatives in N directions, for automatic differentiation. Nested Dual
/// numbers carry second derivatives. A product of two Dual numbers costs 2N + 1 products and N sums.
template <class S, std::size_t N> struct Dual {
  S x{};                  ///< the value
  std::array<S, N> dx{};  ///< the derivatives

  constexpr Dual() = default;
  constexpr Dual(const S& value)
      : x(value) {}  // NOLINT(google-explicit-constructor): constants have no derivative
  constexpr Dual(const S& value, const std::array<S, N>& derivatives) : x(value), dx(derivatives) {}
  /// A constant of another arithmetic type, for example a double if S itself is a Dual.
  template <class Number>
    requires(!std::same_as<Number, S> && std::constructible_from<S, Number> && std::is_arithmetic_v<Number>)
  constexpr Dual(Number value) : x(static_cast<S>(value)) {}  // NOLINT(google-explicit-constructor)

  friend constexpr Dual operator+(const Dual& a, const Dual& b) {
    return linear(a.x + b.x, a, S(1), b, S(1));
  }
  friend constexpr Dual operator-(const Dual& a, const Dual& b) {
    return linear(a.x - b.x, a, S(1), b, S(-1));
  }
  friend constexpr Dual operator-(const Dual& a) { return chain(-a.x, a, S(-1)); }
  friend constexpr Dual operator*(const Dual& a, const Dual& b) { return linear(a.x * b.x, a, b.x, b, a.x); }
  friend constexpr Dual operator/(const Dual& a, const Dual& b) {
    const S i = S(1) / b.x, q = a.x * i;
    return linear(q, a, i, b, -(q * i));
  }
  constexpr Dual& operator+=(const Dual& b) { return *this = *this + b; }
  constexpr Dual& operator-=(const Dual& b) { return *this = *this - b; }

  friend constexpr Dual sqrt(const Dual& a) {
    const S r = sqrt(a.x);
    return chain(r, a, S(0.5) / r);
  }
  friend constexpr Dual sin(const Dual& a) { return chain(sin(a.x), a, cos(a.x)); }
  friend constexpr Dual cos(const Dual& a) { return chain(cos(a.x), a, -sin(a.x)); }
  friend constexpr Dual atan2(const Dual& a, const Dual& b) {
    const S i = S(1) / (b.x * b.x + a.x * a.x);
    return linear(atan2(a.x, b.x), a, b.x * i, b, -(a.x * i));
  }
  /// The nearest integer. It is piecewise constant, and its derivatives are 0.
  friend constexpr Dual round(const Dual& a) {
    using std::round;
    return Dual(round(a.x));
  }
  friend constexpr bool operator<(const Dual& a, const Dual& b) { return a.x < b.x; }
  friend constexpr bool operator>(const Dual& a, const Dual& b) { return b < a; }
  friend constexpr Dual select(bool condition, const Dual& a, const Dual& b) { return condition ? a : b; }

 private:
  /// The value f(a) with the derivatives f'(a) a', where f'(a) is the slope.
  static constexpr Dual chain(const S& value, const Dual& a, const S& slope) {
    Dual r(value);
    for (std::size_t k = 0; k < N; ++k) r.dx[k] = slope * a.dx[k];
    return r;
  }
  /// The value f(a, b) with the derivatives slope_a a' + slope_b b'.
  static constexpr Dual linear(const S& value, const Dual& a, const S& slope_a, const Dual& b,
                               const S& slope_b) {
    Dual r(value);
    for (std::size_t k = 0; k < N; ++k) r.dx[k] = slope_a * a.dx[k] + slope_b * b.dx[k];
    return r;
  }
};

template <class S, std::size_t N> inline constexpr double unit_roundoff<Dual<S, N>> = unit_roundoff<S>;

}  // namespace axode
