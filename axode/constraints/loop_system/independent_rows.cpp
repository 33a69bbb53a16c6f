#include "axode/constraints/loop_system/independent_rows.hpp"

#include <algorithm>

#include "axode/recursion/decompositions.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/recursion/least_squares.hpp"

namespace axode {

template <class T>
IndependentRows<T>::IndependentRows(LoopSystem<T>& system, ConstraintLevel level, T part)
    : nv_(system.model().nv()), m_(system.size(level)), part_(part) {
  static_cast<void>(system.factorize());
  system.make_rows(level);
  system.factorize_rows();
  typename LoopSystem<T>::RowByRow dense(m_, nv_);
  system.write(dense.data());
  A_ = dense;
  scale_ = system.scale().head(m_);
  root_ = system.root();
  const Matrix Y = system.Y().leftCols(m_);
  Matrix Q(nv_, std::min(nv_, m_));
  for (int k = 0; k < m_; ++k) {
    Vector z = Y.col(k);
    const auto before = Q.leftCols(rank());
    for (int twice = 0; twice < 2; ++twice) z -= before * (before.transpose() * z).eval();
    const T rest = z.norm();
    const bool found = rank() < Q.cols() && rest > part * scale_[k];
    if (found) Q.col(rank()) = z / rest;
    (found ? independent : redundant).push_back(k);
  }
  find_dependencies(Y);
}

template <class T> void IndependentRows<T>::find_dependencies(const Matrix& Y) {
  dependencies = Matrix::Zero(m_, static_cast<Eigen::Index>(redundant.size()));
  for (std::size_t n = 0; n < redundant.size(); ++n)
    dependencies(redundant[n], static_cast<Eigen::Index>(n)) = T(1);
  if (independent.empty() || redundant.empty()) return;
  const Eigen::MatrixXd all = Y.template cast<double>();
  dependencies(independent, Eigen::indexing::all) =
      -least_squares(all(Eigen::indexing::all, independent), all(Eigen::indexing::all, redundant), 0)
           .template cast<T>();
}

template <class T> auto IndependentRows<T>::kernel() const -> Matrix {
  const Matrix A = A_(independent, Eigen::indexing::all);
  return kernel_of(A.template cast<double>()).template cast<T>();
}

template <class T>
Eigen::MatrixXd IndependentRows<T>::effective_forces(const std::vector<int>& drives) const {
  const Eigen::MatrixXd A = A_(independent, Eigen::indexing::all).template cast<double>();
  const Eigen::VectorXd root = root_.template cast<double>();
  const Eigen::MatrixXd moved = kernel_of(A * root.asDiagonal())(drives, Eigen::indexing::all);
  return range_of(root(drives).asDiagonal() * range_of(moved, static_cast<double>(part_)), 0);
}

template <class T> void IndependentRows<T>::least_multipliers(const Vector& f, std::span<T> lambda) const {
  if (m_ == 0) return;
  const Eigen::VectorXd d = scale_.cwiseInverse().template cast<double>();
  const Eigen::MatrixXd At = A_.transpose().template cast<double>() * d.asDiagonal();
  const Eigen::VectorXd x =
      least_squares(At, f.template cast<double>(), std::same_as<T, float> ? 1e-5 : 1e-9);
  std::ranges::copy(d.cwiseProduct(x).template cast<T>().eval(), lambda.begin());
}

template class IndependentRows<AXODE_T>;

}  // namespace axode
