#pragma once
#include <Eigen/Core>
#include <vector>

namespace axode {

/// Factorises a dense matrix in place by Gauss' elimination with row pivots, in blocks of columns. Nothing is
/// allocated for matrices up to the size for which memory was reserved, except in products of large blocks.
class DenseFactor {
 public:
  using Matrix = Eigen::MatrixXd;

  void reserve(Eigen::Index n);
  /// The n × n matrix A, which the caller fills before factorize() or factorize_symmetric().
  Eigen::Map<Matrix> matrix(Eigen::Index n) noexcept { return {memory_.data(), n, n}; }
  void factorize(Eigen::Index n) noexcept;
  /// Factorises a symmetric positive definite matrix by Cholesky's method, in half the time of factorize().
  /// Only the entries on and below the diagonal are read. If the matrix is not positive definite, solve()
  /// gives NaN.
  void factorize_symmetric(Eigen::Index n) noexcept;
  /// Computes x := A⁻¹ x (n numbers) with the factors of A, after factorize() or factorize_symmetric().
  void solve(Eigen::Index n, double* x) const noexcept;

 private:
  void factorize_panel(Eigen::Map<Matrix>& A, Eigen::Index first, Eigen::Index count) noexcept;

  std::vector<double> memory_;
  std::vector<Eigen::Index> pivot_;
  bool symmetric_ = false;
};

}  // namespace axode
