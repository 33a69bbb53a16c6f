#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "axode/lie/scalar.hpp"

namespace axode {

/// N numbers on which every operation acts at once, in one or a few SIMD registers: functions of
/// Batch<double, 8> compute eight states at once. N is a power of 2. Comparisons give a Mask with a truth
/// value for each lane.
template <class S, std::size_t N> struct alignas(N * sizeof(S)) Batch {
  using Lanes [[gnu::vector_size(N * sizeof(S))]] = S;
  using Integer = std::conditional_t<sizeof(S) == 8, std::int64_t, std::int32_t>;
  using Bits [[gnu::vector_size(N * sizeof(S))]] = Integer;
  struct Mask {
    Bits bits;
    friend Mask operator&&(const Mask& a, const Mask& b) { return {a.bits & b.bits}; }
    friend Mask operator||(const Mask& a, const Mask& b) { return {a.bits | b.bits}; }
    friend Mask operator!(const Mask& a) { return {~a.bits}; }
    bool operator[](std::size_t k) const { return bits[k] != 0; }
    friend bool any(const Mask& a) {
      std::uint64_t words[sizeof(Bits) / 8];
      std::uint64_t sum = 0;
      __builtin_memcpy(words, &a.bits, sizeof words);
      for (const std::uint64_t word : words) sum |= word;
      return sum != 0;
    }
  };

  Lanes x;

  Batch() = default;
  explicit Batch(const Lanes& lanes) : x(lanes) {}
  template <class Number>
    requires std::is_arithmetic_v<Number> Batch(
        Number value)  // NOLINT(google-explicit-constructor): in every lane
        : x(static_cast<S>(value) - Lanes{}) {}
    /// Loads N numbers from p on; p need not be aligned.
    static Batch load(const S* p) {
      Batch r;
      __builtin_memcpy(&r.x, p, sizeof r.x);
      return r;
    }
    /// Stores the N numbers from p on; p need not be aligned.
    void store(S* p) const { __builtin_memcpy(p, &x, sizeof x); }
    S operator[](std::size_t k) const { return x[k]; }

    friend Batch operator+(const Batch& a, const Batch& b) { return Batch(a.x + b.x); }
    friend Batch operator-(const Batch& a, const Batch& b) { return Batch(a.x - b.x); }
    friend Batch operator*(const Batch& a, const Batch& b) { return Batch(a.x * b.x); }
    friend Batch operator*(S a, const Batch& b) { return Batch(a * b.x); }
    friend Batch operator/(const Batch& a, const Batch& b) { return Batch(a.x / b.x); }
    friend Batch operator-(const Batch& a) { return Batch(-a.x); }
    Batch& operator+=(const Batch& b) { return *this = *this + b; }
    Batch& operator-=(const Batch& b) { return *this = *this - b; }

    friend Mask operator<(const Batch& a, const Batch& b) { return {a.x < b.x}; }
    friend Mask operator>(const Batch& a, const Batch& b) { return {a.x > b.x}; }
    friend Mask operator<=(const Batch& a, const Batch& b) { return {a.x <= b.x}; }
    friend Mask operator>=(const Batch& a, const Batch& b) { return {a.x >= b.x}; }
    friend Batch select(const Mask& condition, const Batch& a, const Batch& b) {
      return Batch(condition.bits ? a.x : b.x);
    }
    friend Batch sqrt(const Batch& a) {
      Batch r;
      for (std::size_t k = 0; k < N; ++k) r.x[k] = std::sqrt(a.x[k]);
      return r;
    }
    friend Batch atan2(const Batch& a, const Batch& b) {
      Batch r;
      for (std::size_t k = 0; k < N; ++k) r.x[k] = std::atan2(a.x[k], b.x[k]);
      return r;
    }
};

template <class S, std::size_t N> inline constexpr double unit_roundoff<Batch<S, N>> = unit_roundoff<S>;

}  // namespace axode
