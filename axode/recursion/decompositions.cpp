#include "axode/recursion/decompositions.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <stdexcept>
#include <type_traits>

namespace axode {

template <class Decomposition>
void Factor<Decomposition>::compute(const Eigen::Ref<const Eigen::MatrixXd>& A) {
  factor_.compute(A);
}

template <class Decomposition>
void Factor<Decomposition>::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) const {
  x = factor_.solve(b);
}

template <class Decomposition>
Eigen::MatrixXd Factor<Decomposition>::solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const {
  if (B.cols() == 1) {  // equations for a vector take less time than those for a matrix
    const Eigen::VectorXd x = factor_.solve(B.col(0));
    return x;
  }
  return factor_.solve(B);
}

template <class Decomposition> Changes Factor<Decomposition>::solve_changes(Changes x) const {
  if constexpr (std::is_same_v<Decomposition, Eigen::LLT<Eigen::MatrixXd>>) {
    solve_lower(factor_.matrixLLT(), false, x);
    solve_upper(factor_.matrixLLT().transpose(), x);
  } else if constexpr (std::is_same_v<Decomposition, Eigen::PartialPivLU<Eigen::MatrixXd>>) {
    x = (factor_.permutationP() * x).eval();
    solve_lower(factor_.matrixLU(), true, x);
    solve_upper(factor_.matrixLU(), x);
  } else {
    x = factor_.solve(x).eval();
  }
  return x;
}

template <class Decomposition> double Factor<Decomposition>::rcond() const { return factor_.rcond(); }

template class Factor<Eigen::PartialPivLU<Eigen::MatrixXd>>;
template class Factor<Eigen::LLT<Eigen::MatrixXd>>;
template class Factor<Eigen::LDLT<Eigen::MatrixXd>>;

SingularValues singular_values(const Eigen::Ref<const Eigen::MatrixXd>& A) {
  if (A.rows() == 0 || A.cols() == 0)
    return {Eigen::MatrixXd::Identity(A.rows(), A.rows()), Eigen::MatrixXd::Identity(A.cols(), A.cols()), {}};
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.matrixV(), svd.singularValues()};
}

SymmetricEigen symmetric_eigen(const Eigen::Ref<const Eigen::MatrixXd>& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

GeneralEigen general_eigen(const Eigen::Ref<const Eigen::MatrixXd>& A) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(A);
  if (solver.info() != Eigen::Success) throw std::runtime_error("the eigenvalues of A did not converge");
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::MatrixXd orthogonal_complement(const Eigen::Ref<const Eigen::MatrixXd>& T) {
  return singular_values(T).V.rightCols(T.cols() - T.rows()).transpose();
}

Eigen::MatrixXd kernel_of(const Eigen::Ref<const Eigen::MatrixXd>& A) {
  if (A.rows() == 0) return Eigen::MatrixXd::Identity(A.cols(), A.cols());
  const Eigen::MatrixXd columns = A.transpose();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
  return qr.householderQ() * Eigen::MatrixXd::Identity(A.cols(), A.cols()).rightCols(A.cols() - A.rows());
}

Eigen::MatrixXd range_of(const Eigen::Ref<const Eigen::MatrixXd>& A, double bound) {
  if (A.size() == 0) return Eigen::MatrixXd(A.rows(), 0);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  const auto pivots = qr.matrixQR().diagonal().array().abs();
  return qr.householderQ() * Eigen::MatrixXd::Identity(A.rows(), (pivots > bound).count());
}

std::vector<std::complex<double>> polynomial_roots(const Eigen::Ref<const Eigen::VectorXd>& c) {
  const Eigen::Index m = c.size() - 1;
  if (m < 1) return {};
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(m, m);
  companion.row(0) = -c.tail(m).transpose() / c[0];
  companion.bottomLeftCorner(m - 1, m - 1).setIdentity();
  const Eigen::VectorXcd roots = companion.eigenvalues();
  return {roots.begin(), roots.end()};
}

}  // namespace axode
