#include "axode/contact/law/velocity_solver.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "axode/scalar/index.hpp"

namespace axode {
namespace {

/// A small number ε that changes the matrix of Newton's method (D11.9) such that it is regular although
/// contacts are redundant. Newton's steps then hardly change the part of the impulses that causes no motion,
/// so that redundant contacts share the load as they did at the start of the iteration.
constexpr double keep = 1e-9;
/// The approximate number of columns of Y that are multiplied at once when Y B Yᵀ is computed.
constexpr int most_solved = 48;
constexpr std::size_t matrix_size = LawBlock::most_rows * LawBlock::most_rows;

}  // namespace

void VelocitySolver::reserve(int nv, int rows) {
  constexpr int row_vectors = 15, velocity_vectors = 10;
  const int dual = std::min(nv, rows);
  dense_.reserve(dual);
  sparse_.reserve(nv, rows);
  memory_.resize(
      std::max(memory_.size(), index(row_vectors) * index(rows) + index(velocity_vectors) * index(nv)));
  G_memory_.resize(std::max(G_memory_.size(), index(dual) * index(dual)));
  branches_.reserve(index(rows));
  matrices_.resize(std::max(matrices_.size(), index(rows) * matrix_size));
  for (std::vector<double>* x : {&YB_, &columns_})
    x->resize(std::max(x->size(), index(SparseFactor::padded(nv)) * (most_solved + LawBlock::most_rows)));
}

void VelocitySolver::begin(const VelocityProblem& p) noexcept {
  problem_ = &p;
  rows_ = p.rows();
  size_ = p.w.norm();
  double* next = memory_.data();
  const auto take = [&](Vector& x, int n) {
    new (&x) Vector(next, n);
    next += n;
  };
  for (Vector* x : {&u_, &b_, &z_, &R_, &resolved_, &lambda_0_, &lambda_, &trial_, &step_, &best_, &start_,
                    &y_, &y_before_, &dual_, &residual_})
    take(*x, rows_);
  for (Vector* x :
       {&x_, &f_, &t_, &x_trial_, &f_trial_, &dx_, &path_point_.x, &tangent_.x, &next_.x, &after_kink_.x})
    take(*x, p.nv());
  std::copy_n(p.r.data(), rows_, b_.data());
  p.add_transposed(p.w.data(), b_.data());
  analyse();
  by_multipliers_ = 2 * std::pow(rows_, 3) < sparse_.cost();
  if (by_multipliers_) p.delassus(Eigen::Map<Eigen::MatrixXd>(G_memory_.data(), rows_, rows_));
}

/// Finds the groups of constraint rows whose impulses change the same velocities, and the order in which the
/// velocities are eliminated when a matrix 1 + Y B Yᵀ is factorised. Y is D^-½ L⁻ᵀ Jᵀ for the Jacobian J of
/// the rows and the mass matrix Lᵀ D L. B is block diagonal, with a block for each contact or other law: if
/// the velocities of its rows change by δu, the linearised law changes their impulses by -B δu.
void VelocitySolver::analyse() noexcept {
  sparse_.begin(problem_->nv());
  std::size_t last = std::numeric_limits<std::size_t>::max();
  for (const VelocityProblem::Block& b : problem_->blocks()) {
    if (b.support != last) sparse_.add_group(problem_->support(b));
    last = b.support;
  }
  if (sparse_.analyse()) branches_.clear();
}

void VelocitySolver::continue_from(const VelocitySolver& other) {
  dense_ = other.dense_;
  sparse_ = other.sparse_;
  matrices_ = other.matrices_;
  branches_ = other.branches_;
  factorized_rows_ = other.factorized_rows_;
}

/// Keeps the factors of the matrix that was made at the trial impulses z_, for the next call of solve().
void VelocitySolver::keep_factors() noexcept {
  factorized_rows_ = by_multipliers_ ? rows_ : -rows_;
  for (const VelocityProblem::Block& b : problem_->blocks())
    branches_.push_back(branch_of(b, z_.data() + b.first));
}

/// Whether there are factors of a matrix of the present size in which each block had the branch of its law
/// that it has at the trial impulses z_.
bool VelocitySolver::has_factors() const noexcept {
  return factorized_rows_ == (by_multipliers_ ? rows_ : -rows_) &&
         std::ranges::equal(problem_->blocks(), branches_,
                            [&](const VelocityProblem::Block& b, LawBranch branch) {
                              return branch_of(b, z_.data() + b.first) == branch;
                            });
}

VelocitySolution VelocitySolver::solve(const VelocityProblem& problem, double* lambda, double tolerance,
                                       const Monitor& monitor) {
  begin(problem);
  monitor_ = &monitor;
  stopped_ = false;
  solution_ = {};
  result_ = lambda;
  if (rows_ == 0) return solution_;
  solution_.certificate = newton(lambda, tolerance, {.failures = 4});
  if (searches()) {
    start_.setZero();
    improve(tolerance, {});
  }
  for (const bool on_laws : {false, true}) {
    if (!searches()) break;
    alternate(start_.data(), on_laws);
    improve(tolerance, {});
  }
  for (const double part : {0.0, 1.0, 0.5, 1.5}) {
    if (!searches()) break;
    y_ = part * Vector(lambda, rows_);
    follow_path(tolerance);
  }
  // Exactly symmetric problems may lie on kinks of the law. Therefore the further starts break the symmetry.
  constexpr int most_disturbed = 6;
  for (int k = 0; k < most_disturbed && searches(); ++k) {
    for (int row = 0; row < rows_; ++row)
      start_[row] = lambda[row] * (1 + 0.3 * std::sin(1.7 * row + 0.9 * k));
    improve(tolerance, {});
  }
  return solution_;
}

bool VelocitySolver::searches() {
  if (solution_.certificate <= accepted) return false;
  stopped_ = stopped_ || (*monitor_ && !(*monitor_)());
  return !stopped_;
}

void VelocitySolver::improve(double tolerance, const NewtonOptions& options) noexcept {
  ++solution_.restarts;
  const double e = newton(start_.data(), tolerance, options);
  if (!(e < solution_.certificate)) return;
  Vector(result_, rows_) = start_;
  solution_.certificate = e;
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

/// Returns the certificate of λ. Writes z = λ - u/d² to z_ and λ - resolve(z) to residual_.
double VelocitySolver::certify(const double* lambda) noexcept {
  compute_velocities(lambda);
  const Eigen::Map<const Eigen::VectorXd> l(lambda, rows_), d2(problem_->squared_scales().data(), rows_);
  z_ = l - u_.cwiseQuotient(d2);
  resolve_all(residual_.data());
  residual_ = l - residual_;
  return certificate_of(*problem_, residual_.data(), t_.data());
}

/// Computes the residual ρ = λ - resolve(λ_0 - u/R) of a proximal step at multipliers λ: λ_0 are the
/// multipliers at the start of the step, u the velocities of the constraint rows for λ, and R a factor for
/// each row. `resolve` maps a trial impulse to the impulse that the law of contact allows. Writes resolve(λ_0
/// - u/R) to resolved_ and ρ to residual_. Returns √(Σ d² ρ²), where d² is about the diagonal entry of J M⁻¹
/// Jᵀ for a row, with the Jacobian J of the rows and the mass matrix M.
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

/// Computes f = x - w - Y resolve(λ_0 - (Yᵀ x + r)/R) and returns |f|.
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

/// Steps from `from` along a direction, and halves the length of the step until the residual falls. Returns
/// false if it has not fallen at 0.01 of the full length.
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
      dense_.solve(rows_, step_.data());
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
    sparse_.solve(dx_.data());
    if (!search(x_, dx_, x_trial_, norm, [&](const Vector& x) { return velocity_residual(x, f_trial_); }))
      return velocity_residual(x_, f_);
    x_ = x_trial_;
    f_ = f_trial_;
  }
  return norm;
}

