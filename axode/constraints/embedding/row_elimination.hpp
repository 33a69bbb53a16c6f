#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <span>
#include <utility>
#include <vector>

#include "axode/scalar/index.hpp"

namespace axode {

/// Gaussian elimination of the first columns of a small matrix A, with complete pivoting among these columns.
/// The number of columns to be eliminated is an argument of reset(). Eliminated entries are not set to zero.
template <class T> class RowElimination {
 public:
  /// A pivot is certain if it is larger than this fraction of the largest entry of the columns to be
  /// eliminated.
  static constexpr T certain = std::same_as<T, float> ? T(1e-3) : T(1e-6);
  /// An entry is a rounding error if it is smaller than this fraction of the largest entry of the columns to
  /// be eliminated.
  static constexpr T rounding = std::same_as<T, float> ? T(1e-5) : T(1e-11);

  void reserve(std::size_t rows, std::size_t columns) {
    stride_ = (columns + width - 1) / width * width;
    entries_.resize(rows * stride_);
    factor_stride_ = std::min(rows, columns);
    factors_.resize(rows * factor_stride_);
    inverse_.resize(factor_stride_);
    rows_.resize(rows);
    columns_.resize(columns);
  }
  /// Sets the matrix to zero, with `rows` rows, and the number `pivots` of the columns to be eliminated.
  void reset(int rows, int pivots) noexcept {
    m_ = rows;
    p_ = pivots;
    rank_ = 0;
    std::fill_n(entries_.begin(), index(rows) * stride_, T(0));
    for (int i = 0; i < rows; ++i) rows_[index(i)] = i;
    for (int j = 0; j < pivots; ++j) columns_[index(j)] = j;
  }
  T* row(int i) noexcept { return entries_.data() + index(i) * stride_; }
  const T* row(int i) const noexcept { return entries_.data() + index(i) * stride_; }
  int rows() const { return m_; }
  int rank() const { return rank_; }
  /// The inverse of pivot k.
  T inverse_pivot(int k) const { return inverse_[index(k)]; }
  /// The original indices of row i and of the eliminated column j, which pivoting may have moved.
  int row_before(int i) const { return rows_[index(i)]; }
  int column_before(int j) const { return columns_[index(j)]; }

  /// Eliminates the first columns, as many as reset() was called with. Pivots must be larger than a small
  /// constant times the larger of two numbers: the largest entry in these columns, and `size`, a magnitude of
  /// entries that are no rounding errors. Returns whether the rank is certain, that is, whether the remaining
  /// entries of these columns are so small that they are rounding errors.
  bool run(T size = T(0)) noexcept {
    for (int k = 0; k < m_ && k < p_; ++k) {
      int best_row = k, best_column = k;
      T best(0);
      for (int i = k; i < m_; ++i) {
        const T* const a = row(i);
        T largest(0);
        for (int j = k; j < p_; ++j) largest = std::max(largest, std::abs(a[j]));
        if (!(largest > best)) continue;
        best = largest;
        best_row = i;
      }
      while (best_column + 1 < p_ && std::abs(row(best_row)[best_column]) < best) ++best_column;
      if (k == 0) size = std::max(size, best);
      if (!(best > certain * size)) return best <= rounding * size;
      swap(k, best_row, best_column);
      const T* const pivot = row(k);
      const T inverse = inverse_[index(k)] = T(1) / pivot[k];
      for (int i = k + 1; i < m_; ++i) {
        T* const a = row(i);
        const T factor = factors(i)[k] = a[k] * inverse;
        for (std::size_t b = index(k) / width * width; b < stride_; b += width)
          for (std::size_t j = b; j < b + width; ++j) a[j] -= factor * pivot[j];
      }
      rank_ = k + 1;
    }
    return true;
  }

  /// Solves for multipliers μ of the pivot rows such that the sum of the rows, multiplied by μ, equals b in
  /// the eliminated columns. μ has rank() numbers in the order of the rows after pivoting; b is in the
  /// original order of columns.
  void solve_transposed(const T* b, T* mu) const noexcept {
    for (int j = 0; j < rank_; ++j) {
      T rest = b[column_before(j)];
      for (int i = 0; i < j; ++i) rest -= row(i)[j] * mu[i];
      mu[j] = rest * inverse_[index(j)];
    }
  }
  /// Computes the multipliers λ of the original rows that give the same sum of rows as the multipliers μ of
  /// the rows after the elimination; μ is overwritten.
  void multipliers(T* mu, T* lambda) const noexcept {
    for (int k = rank_; k-- > 0;)
      for (int i = k + 1; i < m_; ++i) mu[k] -= factors(i)[k] * mu[i];
    for (int i = 0; i < m_; ++i) lambda[row_before(i)] = mu[i];
  }
  /// Solves the pivot rows of the eliminated matrix, with the right side b, for the unknowns x of the columns
  /// to be eliminated, whose number is an argument of reset(). Other columns have no effect. b is in the
  /// order of the rows after pivoting, and x in the original order of columns. Unknowns without a pivot must
  /// be given in x.
  void solve(const T* b, T* x) const noexcept {
    for (int k = rank_; k-- > 0;) {
      T rest = b[k];
      for (int j = k + 1; j < p_; ++j) rest -= row(k)[j] * x[column_before(j)];
      x[column_before(k)] = rest * inverse_[index(k)];
    }
  }
  /// Applies the row operations of the elimination, row exchanges included, to a right side b: computes E b
  /// with the product E of the operations. b (`before`) is in the original order of the rows, and E b
  /// (`after`) in the order of the rows after pivoting.
  void reduce(const T* before, T* after) const noexcept {
    for (int i = 0; i < m_; ++i) after[i] = before[row_before(i)];
    for (int k = 0; k < rank_; ++k)
      for (int i = k + 1; i < m_; ++i) after[i] -= factors(i)[k] * after[k];
  }

 private:
  void swap(int k, int i, int j) noexcept {
    if (i != k) {
      std::swap_ranges(row(k), row(k) + stride_, row(i));
      std::swap_ranges(factors(k), factors(k) + k, factors(i));
      std::swap(rows_[index(k)], rows_[index(i)]);
    }
    if (j == k) return;
    for (int r = 0; r < m_; ++r) std::swap(row(r)[k], row(r)[j]);
    std::swap(columns_[index(k)], columns_[index(j)]);
  }

  /// Rows are padded with zeros to whole blocks of this many numbers, so that loops have no remainder.
  static constexpr std::size_t width = 4;

  T* factors(int i) noexcept { return factors_.data() + index(i) * factor_stride_; }
  const T* factors(int i) const noexcept { return factors_.data() + index(i) * factor_stride_; }

  std::size_t stride_ = 0, factor_stride_ = 0;
  int m_ = 0, p_ = 0, rank_ = 0;
  std::vector<T> entries_;
  std::vector<T> factors_;  ///< multiples of the pivot rows that were subtracted, one for each row and pivot
  std::vector<T> inverse_;  ///< inverse of each pivot
  std::vector<int> rows_, columns_;
};

}  // namespace axode
