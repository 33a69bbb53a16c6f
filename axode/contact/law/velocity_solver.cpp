#include "axode/contact/law/velocity_solver.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

namespace axode {
namespace {

/// A certificate that needs no further start.
constexpr double accepted = 1e-9;
/// Part of their multipliers that redundant contacts lose in a step of Newton's method on the law (D11.9).
constexpr double keep = 1e-9;
constexpr std::size_t matrix_size = LawBlock::most_rows * LawBlock::most_rows;

std::size_t index(int k) { return static_cast<std::size_t>(k); }

}  // namespace

void VelocitySolver::reserve(int nv, int rows) {
  constexpr int row_vectors = 15, velocity_vectors = 6;
  const int dual = std::min(nv, rows);
  factor_.reserve(nv);
  memory_.resize(
      std::max(memory_.size(), index(row_vectors) * index(rows) + index(velocity_vectors) * index(nv)));
  G_memory_.resize(std::max(G_memory_.size(), index(dual) * index(dual)));
  matrices_.resize(std::max(matrices_.size(), index(rows) * matrix_size));
  group_.resize(std::max(group_.size(), index(nv) * index(nv)));
  columns_.resize(std::max(columns_.size(), index(nv) * LawBlock::most_rows));
}

void VelocitySolver::begin(const VelocityProblem& p) noexcept {
  problem_ = &p;
  rows_ = p.rows();
  by_multipliers_ = rows_ <= p.nv();
  size_ = p.w.norm();
  factorizations_ = 0;
  double* next = memory_.data();
  const auto take = [&](Vector& x, int n) {
    new (&x) Vector(next, n);
    next += n;
  };
  for (Vector* x : {&u_, &b_, &z_, &R_, &resolved_, &lambda_0_, &lambda_, &trial_, &step_, &best_, &start_,
                    &y_, &y_before_, &dual_, &residual_})
    take(*x, rows_);
  for (Vector* x : {&x_, &f_, &t_, &x_trial_, &f_trial_, &dx_}) take(*x, p.nv());
  std::copy_n(p.r.data(), rows_, b_.data());
  p.add_transposed(p.w.data(), b_.data());
  if (by_multipliers_) p.delassus(Eigen::Map<Eigen::MatrixXd>(G_memory_.data(), rows_, rows_));
}

VelocitySolution VelocitySolver::solve(const VelocityProblem& problem, double* lambda,
                                       double tolerance) noexcept {
  begin(problem);
  VelocitySolution solution;
  if (rows_ == 0) return solution;
  constexpr int few = 4, many = 8;
  double e = newton(lambda, tolerance, few);
  const auto improve = [&] {
    ++solution.restarts;
    const double e_new = newton(start_.data(), tolerance, many);
    if (!(e_new < e)) return;
    Vector(lambda, rows_) = start_;
    e = e_new;
  };
  if (!(e <= accepted)) {
    start_.setZero();
    improve();
  }
  for (const bool on_laws : {false, true}) {
    if (e <= accepted) break;
    alternate(start_.data(), on_laws);
    improve();
  }
  // Exactly symmetric problems may lie on kinks of the law: further starts are off the symmetry.
  constexpr int most_disturbed = 6;
  for (int k = 0; k < most_disturbed && !(e <= accepted); ++k) {
    for (int row = 0; row < rows_; ++row)
      start_[row] = lambda[row] * (1 + 0.3 * std::sin(1.7 * row + 0.9 * k));
    improve();
  }
  solution.certificate = e;
  solution.factorizations = factorizations_;
  return solution;
}

void VelocitySolver::resolve_all(double* lambda) const noexcept {
  for (const VelocityProblem::Block& b : problem_->blocks())
    resolve(b, z_.data() + b.first, lambda + b.first);
}

void VelocitySolver::compute_velocities(const double* lambda) noexcept {
  t_.setZero();
  problem_->add_product(1, lambda, t_.data());
  u_ = b_;
  problem_->add_transposed(t_.data(), u_.data());
}

/// Leaves z = λ - u/d² in z_ and λ - resolve(z) in residual_.
double VelocitySolver::certify(const double* lambda) noexcept {
  compute_velocities(lambda);
  const Eigen::Map<const Eigen::VectorXd> l(lambda, rows_), d2(problem_->squared_scales().data(), rows_);
  z_ = l - u_.cwiseQuotient(d2);
  resolve_all(residual_.data());
  residual_ = l - residual_;
  return certificate_of(*problem_, residual_.data(), t_.data());
}

/// λ - resolve(λ_0 - u/R), measured by the masses.
double VelocitySolver::multiplier_residual(const Vector& lambda) noexcept {
  const Eigen::Map<const Eigen::MatrixXd> G(G_memory_.data(), rows_, rows_);
  const Eigen::Map<const Eigen::VectorXd> d2(problem_->squared_scales().data(), rows_);
  u_ = b_;
  u_.noalias() += G * lambda;
  z_ = lambda_0_ - u_.cwiseQuotient(R_);
  resolve_all(resolved_.data());
  residual_ = lambda - resolved_;
  return std::sqrt((d2.array() * residual_.array().square()).sum());
}

/// f = x - w - Y resolve(λ_0 - (Yᵀ x + r)/R).
double VelocitySolver::velocity_residual(const Vector& x, Vector& f) noexcept {
  const VelocityProblem& p = *problem_;
  std::copy_n(p.r.data(), rows_, u_.data());
  p.add_transposed(x.data(), u_.data());
  z_ = lambda_0_ - u_.cwiseQuotient(R_);
  resolve_all(resolved_.data());
  f = x - p.w;
  p.add_product(-1, resolved_.data(), f.data());
  return f.norm();
}

/// Goes along a direction, by half as far until the residual falls. Returns false if it does not.
template <class Residual>
bool VelocitySolver::search(const Vector& from, const Vector& direction, Vector& to, double& norm,
                            const Residual& residual) noexcept {
  for (double t = 1; t > 0.01; t /= 2) {
    to = from + t * direction;
    const double trial = residual(to);
    if (trial <= (1 - 1e-2 * t) * norm) {
      norm = trial;
      return true;
    }
  }
  return false;
}

double VelocitySolver::proximal_step(double goal, int& iterations) noexcept {
  constexpr int most = 10;
  double norm = 0;
  if (by_multipliers_) {
    lambda_ = lambda_0_;
    norm = multiplier_residual(lambda_);
    for (iterations = 0; iterations < most && norm > goal; ++iterations) {
      factorize_multipliers(0);
      step_ = -residual_;
      factor_.solve(rows_, step_.data());
      if (!search(lambda_, step_, trial_, norm, [&](const Vector& l) { return multiplier_residual(l); }))
        return multiplier_residual(lambda_);
      lambda_ = trial_;
    }
    return norm;
  }
  x_ = problem_->w + t_;
  norm = velocity_residual(x_, f_);
  for (iterations = 0; iterations < most && norm > goal; ++iterations) {
    factorize_velocities(0);
    dx_ = -f_;
    factor_.solve(dx_.size(), dx_.data());
    if (!search(x_, dx_, x_trial_, norm, [&](const Vector& x) { return velocity_residual(x, f_trial_); }))
      return velocity_residual(x_, f_);
    x_ = x_trial_;
    f_ = f_trial_;
  }
  return norm;
}

double VelocitySolver::newton(double* lambda, double tolerance, int failures) noexcept {
  constexpr int most = 40, patience = 6;
  constexpr double rounding = 1e-13, near = 1e-5;
  const Eigen::Map<const Eigen::VectorXd> d2(problem_->squared_scales().data(), rows_);
  Vector l(lambda, rows_);
  double e = certify(lambda), least = e, mu = 1e-2;
  int stalled = 0, failed = 0;
  best_ = l;
  const auto record = [&] {
    if (!(e < least)) return;
    least = e;
    best_ = l;
  };
  for (int outer = 0; outer < most && !(e <= tolerance); ++outer) {
    R_ = mu * d2;
    lambda_0_ = l;
    compute_velocities(lambda);
    const double size = size_ + (problem_->w + t_).norm();
    int iterations = 0;
    const double left = proximal_step(std::max(rounding, 1e-3 * e) * size, iterations);
    if (!(left <= std::max(0.1 * e, rounding) * size)) {  // A shorter proximal step is easier.
      mu *= 10;
      if (++failed > failures || mu > 100) break;
      continue;
    }
    l = resolved_;
    e = certify(lambda);
    stalled = e < 0.9 * least ? 0 : stalled + 1;
    record();
    if (stalled >= patience) break;
    if (iterations <= 5) mu = std::max(1e-9, mu * (iterations > 2 ? 0.1 : 0.03));
    if (e < near && e > tolerance) {
      const double before = e;
      e = polish(lambda, tolerance);
      record();
      if (e <= rounding && e > 0.5 * before) break;
    }
  }
  l = best_;
  return least;
}

double VelocitySolver::polish(double* lambda, double tolerance) noexcept {
  constexpr int most = 8;
  const VelocityProblem& p = *problem_;
  const Eigen::Map<const Eigen::VectorXd> d2(p.squared_scales().data(), rows_);
  Vector l(lambda, rows_);
  double e = certify(lambda), least = e;
  lambda_0_ = l;
  R_ = d2;
  for (int k = 0; k < most; ++k) {  // z_ and residual_ are those of the last certificate.
    if (by_multipliers_) {
      factorize_multipliers(keep);
      step_ = -residual_;
      factor_.solve(rows_, step_.data());
    } else {
      factorize_velocities(keep);  // makes residual_ (1 - (1 - keep) Z)⁻¹ residual_
      dx_.setZero();
      p.add_product(-1, residual_.data(), dx_.data());
      factor_.solve(dx_.size(), dx_.data());
      u_.setZero();
      p.add_transposed(dx_.data(), u_.data());
      step_ = -residual_;
      subtract_products();
    }
    l += step_;
    e = certify(lambda);
    const bool better = e < 0.5 * least;
    if (e < least) {
      least = e;
      lambda_0_ = l;
    }
    if (e <= tolerance || !better) break;
  }
  l = lambda_0_;
  return least;
}

/// step_ -= B u_, block by block.
void VelocitySolver::subtract_products() noexcept {
  const auto blocks = problem_->blocks();
  for (std::size_t k = 0; k < blocks.size(); ++k)
    with_rows(blocks[k], [&](auto n) {
      const Eigen::Map<const LawMatrix<n()>> B(matrices_.data() + k * matrix_size);
      step_.template segment<n()>(blocks[k].first) -= B * u_.template segment<n()>(blocks[k].first);
    });
}

bool VelocitySolver::make_matrices(double kept) noexcept {
  bool symmetric = true;
  const auto blocks = problem_->blocks();
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const VelocityProblem::Block& b = blocks[k];
    with_rows(b, [&](auto n) {
      constexpr int rows = n();
      Eigen::Map<LawMatrix<rows>> B(matrices_.data() + k * matrix_size);
      LawMatrix<rows> Z;
      const LawBranch branch = differentiate<rows>(b, z_.data() + b.first, Z);
      if (branch == LawBranch::slide && rows > 1) symmetric = false;
      if (kept > 0) {
        const LawMatrix<rows> S = (LawMatrix<rows>::Identity() - (1 - kept) * Z).inverse();
        residual_.template segment<rows>(b.first) = (S * residual_.template segment<rows>(b.first)).eval();
        B = S * Z / R_[b.first];
      } else {
        B = Z / R_[b.first];
      }
    });
  }
  return symmetric;
}

