#pragma once
#include "axode/scalar/transpose.hpp"

/// Transposes contiguous states to arrays of SIMD numbers with a state in each lane, and back.
namespace axode::batch {

template <class S> constexpr int cache_line = static_cast<int>(64 / sizeof(S));

/// Calls f(k) for the first index k of each block of N out of n >= N numbers. The last two may overlap.
template <int N, class F> void each_block(std::ptrdiff_t n, const F& f) {
  std::ptrdiff_t k = 0;
  for (; k + N <= n; k += N) f(k);
  if (k < n) f(n - N);
}

/// Copies in[l * n + k], number k of the state in lane l, to lane l of out[k], for k < n.
template <class S, std::size_t N> void gather(const S* in, std::ptrdiff_t n, Batch<S, N>* out) {
  constexpr int lanes = static_cast<int>(N);
  for (std::ptrdiff_t k = lanes * n; k < 2 * lanes * n; k += cache_line<S>)
    __builtin_prefetch(in + k);  // the states of the next call
  using Row = Batch<S, N>;
  std::array<Row, N> rows;
  if (n >= lanes) {
    each_block<lanes>(n, [&](std::ptrdiff_t k) {
      for (int l = 0; l < lanes; ++l) rows[l] = Row::load(in + l * n + k);
      transpose(rows);
      for (int l = 0; l < lanes; ++l) out[k + l] = rows[l];
    });
    return;
  }
  for (int l = 0; l < lanes; ++l) {  // a load may read beyond a short row, but not beyond the last state
    if (l * n + lanes <= lanes * n) {
      rows[l] = Row::load(in + l * n);
    } else {
      rows[l] = Row(S(0));
      for (int k = 0; k < n; ++k) rows[l].x[k] = in[l * n + k];
    }
  }
  transpose(rows);
  for (int k = 0; k < n; ++k) out[k] = rows[k];
}
/// Copies lane l of in[k], number k of the state in lane l, to out[l * n + k], for k < n.
template <class S, std::size_t N> void scatter(const Batch<S, N>* in, std::ptrdiff_t n, S* out) {
  constexpr int lanes = static_cast<int>(N), ahead = 8 * cache_line<S>;
  std::array<Batch<S, N>, N> rows;
  if (n >= lanes) {
    each_block<lanes>(n, [&](std::ptrdiff_t k) {
      for (int l = 0; l < lanes; ++l) rows[l] = in[k + l];
      transpose(rows);
      for (int l = 0; l < lanes; ++l) {
        S* const row = out + l * n + k;
        __builtin_prefetch(row + ahead, 1);
        rows[l].store(row);
      }
    });
    return;
  }
  for (int k = 0; k < lanes; ++k) rows[k] = k < n ? in[k] : Batch<S, N>(S(0));
  transpose(rows);
  for (int l = 0; l < lanes; ++l) {  // a store may write into the next row, which is stored later
    if (l * n + lanes <= lanes * n)
      rows[l].store(out + l * n);
    else
      for (int k = 0; k < n; ++k) out[l * n + k] = rows[l].x[k];
  }
}

}  // namespace axode::batch
