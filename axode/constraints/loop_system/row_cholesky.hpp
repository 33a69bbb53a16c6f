#pragma once
#include <Eigen/Core>
#include <algorithm>

namespace axode {

/// Cholesky factorisation A = Rᵀ D R of a symmetric positive definite matrix with some dozens of rows, where
/// R is upper triangular with a unit diagonal. For speed, rows are stored in blocks of eight numbers and
/// padded with zeros. A right side is stored as an additional column.
template <class T> class RowCholesky {
 public:
  using Matrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  static constexpr Eigen::Index width = 8;
  static Eigen::Index room(Eigen::Index m) { return block(m + width); }
  /// The first column of the block of eight columns that contains column k.
  static Eigen::Index block(Eigen::Index k) { return k / width * width; }
  static auto part(Matrix& A, Eigen::Index row, Eigen::Index begin) {
    return A.row(row).template segment<width>(begin);
  }
  static auto part(const Matrix& A, Eigen::Index row, Eigen::Index begin) {
    return A.row(row).template segment<width>(begin);
  }

  void resize(Eigen::Index m) {
    R_.setZero(m, room(m));
    inverse_.resize(m);
  }
  /// The memory of the factorisation A = Rᵀ D R of a symmetric m × m matrix A, where R is upper triangular
  /// with a unit diagonal and D is diagonal. Before factorize(), the caller writes to this memory A on and
  /// above the diagonal, and a right side b in column m. Afterwards the memory contains R above the
  /// diagonal, and D⁻¹ R⁻ᵀ b in column m; D is stored elsewhere.
  Matrix& matrix() { return R_; }

  /// Factorises the symmetric m × m matrix A, which the caller has written to matrix(), as A = Rᵀ D R,
  /// where R is upper triangular with a unit diagonal and D is diagonal. Replaces the right side b in
  /// column m by D⁻¹ R⁻ᵀ b. Calls sound(k, D_k) for each pivot D_k. If it returns false, the function
  /// returns false at once, and there is no factorisation.
  template <class Sound> bool factorize(Eigen::Index m, const Sound& sound) noexcept {
    for (Eigen::Index k = 0; k < m; ++k) {
      if (!sound(k, R_(k, k))) return false;
      const T d = inverse_[k] = T(1) / R_(k, k);
      for (Eigen::Index i = k + 1; i < m; ++i) {
        const T r = d * R_(k, i);
        for (Eigen::Index b = block(i); b <= m; b += width) part(R_, i, b) -= r * part(R_, k, b);
      }
      for (Eigen::Index b = block(k); b <= m; b += width) part(R_, k, b) *= d;
      for (Eigen::Index j = block(k); j <= k; ++j) R_(k, j) = T(0);
    }
    return true;
  }
  void factorize(Eigen::Index m) noexcept {
    factorize(m, [](Eigen::Index, const T&) { return true; });
  }
  /// Computes the solution x of A x = b with the factorised matrix A = Rᵀ D R, for the right side b that was
  /// in column m of the memory before factorize(). Sets this column to 0. x must have memory for m numbers,
  /// rounded up to whole blocks of eight.
  void solve_right_side(Eigen::Index m, Eigen::VectorX<T>& x) noexcept {
    for (Eigen::Index k = 0; k < m; ++k) {
      x[k] = R_(k, m);
      R_(k, m) = T(0);
    }
    solve_up(m, x);
  }
  /// Replaces x by (Rᵀ D R)⁻¹ x. solve_right_side() must have been called since factorize().
  void solve(Eigen::Index m, Eigen::VectorX<T>& x) const noexcept {
    for (Eigen::Index k = 0; k < m; ++k) {
      const T x_k = x[k];
      for (Eigen::Index b = block(k); b < m; b += width)
        x.template segment<width>(b) -= x_k * part(R_, k, b).transpose();
    }
    x.head(m).array() *= inverse_.head(m).array();
    solve_up(m, x);
  }

 private:
  /// Replaces x by R⁻¹ x with the triangular factor R.
  void solve_up(Eigen::Index m, Eigen::VectorX<T>& x) const noexcept {
    for (Eigen::Index k = m; k-- > 0;) {
      const Eigen::Index next = block(k) + width;
      T rest = x[k];
      for (Eigen::Index b = next; b < m; b += width)
        rest -= part(R_, k, b).transpose().dot(x.template segment<width>(b));
      for (Eigen::Index j = std::min(next, m) - 1; j > k; --j) rest -= R_(k, j) * x[j];
      x[k] = rest;
    }
  }

  Matrix R_;
  Eigen::VectorX<T> inverse_;  ///< the diagonal of D⁻¹
};

}  // namespace axode
