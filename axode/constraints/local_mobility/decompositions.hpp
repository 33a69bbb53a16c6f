#pragma once
#include <Eigen/Core>
#include <complex>
#include <vector>

/// The decompositions of dense matrices that an analysis of mobility needs. They are functions in a source
/// file of their own, because a compiler takes seconds for each decomposition of Eigen that a file includes.
namespace axode::higher_order {

/// Singular value decomposition A = U diag(s) Vᵀ with square U and V, and min(rows, cols) singular values in
/// descending order.
struct SingularValues {
  Eigen::MatrixXd U, V;
  Eigen::VectorXd s;

  /// The number of singular values above `bound`.
  int rank(double bound) const { return static_cast<int>((s.array() > bound).count()); }
};
SingularValues singular_values(const Eigen::Ref<const Eigen::MatrixXd>& A);

/// Returns a matrix whose rows are an orthonormal basis of the orthogonal complement of the rows of T, which
/// must be orthonormal.
Eigen::MatrixXd orthogonal_complement(const Eigen::Ref<const Eigen::MatrixXd>& T);

/// Computes A⁻¹ b for a positive definite matrix A.
Eigen::VectorXd solve_definite(const Eigen::Ref<const Eigen::MatrixXd>& A,
                               const Eigen::Ref<const Eigen::VectorXd>& b);

/// Computes all complex roots of c_0 x^m + c_1 x^(m-1) + ... + c_m with c_0 ≠ 0, as eigenvalues of the
/// companion matrix.
std::vector<std::complex<double>> polynomial_roots(const Eigen::Ref<const Eigen::VectorXd>& c);

}  // namespace axode::higher_order
