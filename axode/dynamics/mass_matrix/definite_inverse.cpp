#include "axode/dynamics/mass_matrix/definite_inverse.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "axode/recursion/instantiate.hpp"

namespace axode {

template <class T> int invert_definite(std::span<T, 36> matrix) {
  using Matrix = Eigen::Matrix<T, 6, 6>;
  Eigen::Map<Matrix> A(matrix.data());
  constexpr T smallest = std::numeric_limits<T>::digits > 24 ? T(1e-12) : T(1e-5);
  const Eigen::Matrix<T, 6, 1> scale =
      A.diagonal().unaryExpr([](T x) { return x > T(0) ? T(1) / std::sqrt(x) : T(0); });
  const Eigen::SelfAdjointEigenSolver<Matrix> scaled(scale.asDiagonal() * A * scale.asDiagonal());
  const int rank = static_cast<int>((scaled.eigenvalues().array() > smallest).count());
  if (rank == 6) {
    const Matrix root = scale.asDiagonal() * scaled.eigenvectors();
    A = root * scaled.eigenvalues().cwiseInverse().asDiagonal() * root.transpose();
  } else {
    A.setConstant(std::numeric_limits<T>::quiet_NaN());
  }
  return rank;
}

template AXODE_ENTRY int invert_definite(std::span<AXODE_T, 36>);

}  // namespace axode
