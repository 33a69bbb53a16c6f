#include "axode/lie/inertia.hpp"

#include <Eigen/Eigenvalues>
#include <limits>

namespace axode {

EigenvalueRange eigenvalue_range(const Sym3<double>& A) {
  Eigen::Matrix3d matrix;
  matrix << A.xx, A.xy, A.xz, A.xy, A.yy, A.yz, A.xz, A.yz, A.zz;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix, Eigen::EigenvaluesOnly);
  return {solver.eigenvalues()[0], solver.eigenvalues()[2]};
}

double realisability(const Inertia<double>& M) {
  const Sym3<double> Theta_c = inertia_about_com(M);
  const double largest = eigenvalue_range(Theta_c).largest;
  const double smallest = eigenvalue_range(binet_tensor(Theta_c)).smallest;
  // Theta_c is a difference of tensors, and its rounding errors scale with Theta.
  const double rounding = 16 * std::numeric_limits<double>::epsilon() * trace(M.Theta);
  if (smallest < 0 && smallest > -rounding) return 0.0;
  if (largest > 0) return smallest / largest;
  return smallest < 0 ? -0.5 : 0.0;  // a point mass is realisable, a negative tensor is not
}

}  // namespace axode
