#pragma once
#include <array>

#include "axode/lie/twist.hpp"

/// Vectors of six numbers and 6 x 6 matrices, with the products that the divide-and-conquer algorithm for
/// forward dynamics in tree_contraction.hpp needs. If a result is symmetric, each pair of equal entries is
/// computed once.
namespace axode::command {

template <class T> using Six = std::array<T, 6>;
template <class Rep, class T> Six<T> six(const Twist<Rep, T>& V) {
  return {V.w.x, V.w.y, V.w.z, V.v.x, V.v.y, V.v.z};
}
template <class Rep, class T> Six<T> six(const Wrench<Rep, T>& W) {
  return {W.m.x, W.m.y, W.m.z, W.f.x, W.f.y, W.f.z};
}
template <class T> T dot(const Six<T>& x, const Six<T>& y) {
  T sum = x[0] * y[0];
  for (std::size_t k = 1; k < 6; ++k) sum += x[k] * y[k];
  return sum;
}
template <class T> Six<T> operator+(const Six<T>& x, const Six<T>& y) {
  Six<T> out;
  for (std::size_t k = 0; k < 6; ++k) out[k] = x[k] + y[k];
  return out;
}
template <class T> Six<T> operator-(const Six<T>& x, const Six<T>& y) {
  Six<T> out;
  for (std::size_t k = 0; k < 6; ++k) out[k] = x[k] - y[k];
  return out;
}
template <class T> Six<T> operator*(const T& s, const Six<T>& x) {
  Six<T> out;
  for (std::size_t k = 0; k < 6; ++k) out[k] = s * x[k];
  return out;
}

/// A matrix by its rows.
template <class T> using Matrix6 = std::array<Six<T>, 6>;

template <class T> Matrix6<T> identity6() {
  Matrix6<T> out{};
  for (std::size_t k = 0; k < 6; ++k) out[k][k] = T(1);
  return out;
}
template <class T> Matrix6<T> transposed(const Matrix6<T>& A) {
  Matrix6<T> out;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = 0; k < 6; ++k) out[i][k] = A[k][i];
  return out;
}
template <class T> Six<T> times(const Matrix6<T>& A, const Six<T>& x) {
  Six<T> out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = dot(A[i], x);
  return out;
}
/// A Bᵀ.
template <class T> Matrix6<T> times_transposed(const Matrix6<T>& A, const Matrix6<T>& B) {
  Matrix6<T> out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = times(B, A[i]);
  return out;
}
template <class T> Matrix6<T> times(const Matrix6<T>& A, const Matrix6<T>& B) {
  return times_transposed(A, transposed(B));
}
/// A Bᵀ, of which the caller knows that it is symmetric.
template <class T> Matrix6<T> symmetric_times_transposed(const Matrix6<T>& A, const Matrix6<T>& B) {
  Matrix6<T> out;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = 0; k <= i; ++k) out[i][k] = out[k][i] = dot(A[i], B[k]);
  return out;
}
/// A + s B for symmetric A and B.
template <int s, class T> Matrix6<T> symmetric_sum(const Matrix6<T>& A, const Matrix6<T>& B) {
  Matrix6<T> out;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = 0; k <= i; ++k)
      out[i][k] = out[k][i] = s > 0 ? A[i][k] + B[i][k] : A[i][k] - B[i][k];
  return out;
}
template <class T> Matrix6<T> difference(const Matrix6<T>& A, const Matrix6<T>& B) {
  Matrix6<T> out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = A[i] - B[i];
  return out;
}
template <class T> Six<T> diagonal(const Matrix6<T>& A) {
  Six<T> out;
  for (std::size_t k = 0; k < 6; ++k) out[k] = A[k][k];
  return out;
}
/// Adds x yᵀ to A.
template <class T> void add_outer(Matrix6<T>& A, const Six<T>& x, const Six<T>& y) {
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = 0; k < 6; ++k) A[i][k] += x[i] * y[k];
}
/// Adds s x xᵀ to a symmetric A.
template <class T> void add_square(Matrix6<T>& A, const T& s, const Six<T>& x) {
  const Six<T> y = s * x;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = 0; k <= i; ++k) A[k][i] = A[i][k] += x[i] * y[k];
}

/// A lower triangular matrix L.
template <class T> struct Lower6 {
  Matrix6<T> L{};
  Six<T> inverse_diagonal{};  ///< 0 for a column that is 0

  /// Computes the factor L of a positive semidefinite matrix A = L Lᵀ. `size` has the magnitudes of the
  /// numbers from which the diagonal entries of A were computed. A column of L is 0 if its pivot may be a
  /// rounding error of these numbers.
  Lower6(const Matrix6<T>& A, const Six<T>& size) {
    for (std::size_t j = 0; j < 6; ++j) {
      T pivot = A[j][j];
      for (std::size_t k = 0; k < j; ++k) pivot -= L[j][k] * L[j][k];
      const bool regular = pivot > T(64 * unit_roundoff<T>) * size[j];  // without branches, for the counts
      L[j][j] = sqrt(select(regular, pivot, T(0)));
      inverse_diagonal[j] = select(regular, T(1) / select(regular, L[j][j], T(1)), T(0));
      for (std::size_t i = j + 1; i < 6; ++i) {
        T sum = A[i][j];
        for (std::size_t k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
        L[i][j] = sum * inverse_diagonal[j];
      }
    }
  }
  /// Lᵀ x.
  Six<T> transposed_times(const Six<T>& x) const {
    Six<T> out;
    for (std::size_t i = 0; i < 6; ++i) {
      out[i] = L[i][i] * x[i];
      for (std::size_t k = i + 1; k < 6; ++k) out[i] += L[k][i] * x[k];
    }
    return out;
  }
  /// L⁻¹ x.
  Six<T> solve(Six<T> x) const {
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t k = 0; k < i; ++k) x[i] -= L[i][k] * x[k];
      x[i] = x[i] * inverse_diagonal[i];
    }
    return x;
  }
};

}  // namespace axode::command
