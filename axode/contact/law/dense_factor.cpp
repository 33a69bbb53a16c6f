#include "axode/contact/law/dense_factor.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

namespace axode {

void DenseFactor::reserve(Eigen::Index n) {
  const std::size_t size = static_cast<std::size_t>(n);
  if (pivot_.size() >= size) return;
  memory_.resize(size * size);
  pivot_.resize(size);
}

void DenseFactor::factorize_panel(Eigen::Map<Matrix>& A, Eigen::Index first, Eigen::Index count) noexcept {
  const Eigen::Index n = A.rows(), end = first + count;
  for (Eigen::Index k = first; k < end; ++k) {
    Eigen::Index largest = 0;
    A.col(k).tail(n - k).cwiseAbs().maxCoeff(&largest);
    pivot_[static_cast<std::size_t>(k)] = k + largest;
    if (largest > 0) A.row(k).swap(A.row(k + largest));
    A.col(k).tail(n - k - 1) /= A(k, k);
    for (Eigen::Index j = k + 1; j < end; ++j) A.col(j).tail(n - k - 1) -= A(k, j) * A.col(k).tail(n - k - 1);
  }
}

void DenseFactor::factorize(Eigen::Index n) noexcept {
  constexpr Eigen::Index block = 32;
  symmetric_ = false;
  Eigen::Map<Matrix> A = matrix(n);
  for (Eigen::Index k = 0; k < n; k += block) {
    const Eigen::Index count = std::min(block, n - k), rest = n - k - count;
    factorize_panel(A, k, count);
    if (rest == 0) break;
    auto U = A.block(k, k + count, count, rest);
    A.block(k, k, count, count).triangularView<Eigen::UnitLower>().solveInPlace(U);
    A.bottomRightCorner(rest, rest).noalias() -= A.block(k + count, k, rest, count) * U;
  }
}

void DenseFactor::factorize_symmetric(Eigen::Index n) noexcept {
  symmetric_ = true;
  Eigen::Map<Matrix> map = matrix(n);
  Eigen::Ref<Matrix> A(map);
  const Eigen::LLT<Eigen::Ref<Matrix>> factor(A);
  if (factor.info() != Eigen::Success) A.setConstant(std::numeric_limits<double>::quiet_NaN());
}

void DenseFactor::solve(Eigen::Index n, double* x) const noexcept {
  const Eigen::Map<const Matrix> A(memory_.data(), n, n);
  Eigen::Map<Eigen::VectorXd> b(x, n);
  if (symmetric_) {
    A.triangularView<Eigen::Lower>().solveInPlace(b);
    A.transpose().triangularView<Eigen::Upper>().solveInPlace(b);
    return;
  }
  for (Eigen::Index k = 0; k < n; ++k) std::swap(x[k], x[pivot_[static_cast<std::size_t>(k)]]);
  A.triangularView<Eigen::UnitLower>().solveInPlace(b);
  A.triangularView<Eigen::Upper>().solveInPlace(b);
}

}  // namespace axode
