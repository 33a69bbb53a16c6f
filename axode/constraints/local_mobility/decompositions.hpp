#pragma once
#include <Eigen/Core>
#include <complex>
#include <vector>

/// Decompositions of dense matrices, compiled in one source file because each takes a compiler seconds.
namespace axode::higher_order {

/// Singular value decomposition A = U diag(s) Vᵀ with square U and V, and s in descending order.
struct SingularValues {
  Eigen::MatrixXd U, V;
  Eigen::VectorXd s;

  /// The number of singular values above `bound`.
  int rank(double bound) const { return static_cast<int>((s.array() > bound).count()); }
};
SingularValues singular_values(const Eigen::Ref<const Eigen::MatrixXd>& A);

/// Returns an orthonormal basis, as rows, of the orthogonal complement of the orthonormal rows of T.
Eigen::MatrixXd orthogonal_complement(const Eigen::Ref<const Eigen::MatrixXd>& T);

/// Computes A⁻¹ b for a positive definite matrix A.
Eigen::VectorXd solve_definite(const Eigen::Ref<const Eigen::MatrixXd>& A,
                               const Eigen::Ref<const Eigen::VectorXd>& b);

/// Computes all complex roots of c_0 x^m + ... + c_m (c_0 ≠ 0) as eigenvalues of the companion matrix.
std::vector<std::complex<double>> polynomial_roots(const Eigen::Ref<const Eigen::VectorXd>& c);

}  // namespace axode::higher_order
