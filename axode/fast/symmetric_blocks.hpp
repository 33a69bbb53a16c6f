#pragma once
#include <algorithm>
#include <array>

#include "axode/fast/lanes.hpp"
#include "axode/scalar/transpose.hpp"

/// Stores symmetric matrices that are computed in square blocks, with the columns of a block in SIMD lanes.
/// Blocks on and above the diagonal are computed; each block below the diagonal is the transpose of one above
/// it.
namespace axode {

template <class T> using SquareBlock = std::array<typename Lanes<T>::Number, Lanes<T>::width>;

/// The transpose of a square block.
template <class T> [[gnu::always_inline]] inline SquareBlock<T> transposed(const SquareBlock<T>& block) {
  SquareBlock<T> rows;
  unrolled<Lanes<T>::width>([&](auto m) { rows[m] = block[m]; });
  if constexpr (Lanes<T>::width > 1) transpose(rows);
  return rows;
}

/// The first row of the last block of a matrix of n rows; negative if n = 0.
template <class T> int last_block(int n) {
  return (n + Lanes<T>::width - 1) / Lanes<T>::width * Lanes<T>::width - Lanes<T>::width;
}

/// Stores one register in row i of a matrix of n rows from column j on, or nothing if i >= n; `to` is the
/// address of entry (i, j). Lanes beyond the end of the row spill into the rows that follow, so these must be
/// stored afterwards.
template <class T>
[[gnu::always_inline]] inline void store_row(const typename Lanes<T>::Number& x, int i, int j, int n, T* to) {
  if (i < n) Lanes<T>::store(x, to, (n - i) * n - j);
}
/// Stores a square block, whose rows are in SIMD registers, in rows i, i + 1, ... of a matrix M (n × n, row
/// by row) from column j on. Rows of the block below the last row of M are not stored. If the block has
/// columns beyond the last one of M, the excess lanes of a register overwrite the first entries of the next
/// row of M, so that these must be stored afterwards. Nothing is written beyond the end of M.
template <class T>
[[gnu::always_inline]] inline void store(const SquareBlock<T>& block, int i, int j, int n, T* M) {
  T* const to = M + static_cast<std::ptrdiff_t>(i) * n + j;
  unrolled<Lanes<T>::width>(
      [&](auto m) { store_row(block[m], i + m, j, n, to + m * static_cast<std::ptrdiff_t>(n)); });
}

/// Copies the entries of a matrix M (n × n, row by row) above the diagonal to the entries below it. M is
/// divided into blocks of W × W entries, where W is the number of lanes of a SIMD register. The blocks on the
/// diagonal are not changed, so that all their entries must be there already.
template <class T> void mirror(int n, T* M) noexcept {
  using L = Lanes<T>;
  for (int i = 0; i + L::width < n; i += L::width)
    for (int j = i + L::width; j < n; j += L::width) {
      SquareBlock<T> block;
      unrolled<L::width>([&](auto m) { block[m] = L::load(M + static_cast<std::ptrdiff_t>(i + m) * n + j); });
      store(transposed<T>(block), j, i, n, M);
    }
}

}  // namespace axode
