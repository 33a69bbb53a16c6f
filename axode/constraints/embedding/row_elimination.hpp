#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <span>
#include <utility>
#include <vector>

namespace axode {

/// Elimination of the first columns of a small matrix A by row operations, with complete pivoting among these
/// columns: the result is E A, where E is the product of the row operations. Eliminated entries are not set
/// to zero. The memory is allocated once.
template <class T> class RowElimination {
 public:
  /// A pivot is certain if it is larger than this part of the largest entry of the first columns.
  static constexpr T certain = std::same_as<T, float> ? T(1e-3) : T(1e-6);
  /// An entry is a rounding error if it is smaller than this part of the largest entry of the first columns.
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
  /// Sets the matrix to zero, with `rows` rows, of which the first `pivots` columns are to be eliminated.
  /// Rows and columns are numbered in order.
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
  /// row_before(i) is the index that row i had before the elimination moved it, and column_before(j) is that
  /// of column j, one of the columns that are eliminated.
  int row_before(int i) const { return rows_[index(i)]; }
  int column_before(int j) const { return columns_[index(j)]; }

  /// Eliminates the first columns of the matrix, one after the other, as long as the pivot is larger than
  /// `certain` times the largest entry in these columns, or times `size` if that is larger. Returns whether
  /// the rank is certain: whether all that is left of these columns is rounding errors.
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

  /// Solves the transposed system of the pivot rows for their multipliers μ: the rows, multiplied by μ, have
  /// the sum b in the eliminated columns. b is in the order of the columns before the elimination, and μ in
  /// the order of the rows after it. Only the first rank() numbers of μ are written.
  void solve_transposed(const T* b, T* mu) const noexcept {
    for (int j = 0; j < rank_; ++j) {
      T rest = b[column_before(j)];
      for (int i = 0; i < j; ++i) rest -= row(i)[j] * mu[i];
      mu[j] = rest * inverse_[index(j)];
    }
  }
  /// Computes the multipliers λ of the original rows from the multipliers μ of the rows after the
  /// elimination, so that both give the same sum of multiplied rows. μ is overwritten.
  void multipliers(T* mu, T* lambda) const noexcept {
    for (int k = rank_; k-- > 0;)
      for (int i = k + 1; i < m_; ++i) mu[k] -= factors(i)[k] * mu[i];
    for (int i = 0; i < m_; ++i) lambda[row_before(i)] = mu[i];
  }
  /// Solves the pivot rows of the eliminated matrix for the unknowns x of the first columns, with the right
  /// side b. b is in the order of the rows after the elimination, and x in the order of the columns before
  /// it. The unknowns without a pivot are given: x already has their numbers.
  void solve(const T* b, T* x) const noexcept {
    for (int k = rank_; k-- > 0;) {
      T rest = b[k];
      for (int j = k + 1; j < p_; ++j) rest -= row(k)[j] * x[column_before(j)];
      x[column_before(k)] = rest * inverse_[index(k)];
    }
  }
  /// Computes E b (`after`) for a right side b (`before`) of the rows before the elimination.
  void reduce(const T* before, T* after) const noexcept {
    for (int i = 0; i < m_; ++i) after[i] = before[row_before(i)];
    for (int k = 0; k < rank_; ++k)
      for (int i = k + 1; i < m_; ++i) after[i] -= factors(i)[k] * after[k];
  }

 private:
  static std::size_t index(int k) { return static_cast<std::size_t>(k); }
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

  /// Rows are padded with zeros to whole blocks of this many numbers, so that loops over them need no
  /// remainder.
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
