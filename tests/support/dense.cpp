#include "tests/support/dense.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace axode::test {

using Eigen::MatrixXd, Eigen::VectorXd;

VectorXd vector(const std::vector<double>& x) {
  return Eigen::Map<const VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
}
std::vector<double> numbers(const VectorXd& x) { return {x.begin(), x.end()}; }
MatrixXd matrix(int n_rows, const std::vector<double>& rows) {
  const Eigen::Index n_columns = n_rows == 0 ? 0 : static_cast<Eigen::Index>(rows.size()) / n_rows;
  return Eigen::Map<const Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(rows.data(), n_rows, n_columns);
}
MatrixXd product(const MatrixXd& A, const MatrixXd& B) { return A.lazyProduct(B); }
VectorXd product(const MatrixXd& A, const VectorXd& x) { return A.lazyProduct(x); }
double smallest_eigenvalue(const MatrixXd& A) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues()[0];
}
bool is_positive_definite(const MatrixXd& A) { return A.llt().info() == Eigen::Success; }
double definiteness(const MatrixXd& A) {
  if (A.rows() == 0) return 1;
  if (A.diagonal().minCoeff() <= 0) return 0;
  const VectorXd scale = A.diagonal().cwiseSqrt().cwiseInverse();
  return smallest_eigenvalue(scale.asDiagonal() * A * scale.asDiagonal());
}
double largest_entry(const MatrixXd& A) { return A.size() == 0 ? 0 : A.cwiseAbs().maxCoeff(); }

}  // namespace axode::test