double VelocitySolver::newton(double* lambda, double tolerance, const NewtonOptions& options) noexcept {
  constexpr int most = 40, patience = 6;
  constexpr double rounding = 1e-13, near = 1e-2;
  const Eigen::Map<const Eigen::VectorXd> d2(problem_->squared_scales().data(), rows_);
  Vector l(lambda, rows_);
  double e = certify(lambda), least = e, mu = options.mu;
  int stalled = 0, failed = 0;
  best_ = l;
  for (int outer = 0; !(e <= tolerance); ++outer) {
    if (e < near) {
      const double before = e;
      e = polish(lambda, tolerance, options.patience, e);
      if (e < least) best_ = l;
      least = std::min(e, least);
      if (e <= tolerance || (e <= rounding && e > 0.5 * before)) break;
    }
    if (outer == most || stalled >= patience) break;
    R_ = mu * d2;
    lambda_0_ = l;
    compute_velocities(lambda);
    const double size = size_ + (problem_->w + t_).norm();
    int iterations = 0;
    const double left = proximal_step(std::max(rounding, 1e-3 * e) * size, iterations);
    if (!(left <= std::max(0.1 * e, rounding) * size)) {  // A shorter proximal step is easier.
      mu *= 10;
      if (++failed > options.failures || mu > 100) break;
      e = certify(lambda);
      continue;
    }
    l = resolved_;
    e = certify(lambda);
    stalled = e < 0.9 * least ? 0 : stalled + 1;
    if (e < least) best_ = l;
    least = std::min(e, least);
    if (iterations <= 5) mu = std::max(1e-9, mu * (iterations > 2 ? 0.1 : 0.03));
  }
  l = best_;
  return least;
}

