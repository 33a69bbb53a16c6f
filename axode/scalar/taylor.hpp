#pragma once
#include <array>
#include <cstddef>
#include <type_traits>

#include "axode/scalar/sine_cosine.hpp"

namespace axode {

/// The first N coefficients of a power series in the time t, c[0] + c[1] t + c[2] t² + ..., for automatic
/// differentiation: the time derivatives at t = 0 are k! c[k]. Division and sqrt need c[0] ≠ 0. A product
/// costs about N²/2 products.
template <class S, std::size_t N> struct Taylor {
  std::array<S, N> c{};

  constexpr Taylor() = default;
  constexpr Taylor(const S& value) {
    c[0] = value;
  }  // NOLINT(google-explicit-constructor): constants are series
  template <class Number>
    requires std::is_arithmetic_v<Number>
  constexpr Taylor(Number value) : Taylor(static_cast<S>(value)) {}  // NOLINT(google-explicit-constructor)
  constexpr explicit Taylor(const std::array<S, N>& coefficients) : c(coefficients) {}

  friend constexpr Taylor operator+(const Taylor& a, const Taylor& b) {
    Taylor r;
    for (std::size_t k = 0; k < N; ++k) r.c[k] = a.c[k] + b.c[k];
    return r;
  }
  friend constexpr Taylor operator-(const Taylor& a, const Taylor& b) {
    Taylor r;
    for (std::size_t k = 0; k < N; ++k) r.c[k] = a.c[k] - b.c[k];
    return r;
  }
  friend constexpr Taylor operator-(const Taylor& a) { return Taylor() - a; }
  friend constexpr Taylor operator*(const Taylor& a, const Taylor& b) {
    Taylor r;
    for (std::size_t k = 0; k < N; ++k)
      for (std::size_t j = 0; j <= k; ++j) r.c[k] += a.c[j] * b.c[k - j];
    return r;
  }
  friend constexpr Taylor operator/(const Taylor& a, const Taylor& b) {
    Taylor r;
    for (std::size_t k = 0; k < N; ++k) {
      S s = a.c[k];
      for (std::size_t j = 0; j < k; ++j) s -= r.c[j] * b.c[k - j];
      r.c[k] = s / b.c[0];
    }
    return r;
  }
  constexpr Taylor& operator+=(const Taylor& b) { return *this = *this + b; }
  constexpr Taylor& operator-=(const Taylor& b) { return *this = *this - b; }

  friend constexpr Taylor sqrt(const Taylor& a) {
    Taylor r(sqrt(a.c[0]));
    for (std::size_t k = 1; k < N; ++k) {
      S s = a.c[k];
      for (std::size_t j = 1; j < k; ++j) s -= r.c[j] * r.c[k - j];
      r.c[k] = s / (S(2) * r.c[0]);
    }
    return r;
  }
  /// Sine s and cosine c of a, coefficient by coefficient from s' = c a' and c' = -s a'.
  friend constexpr SineCosine<Taylor> sine_cosine(const Taylor& a) {
    Taylor sine(sin(a.c[0])), cosine(cos(a.c[0]));
    for (std::size_t k = 1; k < N; ++k) {
      for (std::size_t j = 1; j <= k; ++j) {
        const S da = S(static_cast<double>(j)) * a.c[j];
        sine.c[k] += da * cosine.c[k - j];
        cosine.c[k] -= da * sine.c[k - j];
      }
      sine.c[k] = sine.c[k] / S(static_cast<double>(k));
      cosine.c[k] = cosine.c[k] / S(static_cast<double>(k));
    }
    return {sine, cosine};
  }
  friend constexpr Taylor sin(const Taylor& a) { return sine_cosine(a).sine; }
  friend constexpr Taylor cos(const Taylor& a) { return sine_cosine(a).cosine; }
  /// The angle φ of the point (x, y), integrated from φ' = (x y' - y x')/(x² + y²).
  friend constexpr Taylor atan2(const Taylor& y, const Taylor& x) {
    Taylor numerator;  // x y' - y x', one order lower than y and x
    for (std::size_t k = 0; k + 1 < N; ++k)
      for (std::size_t j = 0; j <= k; ++j) {
        const S n(static_cast<double>(k - j + 1));
        numerator.c[k] += n * (x.c[j] * y.c[k - j + 1] - y.c[j] * x.c[k - j + 1]);
      }
    const Taylor rate = numerator / (x * x + y * y);
    Taylor phi(atan2(y.c[0], x.c[0]));
    for (std::size_t k = 1; k < N; ++k) phi.c[k] = rate.c[k - 1] / S(static_cast<double>(k));
    return phi;
  }
  friend constexpr bool operator<(const Taylor& a, const Taylor& b) { return a.c[0] < b.c[0]; }
  friend constexpr bool operator>(const Taylor& a, const Taylor& b) { return b < a; }
  friend constexpr Taylor select(bool condition, const Taylor& a, const Taylor& b) {
    return condition ? a : b;
  }
};

/// The k-th time derivative of a series at t = 0.
template <class S, std::size_t N> constexpr S derivative(const Taylor<S, N>& a, std::size_t k) {
  S factorial(1);
  for (std::size_t j = 2; j <= k; ++j) factorial = factorial * S(static_cast<double>(j));
  return factorial * a.c[k];
}

template <class S, std::size_t N> inline constexpr double unit_roundoff<Taylor<S, N>> = unit_roundoff<S>;

}  // namespace axode
