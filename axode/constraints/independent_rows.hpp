#pragma once
#include <Eigen/QR>
#include <algorithm>
#include <span>
#include <vector>

#include "axode/constraints/loop_system.hpp"

namespace axode {

/// Which rows of the loops are independent, in the order of the loops, and how the others depend on them: Gram and
/// Schmidt's way on the columns of Y, where units do not matter. For reports and for what needs a rank; accelerations do
/// not. Allocates, O(m² nv + nv³).
template <class T> class IndependentRows {
 public:
  using Vector = Eigen::VectorX<T>;
  using Matrix = Eigen::MatrixX<T>;
  using RowsOf = typename LoopSystem<T>::Rows;

  /// At the place where the system is. A row is implied by others where what they leave of it is less than a part of its
  /// size: 1e-8 (float 1e-4), or how far the loops are from closed.
  IndependentRows(LoopSystem<T>& system, RowsOf rows, T part = std::same_as<T, float> ? T(1e-4) : T(1e-8))
      : nv_(system.model().nv()), m_(system.size(rows)) {
    static_cast<void>(system.factorize());
    system.make_rows(rows);
    system.factorize_rows();
    typename LoopSystem<T>::RowByRow dense(m_, nv_);
    system.write(dense.data());
    A_ = dense, scale_ = system.scale().head(m_);
    const Matrix Y = system.Y().leftCols(m_);
    Matrix Q(nv_, std::min(nv_, m_));
    split_rows<T>(Y, scale_, part, Q,
                  [&](int k, bool independent) { (independent ? kept : implied).push_back(k); });
    find_dependencies(Y);
  }

  int rank() const { return static_cast<int>(kept.size()); }

  /// N with A N = 0: an orthonormal basis of the velocities that the loops allow, nv × (nv - rank).
  Matrix kernel() const {
    if (kept.empty()) return Matrix::Identity(nv_, nv_);
    const Matrix transposed = columns(Matrix(A_.transpose()), kept);
    const Eigen::HouseholderQR<Matrix> qr(transposed);
    const Matrix Q = qr.householderQ() * Matrix::Identity(nv_, nv_);
    return Q.rightCols(nv_ - rank());
  }

  /// λ with Aᵀ λ = f as far as there is one, least in Σ d² λ² with the sizes d of the rows.
  void least_multipliers(const Vector& f, std::span<T> lambda) const {
    if (m_ == 0) return;
    const Vector d = scale_.cwiseInverse();
    Eigen::CompleteOrthogonalDecomposition<Matrix> solver;
    solver.setThreshold(std::same_as<T, float> ? T(1e-5) : T(1e-9));
    solver.compute(A_.transpose() * d.asDiagonal());
    const Vector x = d.cwiseProduct(Vector(solver.solve(f)));
    std::ranges::copy(x, lambda.begin());
  }

  std::vector<int> kept, implied;
  Matrix dependencies;  ///< m × implied: the n with nᵀ A = 0

 private:
  void find_dependencies(const Matrix& Y) {
    dependencies = Matrix::Zero(m_, static_cast<Eigen::Index>(implied.size()));
    for (std::size_t n = 0; n < implied.size(); ++n)
      dependencies(implied[n], static_cast<Eigen::Index>(n)) = T(1);
    if (kept.empty() || implied.empty()) return;
    const Matrix shares = columns(Y, kept).colPivHouseholderQr().solve(columns(Y, implied));
    for (std::size_t k = 0; k < kept.size(); ++k)
      dependencies.row(kept[k]) = -shares.row(static_cast<Eigen::Index>(k));
  }
  static Matrix columns(const Matrix& of, const std::vector<int>& which) {
    Matrix out(of.rows(), static_cast<Eigen::Index>(which.size()));
    for (std::size_t k = 0; k < which.size(); ++k) out.col(static_cast<Eigen::Index>(k)) = of.col(which[k]);
    return out;
  }

  int nv_, m_;
  Matrix A_;
  Vector scale_;
};

}  // namespace axode
