#pragma once
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <complex>
#include <vector>

#include "axode/recursion/changes.hpp"

/// Decompositions of dense matrices, compiled in one source file because each takes a compiler seconds.
namespace axode {

/// A factorisation of a square matrix A that is kept in order to solve equations with it. The constructor,
/// compute() and solve() for one vector allocate only if the size of the matrix grows.
template <class Decomposition> class Factor {
 public:
  Factor() = default;
  explicit Factor(const Eigen::Ref<const Eigen::MatrixXd>& A) { compute(A); }
  void compute(const Eigen::Ref<const Eigen::MatrixXd>& A);

  /// Computes x = A⁻¹ b for two different vectors.
  void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) const;
  /// Returns A⁻¹ B.
  Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const;
  /// Returns A⁻¹ x for changes x.
  Changes solve_changes(Changes x) const;
  /// An estimate of 1/(‖A‖ ‖A⁻¹‖) in the 1-norm.
  double rcond() const;

 private:
  Decomposition factor_;
};
/// Gauss' elimination with exchanges of rows, for any regular matrix.
using LuFactor = Factor<Eigen::PartialPivLU<Eigen::MatrixXd>>;
/// Cholesky's factorisation of a symmetric positive definite matrix.
using CholeskyFactor = Factor<Eigen::LLT<Eigen::MatrixXd>>;
/// Cholesky's factorisation without square roots, with exchanges, of a symmetric semi-definite matrix.
using LdltFactor = Factor<Eigen::LDLT<Eigen::MatrixXd>>;
extern template class Factor<Eigen::PartialPivLU<Eigen::MatrixXd>>;
extern template class Factor<Eigen::LLT<Eigen::MatrixXd>>;
extern template class Factor<Eigen::LDLT<Eigen::MatrixXd>>;

/// Singular value decomposition A = U diag(s) Vᵀ with square U and V, and s in descending order.
struct SingularValues {
  Eigen::MatrixXd U, V;
  Eigen::VectorXd s;

  /// The number of singular values above `bound`.
  int rank(double bound) const { return static_cast<int>((s.array() > bound).count()); }
};
SingularValues singular_values(const Eigen::Ref<const Eigen::MatrixXd>& A);

/// Eigenvalues of a symmetric matrix in ascending order, and orthonormal eigenvectors as columns.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
SymmetricEigen symmetric_eigen(const Eigen::Ref<const Eigen::MatrixXd>& A);

/// Eigenvalues of a square matrix, and eigenvectors of norm 1 as columns.
struct GeneralEigen {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
};
/// Throws std::runtime_error if the eigenvalues do not converge.
GeneralEigen general_eigen(const Eigen::Ref<const Eigen::MatrixXd>& A);

/// Returns an orthonormal basis, as rows, of the orthogonal complement of the orthonormal rows of T.
Eigen::MatrixXd orthogonal_complement(const Eigen::Ref<const Eigen::MatrixXd>& T);

/// Returns an orthonormal basis, as columns, of all x with A x = 0, if the rows of A are independent. The
/// method is the QR decomposition of Aᵀ by reflections.
Eigen::MatrixXd kernel_of(const Eigen::Ref<const Eigen::MatrixXd>& A);

/// Returns an orthonormal basis, as columns, of all A x. The method is the QR decomposition of A by
/// reflections with exchanges of columns. Pivots of at most `bound` are taken for 0.
Eigen::MatrixXd range_of(const Eigen::Ref<const Eigen::MatrixXd>& A, double bound);

/// Computes all complex roots of c_0 x^m + ... + c_m (c_0 ≠ 0) as eigenvalues of the companion matrix.
std::vector<std::complex<double>> polynomial_roots(const Eigen::Ref<const Eigen::VectorXd>& c);

}  // namespace axode