double VelocitySolver::polish(double* lambda, double tolerance, int patience, double e) noexcept {
  const int most = 8 + 2 * patience;
  constexpr double linear = 1e-3, near = 1e-3;
  const double precise = 1e-4 * tolerance;  // what steps with new factors usually reach
  const VelocityProblem& p = *problem_;
  const Eigen::Map<const Eigen::VectorXd> d2(p.squared_scales().data(), rows_);
  Vector l(lambda, rows_);
  double least = e;
  int idle = 0;
  // The factors are used again where the law is almost linear, also those of the last call of solve().
  bool old = keeps_factors && e < near && has_factors();
  bool factorized = old;
  lambda_0_ = l;
  R_ = d2;
  for (int k = 0; k < most; ++k) {  // z_ and residual_ belong to the last certify().
    if (!factorized) {
      old = false;
      by_multipliers_ ? factorize_multipliers(keep) : factorize_velocities(keep);
      if (keeps_factors) keep_factors();
    }
    if (by_multipliers_) {
      step_ = -residual_;
      dense_.solve(rows_, step_.data());
    } else {
      // (1 - (1 - keep) Z)⁻¹ residual = (1 + (1 - keep) B R) residual
      u_ = (1 - keep) * residual_.cwiseProduct(R_);
      multiply_blocks(u_);
      step_ = -residual_ - u_;
      dx_.setZero();
      p.add_product(1, step_.data(), dx_.data());
      sparse_.solve(dx_.data());
      u_.setZero();
      p.add_transposed(dx_.data(), u_.data());
      multiply_blocks(u_);
      step_ -= u_;
    }
    l += step_;
    e = certify(lambda);
    factorized = e < linear * least;
    if (old && !factorized && !(e <= precise) && !(least <= tolerance)) {  // These factors are too old.
      l = lambda_0_;
      e = certify(lambda);
      continue;
    }
    if (!(e < 0.5 * least)) ++idle;
    if (e < least) {
      least = e;
      lambda_0_ = l;
    }
    if (e <= (old ? precise : tolerance) || idle > patience) break;
  }
  l = lambda_0_;
  return least;
}

void VelocitySolver::multiply_blocks(Vector& a) const noexcept {
  const auto blocks = problem_->blocks();
  for (std::size_t k = 0; k < blocks.size(); ++k)
    with_rows(blocks[k], [&](auto n) {
      const Eigen::Map<const LawMatrix<n()>> B(matrices_.data() + k * matrix_size);
      auto part = a.template segment<n()>(blocks[k].first);
      part = (B * part).eval();
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
        B = (LawMatrix<rows>::Identity() - (1 - kept) * Z).inverse() * Z / R_[b.first];
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
  const auto blocks = p.blocks();
  branches_.clear();
  sparse_.clear(symmetric);
  int group = 0;
  for (std::size_t k = 0; k < blocks.size(); ++group) {
    const std::size_t support = blocks[k].support;
    const int stride = SparseFactor::padded(blocks[k].width);
    while (k < blocks.size() && blocks[k].support == support) {
      int columns = 0;
      for (; k < blocks.size() && blocks[k].support == support && columns < most_solved; ++k)
        with_rows(blocks[k], [&](auto n) {
          const Eigen::Map<const LawMatrix<n()>> B(matrices_.data() + k * matrix_size);
          if (B.isZero(0)) return;
          const auto Y = p.columns<n()>(blocks[k]);
          using Columns = Eigen::Matrix<double, Eigen::Dynamic, n()>;
          using Part = Eigen::Map<Columns, 0, Eigen::OuterStride<>>;
          const std::ptrdiff_t at = columns * stride;
          Part(columns_.data() + at, Y.rows(), n(), Eigen::OuterStride<>(stride)) = Y;
          Part(YB_.data() + at, Y.rows(), n(), Eigen::OuterStride<>(stride)).noalias() = Y.lazyProduct(B);
          columns += n();
        });
      if (columns > 0) sparse_.add(group, YB_.data(), columns_.data(), columns);
    }
  }
  sparse_.factorize();
  ++solution_.factorizations;
}

void VelocitySolver::factorize_multipliers(double kept) noexcept {
  const Eigen::Map<const Eigen::MatrixXd> G(G_memory_.data(), rows_, rows_);
  auto H = dense_.matrix(rows_);
  branches_.clear();
  for (const VelocityProblem::Block& b : problem_->blocks())
    with_rows(b, [&](auto n) {
      LawMatrix<n()> Z;
      differentiate<n()>(b, z_.data() + b.first, Z);
      H.middleRows<n()>(b.first).noalias() = (Z / R_[b.first]).lazyProduct(G.middleRows<n()>(b.first));
      auto diagonal = H.block<n(), n()>(b.first, b.first);
      diagonal.diagonal().array() += 1;
      if (kept > 0) diagonal -= (1 - kept) * Z;
    });
  dense_.factorize(rows_);
  ++solution_.factorizations;
}

}  // namespace axode
