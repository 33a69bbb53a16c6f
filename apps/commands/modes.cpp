#include "apps/commands/modes.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "axode/recursion/decompositions.hpp"

namespace axode::command {
namespace {

using Matrix = Eigen::MatrixXd;

/// Numbers of the balanced matrix below these fractions of its largest number count as 0.
constexpr double zero_pivot = 1e-12, zero_part = 1e-10;

/// An estimate, at least 1/s, of the largest angular frequency of x' = A x, where x has displacements and
/// then velocities. With its inverse as the unit of time, all entries of A have similar sizes.
double largest_rate(const Matrix& A) {
  const Eigen::Index nv = A.rows() / 2;
  return std::sqrt(std::max(1.0, A.bottomLeftCorner(nv, nv).lpNorm<Eigen::Infinity>()));
}

/// A basis of the null space of A, where numbers that are rounding errors relative to `scale` count as 0.
Matrix null_space(const Matrix& A, double scale) {
  Eigen::FullPivLU<Matrix> lu(A);
  if (lu.maxPivot() <= zero_pivot * scale) return Matrix::Identity(A.cols(), A.cols());
  lu.setThreshold(zero_pivot * scale / lu.maxPivot());
  return lu.isInvertible() ? Matrix(A.cols(), 0) : Matrix(lu.kernel());
}

/// The eigenvalues of A other than 0, and their eigenvectors. An orthogonal Q whose first columns span the
/// null space of A splits off the defective eigenvalue 0 of bodies that can drift: QᵀAQ is block triangular,
/// with the block 0 for the null space and a block A2. The same is done with A2 and so on, until the null
/// space is empty (Kublanovskaya 1966).
GeneralEigen nonzero_spectrum(const Matrix& A, double scale) {
  if (A.rows() == 0) return {};
  const Matrix kernel = null_space(A, scale);
  if (kernel.cols() == 0) return general_eigen(A);
  const Matrix Q = Eigen::HouseholderQR<Matrix>(kernel).householderQ();
  const Matrix Q1 = Q.leftCols(kernel.cols()), Q2 = Q.rightCols(A.cols() - kernel.cols());
  GeneralEigen found = nonzero_spectrum(Q2.transpose() * A * Q2, scale);
  const Eigen::MatrixXcd y = found.vectors;
  if (y.cols() > 0)
    found.vectors = Q1 * (Q1.transpose() * A * Q2) * y * found.values.cwiseInverse().asDiagonal() + Q2 * y;
  return found;
}

Eigen::Index largest_entry(const Eigen::VectorXcd& x) {
  Eigen::Index at = 0;
  x.cwiseAbs().maxCoeff(&at);
  return at;
}

/// The displacements in an eigenvector, which are its first half, scaled so that the largest is 1.
Eigen::VectorXcd shape(const Eigen::VectorXcd& x) {
  const Eigen::VectorXcd displacements = x.head(x.size() / 2);
  return displacements / displacements[largest_entry(displacements)];
}

}  // namespace

Modes modes(const Matrix& A) {
  const Eigen::Index nv = A.rows() / 2;
  if (nv == 0) return {};
  const double rate = largest_rate(A);
  Matrix balanced = A;
  balanced.topRightCorner(nv, nv) *= rate;
  balanced.bottomLeftCorner(nv, nv) /= rate;

  const double scale = balanced.lpNorm<Eigen::Infinity>(), zero = zero_part * scale;

  Modes found;
  const Matrix kernel = null_space(balanced, scale);
  for (Eigen::Index k = 0; k < kernel.cols(); ++k) found.all.push_back({0, shape(kernel.col(k))});
  std::ranges::stable_sort(found.all, {}, [](const Mode& mode) { return largest_entry(mode.shape); });

  const GeneralEigen spectrum = nonzero_spectrum(balanced, scale);
  found.zeros = static_cast<int>(A.rows() - spectrum.values.size());
  const auto part = [&](double x) { return std::abs(x) <= zero ? 0 : x; };
  std::vector<Mode> others;
  for (Eigen::Index k = 0; k < spectrum.values.size(); ++k) {
    const std::complex<double> lambda = spectrum.values[k];
    if (part(lambda.imag()) >= 0)
      others.push_back({{part(lambda.real()), part(lambda.imag())}, shape(spectrum.vectors.col(k))});
  }
  std::ranges::stable_sort(others, {}, [](const Mode& mode) { return std::abs(mode.eigenvalue); });
  found.all.insert(found.all.end(), others.begin(), others.end());
  return found;
}

}  // namespace axode::command