void VelocitySolver::factorize_velocities(double kept) noexcept { factorize_with(make_matrices(kept)); }

void VelocitySolver::factorize_with(bool symmetric) noexcept {
  const VelocityProblem& p = *problem_;
  const int nv = p.nv();
  auto H = factor_.matrix(nv);
  H.setIdentity();
  const auto blocks = p.blocks();
  for (std::size_t first = 0, end = 0; first < blocks.size(); first = end) {
    const int width = blocks[first].width;
    Eigen::Map<Eigen::MatrixXd> sum(group_.data(), width, width);
    sum.setZero();
    for (end = first; end < blocks.size() && blocks[end].support == blocks[first].support; ++end)
      with_rows(blocks[end], [&](auto n) {
        const Eigen::Map<const LawMatrix<n()>> B(matrices_.data() + end * matrix_size);
        if (B(0, 0) == 0) return;
        const auto A = p.columns<n()>(blocks[end]);
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, n()>> AB(columns_.data(), width, n());
        AB.noalias() = A.lazyProduct(B);
        sum += AB.lazyProduct(A.transpose());
      });
    const std::span<const int> at = p.support(blocks[first]);
    for (int j = 0; j < width; ++j)
      for (int i = 0; i < width; ++i) H(at[index(i)], at[index(j)]) += sum(i, j);
  }
  symmetric ? factor_.factorize_symmetric(nv) : factor_.factorize(nv);
  ++factorizations_;
}

void VelocitySolver::factorize_multipliers(double kept) noexcept {
  const Eigen::Map<const Eigen::MatrixXd> G(G_memory_.data(), rows_, rows_);
  auto H = factor_.matrix(rows_);
  for (const VelocityProblem::Block& b : problem_->blocks())
    with_rows(b, [&](auto n) {
      LawMatrix<n()> Z;
      differentiate<n()>(b, z_.data() + b.first, Z);
      H.middleRows<n()>(b.first).noalias() = (Z / R_[b.first]).lazyProduct(G.middleRows<n()>(b.first));
      auto diagonal = H.block<n(), n()>(b.first, b.first);
      diagonal.diagonal().array() += 1;
      if (kept > 0) diagonal -= (1 - kept) * Z;
    });
  factor_.factorize(rows_);
  ++factorizations_;
}

}  // namespace axode
