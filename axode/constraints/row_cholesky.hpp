#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace axode {

/// The factor Uᵀ U of a symmetric positive matrix with some dozens of rows, row by row in blocks of eight numbers: quicker
/// than Eigen's own, which is made for large ones. Rows have room up to a whole block, 0 where nothing stands.
template <class T> class RowCholesky {
 public:
  using Matrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  static constexpr Eigen::Index width = 8;
  static Eigen::Index room(Eigen::Index m) { return block(m + width - 1); }
  /// Where the block of column k begins.
  static Eigen::Index block(Eigen::Index k) { return k / width * width; }
  static auto part(Matrix& A, Eigen::Index row, Eigen::Index begin) {
    return A.row(row).template segment<width>(begin);
  }
  static auto part(const Matrix& A, Eigen::Index row, Eigen::Index begin) {
    return A.row(row).template segment<width>(begin);
  }

  void resize(Eigen::Index m) { U_.setZero(m, room(m)), inverse_.resize(m); }
  /// The matrix, then what is above the diagonal of U.
  Matrix& matrix() { return U_; }

  /// Of the first m rows.
  void factorize(Eigen::Index m) noexcept {
    for (Eigen::Index k = 0; k < m; ++k) {
      using std::sqrt;
      const T d = inverse_[k] = T(1) / sqrt(U_(k, k));
      for (Eigen::Index b = block(k); b < m; b += width) part(U_, k, b) *= d;
      for (Eigen::Index i = k + 1; i < m; ++i) {
        const T u = U_(k, i);
        for (Eigen::Index b = block(i); b < m; b += width) part(U_, i, b) -= u * part(U_, k, b);
      }
      for (Eigen::Index j = block(k); j <= k; ++j) U_(k, j) = T(0);
    }
  }
  /// x := (Uᵀ U)⁻¹ x, which has room as rows have.
  void solve(Eigen::Index m, Eigen::VectorX<T>& x) const noexcept {
    for (Eigen::Index k = 0; k < m; ++k) {
      const T x_k = x[k] *= inverse_[k];
      for (Eigen::Index b = block(k); b < m; b += width)
        x.template segment<width>(b) -= x_k * part(U_, k, b).transpose();
    }
    for (Eigen::Index k = m; k-- > 0;) {
      const Eigen::Index next = block(k) + width;
      T rest = x[k];  // its own block number by number: a vector just written so would be waited for
      for (Eigen::Index j = k + 1; j < std::min(next, m); ++j) rest -= U_(k, j) * x[j];
      for (Eigen::Index b = next; b < m; b += width)
        rest -= part(U_, k, b).transpose().dot(x.template segment<width>(b));
      x[k] = inverse_[k] * rest;
    }
  }

 private:
  Matrix U_;
  Eigen::VectorX<T> inverse_;  ///< of the diagonal of U
};

}  // namespace axode
