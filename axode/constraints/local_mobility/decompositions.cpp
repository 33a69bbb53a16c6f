#include "axode/constraints/local_mobility/decompositions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace axode::higher_order {

SingularValues singular_values(const Eigen::Ref<const Eigen::MatrixXd>& A) {
  if (A.rows() == 0 || A.cols() == 0)
    return {Eigen::MatrixXd::Identity(A.rows(), A.rows()), Eigen::MatrixXd::Identity(A.cols(), A.cols()), {}};
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.matrixV(), svd.singularValues()};
}

Eigen::MatrixXd orthogonal_complement(const Eigen::Ref<const Eigen::MatrixXd>& T) {
  return singular_values(T).V.rightCols(T.cols() - T.rows()).transpose();
}

Eigen::VectorXd solve_definite(const Eigen::Ref<const Eigen::MatrixXd>& A,
                               const Eigen::Ref<const Eigen::VectorXd>& b) {
  return A.llt().solve(b);
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

}  // namespace axode::higher_order
