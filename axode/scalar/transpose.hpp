#pragma once
#include <array>
#include <utility>

#include "axode/scalar/batch.hpp"

namespace axode {

/// Takes N of the 2 N lanes of two batches a, b: lane l is lane order[l] of a followed by b.
template <class S, std::size_t N, std::size_t... order>
Batch<S, N> pick(const Batch<S, N>& a, const Batch<S, N>& b, std::index_sequence<order...>) {
#if defined(__clang__)
  return Batch<S, N>(__builtin_shufflevector(a.x, b.x, order...));
#else
  using Bits = typename Batch<S, N>::Bits;
  return Batch<S, N>(__builtin_shuffle(a.x, b.x, Bits{static_cast<typename Batch<S, N>::Integer>(order)...}));
#endif
}
/// Exchanges each lane l of a for which the bit s of l, a power of 2, is set with lane l - s of b.
template <std::size_t s, class S, std::size_t N, std::size_t... l>
void exchange(Batch<S, N>& a, Batch<S, N>& b, std::index_sequence<l...>) {
  const Batch<S, N> low = pick(a, b, std::index_sequence<((l & s) ? N + l - s : l)...>{});
  b = pick(a, b, std::index_sequence<((l & s) ? N + l : l + s)...>{});
  a = low;
}
/// Calls f(0), ..., f(n - 1) with compile-time constants, so that arrays can stay in registers.
template <int n, class F> [[gnu::always_inline]] inline void unrolled(const F& f) {
  [&]<int... m>(std::integer_sequence<int, m...>) __attribute__((always_inline)) {
    (f(std::integral_constant<int, m>{}), ...);
  }
  (std::make_integer_sequence<int, n>{});
}
/// Transposes N rows of N lanes in place by N log2 N shuffles: row l of the result has lane l of every row.
template <class S, std::size_t N, std::size_t s = 1>
[[gnu::always_inline]] inline void transpose(std::array<Batch<S, N>, N>& rows) {
  if constexpr (s < N) {
    unrolled<static_cast<int>(N)>([&](auto i) __attribute__((always_inline)) {
      if constexpr (!(i & s)) exchange<s>(rows[i], rows[i + s], std::make_index_sequence<N>{});
    });
    transpose<S, N, 2 * s>(rows);
  }
}

}  // namespace axode
