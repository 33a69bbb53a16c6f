#pragma once
#include <concepts>

#include "axode/scalar/batch.hpp"

/// sine_cosine(x) computes sine and cosine together, of many angles at once.
///
/// x = n π/2 + r with |r| <= π/4 (Cody and Waite 1980): π/2 is split into parts of 33 bits, so that n times a
/// part is exact up to n = 2^20, and the rounding errors of the subtractions are kept as a second part of r.
/// The polynomials are minimax on |r| <= π/4 (Remez). The error is below 1 ulp for |x| <= 1e6; sine and
/// cosine of larger angles are computed by the standard library.
namespace axode {

template <class T> struct SineCosine { T sine, cosine; };

namespace reduced_angle {

inline constexpr double largest = 1e6;
inline constexpr double two_over_pi = 0x1.45f306dc9c883p-1;
inline constexpr double part[]{0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2ep-69, 0x1.b839a252049c1p-104};
inline constexpr double rounder = 0x1.8p52;  // the last bits of x + rounder are the integer nearest to x
// Coefficients of (sin r - r)/r³ and (cos r - 1 + r²/2)/r⁴ in powers of r².
template <class S>
inline constexpr double sine[]{-0x1.5555555555549p-3, 0x1.111111110f87dp-7,   -0x1.a01a019c1202ep-13,
                               0x1.71de35781616dp-19, -0x1.ae5e66882ff13p-26, 0x1.5d931843fad39p-33};
template <class S>
inline constexpr double cosine[]{0x1.555555555554cp-5,   -0x1.6c16c16c15181p-10, 0x1.a01a019cb216cp-16,
                                 -0x1.27e4f80a33d96p-22, 0x1.1ee9ec18b5e69p-29,  -0x1.8faeb5fa18716p-37};
template <>
inline constexpr double sine<float>[] { -0x1.55554598265f4p-3, 0x1.11075fd3de024p-7, -0x1.994e874adf950p-13 };
template <>
inline constexpr double cosine<float>[] {
  0x1.55554ab332b16p-5, -0x1.6c0c8b33edda2p-10, 0x1.9a02320c58a94p-16
};

/// The sum c[0] + c[1] z + ..., by Horner's rule.
template <class S, class Lanes, std::size_t n> Lanes sum(const double (&c)[n], const Lanes& z) {
  Lanes r = z * static_cast<S>(c[n - 1]) + static_cast<S>(c[n - 2]);
  for (std::size_t k = n - 2; k-- > 0;) r = r * z + static_cast<S>(c[k]);
  return r;
}

}  // namespace reduced_angle

/// Replaces `result` by sine and cosine of the standard library in lanes with |x| > reduced_angle::largest.
template <class S, std::size_t N>
[[gnu::noinline, gnu::cold]] SineCosine<Batch<S, N>> mend(const Batch<S, N>& x,
                                                          SineCosine<Batch<S, N>> result) {
  for (std::size_t k = 0; k < N; ++k)
    if (std::abs(x.x[k]) > S(reduced_angle::largest)) {
      result.sine.x[k] = std::sin(x.x[k]);
      result.cosine.x[k] = std::cos(x.x[k]);
    }
  return result;
}

/// Computes sine and cosine of all lanes of x at once.
template <class S, std::size_t N>
[[gnu::always_inline]] inline SineCosine<Batch<S, N>> sine_cosine(const Batch<S, N>& x) {
  namespace reduced = reduced_angle;
  using Double = Batch<double, N>;
  using Lanes = typename Batch<S, N>::Lanes;
  using Bits = typename Batch<S, N>::Bits;
  const auto angle = __builtin_convertvector(x.x, typename Double::Lanes);
  const auto n_bits = angle * reduced::two_over_pi + reduced::rounder, n = n_bits - reduced::rounder;
  const auto t = angle - n * reduced::part[0];
  const auto n1 = n * reduced::part[1], n2 = n * reduced::part[2], t1 = t - n1, t2 = t1 - n2;
  const auto low = (((t - t1) - n1) + ((t1 - t2) - n2)) - n * reduced::part[3];
  const auto quadrant = __builtin_convertvector((typename Double::Bits)n_bits, Bits);
  const Lanes r = __builtin_convertvector(t2, Lanes), rest = __builtin_convertvector(low, Lanes);
  const Lanes z = r * r, half = z * S(0.5), one = Lanes{} + S(1), c = one - half;
  const Lanes sine = r + (r * z * reduced::sum<S>(reduced::sine<S>, z) + rest * c);
  const Lanes cosine = c + (((one - c) - half) + (z * z * reduced::sum<S>(reduced::cosine<S>, z) - r * rest));
  const Bits odd = (quadrant & 1) != 0, lower = (quadrant & 2) != 0, left = ((quadrant + 1) & 2) != 0;
  SineCosine<Batch<S, N>> result{Batch<S, N>(odd ? cosine : sine), Batch<S, N>(odd ? sine : cosine)};
  result.sine.x = lower ? -result.sine.x : result.sine.x;
  result.cosine.x = left ? -result.cosine.x : result.cosine.x;
  if (any(x > Batch<S, N>(reduced::largest) || x < Batch<S, N>(-reduced::largest))) [[unlikely]]
    return mend(x, result);
  return result;
}
template <class S, std::size_t N> Batch<S, N> sin(const Batch<S, N>& x) { return sine_cosine(x).sine; }
template <class S, std::size_t N> Batch<S, N> cos(const Batch<S, N>& x) { return sine_cosine(x).cosine; }

/// Computes sine and cosine of a scalar whose type has no function for both at once.
template <class T> SineCosine<T> sine_cosine(const T& x) { return {sin(x), cos(x)}; }

/// Number of lanes of one SIMD register of the processor that the code is compiled for.
#if defined(__AVX512F__)
template <class S> inline constexpr std::size_t native_lanes = 64 / sizeof(S);
#elif defined(__AVX__)
template <class S> inline constexpr std::size_t native_lanes = 32 / sizeof(S);
#else
template <class S> inline constexpr std::size_t native_lanes = 16 / sizeof(S);
#endif

/// Computes sine[k] and cosine[k] of n angles. The arrays must be longer than n: up to native_lanes - 1
/// entries beyond the n-th are read from `angle` and written to `sine` and `cosine`.
template <class T> void sine_cosine(const T* angle, T* sine, T* cosine, int n) {
  if constexpr (std::floating_point<T>) {
    constexpr int lanes = static_cast<int>(native_lanes<T>);
    for (int k = 0; k < n; k += lanes) {
      const auto r = sine_cosine(Batch<T, native_lanes<T>>::load(angle + k));
      r.sine.store(sine + k);
      r.cosine.store(cosine + k);
    }
  } else {
    for (int k = 0; k < n; ++k) {
      const auto r = sine_cosine(angle[k]);
      sine[k] = r.sine;
      cosine[k] = r.cosine;
    }
  }
}

}  // namespace axode
