#pragma once
#include <algorithm>
#include <array>

#include "axode/fast/lanes.hpp"
#include "axode/scalar/transpose.hpp"

/// Symmetric matrices of n rows, computed above the diagonal in square blocks of rows in lanes and turned in registers.
namespace axode {

template <class T> using SquareBlock = std::array<typename Lanes<T>::Number, Lanes<T>::width>;

template <class T> [[gnu::always_inline]] inline SquareBlock<T> turned(const SquareBlock<T>& block) {
  SquareBlock<T> rows;
  unrolled<Lanes<T>::width>([&](auto m) { rows[m] = block[m]; });
  if constexpr (Lanes<T>::width > 1) transpose(rows);
  return rows;
}

/// Where the last block of n rows begins; before the first row where there is none.
template <class T> int last_block(int n) {
  return (n + Lanes<T>::width - 1) / Lanes<T>::width * Lanes<T>::width - Lanes<T>::width;
}

/// Row i of the matrix from column j on, if there is one. What it writes too much for its row is the start of the next ones,
/// which are to be written later.
template <class T>
[[gnu::always_inline]] inline void store_row(const typename Lanes<T>::Number& x, int i, int j, int n, T* to) {
  if (i < n) Lanes<T>::store(x, to, (n - i) * n - j);
}
/// Rows i, ... from column j on, in the same way.
template <class T>
[[gnu::always_inline]] inline void store(const SquareBlock<T>& block, int i, int j, int n, T* M) {
  T* const to = M + static_cast<std::ptrdiff_t>(i) * n + j;
  unrolled<Lanes<T>::width>(
      [&](auto m) { store_row(block[m], i + m, j, n, to + m * static_cast<std::ptrdiff_t>(n)); });
}

/// The part below the diagonal from the part above, but for the blocks on the diagonal.
template <class T> void mirror(int n, T* M) noexcept {
  using L = Lanes<T>;
  for (int i = 0; i + L::width < n; i += L::width)
    for (int j = i + L::width; j < n; j += L::width) {
      SquareBlock<T> block;
      unrolled<L::width>([&](auto m) { block[m] = L::load(M + static_cast<std::ptrdiff_t>(i + m) * n + j); });
      store(turned<T>(block), j, i, n, M);
    }
}

}  // namespace axode
