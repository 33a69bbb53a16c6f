#include "axode/dynamics/mass_matrix/definite_inverse.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace axode {

template <class T> int invert_definite(std::span<T, 36> matrix) {
  using Matrix = Eigen::Matrix<double, 6, 6>;
  Eigen::Map<Eigen::Matrix<T, 6, 6>> out(matrix.data());
  const Matrix A = out.template cast<double>();
  constexpr double smallest = std::numeric_limits<T>::digits > 24 ? 1e-12 : 1e-5;
  const Eigen::Matrix<double, 6, 1> scale =
      A.diagonal().unaryExpr([](double x) { return x > 0 ? 1 / std::sqrt(x) : 0; });
  const Eigen::SelfAdjointEigenSolver<Matrix> scaled(scale.asDiagonal() * A * scale.asDiagonal());
  const int rank = static_cast<int>((scaled.eigenvalues().array() > smallest).count());
  if (rank == 6) {
    const Matrix root = scale.asDiagonal() * scaled.eigenvectors();
    const Matrix inverse = root * scaled.eigenvalues().cwiseInverse().asDiagonal() * root.transpose();
    out = inverse.template cast<T>();
  } else {
    out.setConstant(std::numeric_limits<T>::quiet_NaN());
  }
  return rank;
}

template int invert_definite(std::span<double, 36>);
template int invert_definite(std::span<float, 36>);

}  // namespace axode
