#include "axode/recursion/least_squares.hpp"

#include <Eigen/QR>

namespace axode {

Eigen::MatrixXd least_squares(const Eigen::Ref<const Eigen::MatrixXd>& A,
                              const Eigen::Ref<const Eigen::MatrixXd>& B, double part) {
  if (A.size() == 0) return Eigen::MatrixXd::Zero(A.cols(), B.cols());
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(part);
  return decomposition.compute(A).solve(B);
}

}  // namespace axode
