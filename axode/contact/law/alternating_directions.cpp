#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/contact/law/velocity_solver.hpp"

/// The alternating direction method of multipliers (D11.10), which finds start values for Newton's method.
namespace axode {
namespace {

constexpr int most_iterations = 600;
constexpr int most_changes = 12;  ///< largest number of changes of the weight ρ
constexpr double good_start = 1e-6;

}  // namespace

/// Computes out = D⁻¹ Yᵀ Y D⁻¹ a with the Delassus operator Yᵀ Y = J M⁻¹ Jᵀ of the Jacobian J of the
/// constraint rows and the mass matrix M. D is diagonal and scales the rows such that the diagonal entries of
/// the product are about 1.
void VelocitySolver::apply_delassus(const Vector& a, Vector& out) noexcept {
  const Eigen::Map<const Eigen::VectorXd> d2(problem_->squared_scales().data(), rows_);
  u_ = a.array() / d2.array().sqrt();
  x_.setZero();
  problem_->add_product(1, u_.data(), x_.data());
  u_.setZero();
  problem_->add_transposed(x_.data(), u_.data());
  out = u_.array() / d2.array().sqrt();
}

double VelocitySolver::largest_eigenvalue() noexcept {
  constexpr int powers = 20;
  for (int row = 0; row < rows_; ++row) step_[row] = 1 + 0.1 * std::sin(row);
  for (int k = 0; k < powers; ++k) {
    trial_ = step_ / std::max(step_.norm(), std::numeric_limits<double>::min());
    apply_delassus(trial_, step_);
  }
  return step_.norm();
}

/// Factorises 1 + Y D⁻² Yᵀ/s, where D is the diagonal matrix of the scales d of the rows.
void VelocitySolver::factorize_shifted(double s) noexcept {
  const auto blocks = problem_->blocks();
  for (std::size_t k = 0; k < blocks.size(); ++k)
    with_rows(blocks[k], [&](auto n) {
      Eigen::Map<LawMatrix<n()>>(matrices_.data() + k * LawBlock::most_rows * LawBlock::most_rows) =
          LawMatrix<n()>::Identity() /
          (s * problem_->squared_scales()[static_cast<std::size_t>(blocks[k].first)]);
    });
  factorize_with(true);
}

/// Computes a := (D⁻¹ Yᵀ Y D⁻¹ + s)⁻¹ a for a number s by (D11.10), with the Delassus operator Yᵀ Y = J M⁻¹
/// Jᵀ of the Jacobian J of the constraint rows and the mass matrix M. D is diagonal and scales the rows such
/// that the diagonal entries of D⁻¹ Yᵀ Y D⁻¹ are about 1.
void VelocitySolver::solve_shifted(double s, Vector& a) noexcept {
  const Eigen::Map<const Eigen::VectorXd> d2(problem_->squared_scales().data(), rows_);
  u_ = a.array() / d2.array().sqrt();
  dx_.setZero();
  problem_->add_product(1, u_.data(), dx_.data());
  sparse_.solve(dx_.data());
  u_.setZero();
  problem_->add_transposed(dx_.data(), u_.data());
  a = (a.array() - u_.array() / d2.array().sqrt() / s) / s;
}

void VelocitySolver::alternate(double* lambda, bool on_laws) noexcept {
  const Eigen::Map<const Eigen::VectorXd> d2(problem_->squared_scales().data(), rows_);
  constexpr double eta = 1e-6;
  Vector &x = lambda_, &y = y_, &dual = dual_;
  double rho = 0.1 * largest_eigenvalue(), least = std::numeric_limits<double>::infinity();
  int changes = 0;
  bool factorized = false;
  x.setZero();
  y.setZero();
  best_.setZero();
  dual = -b_.array() / d2.array().sqrt();
  for (int k = 1; k <= most_iterations; ++k) {
    const double s = rho + eta;
    if (!factorized) factorize_shifted(s);
    factorized = true;
    trial_ = eta * x + rho * y - dual;
    trial_.array() -= b_.array() / d2.array().sqrt();
    if (!on_laws)
      for (const VelocityProblem::Block& b : problem_->blocks())
        if (b.law == ContactLaw::contact) trial_[b.first] -= dual_.segment(b.first + 1, b.rows - 1).norm();
    solve_shifted(s, trial_);
    x = trial_;
    y_before_ = y;
    z_ = x + dual / rho;
    for (const VelocityProblem::Block& b : problem_->blocks()) {
      const double* const from = z_.data() + b.first;
      // The bound of dry friction is an impulse, but the vectors here are multiplied by d.
      LawBlock scaled = b;
      scaled.bound *= std::sqrt(d2[b.first]);
      on_laws ? resolve(scaled, from, y.data() + b.first) : project(scaled, from, y.data() + b.first);
    }
    dual += rho * (x - y);
    if (k % 5 != 0) continue;
    step_ = y.array() / d2.array().sqrt();
    const double e = certify(step_.data());
    if (e < least) {
      least = e;
      best_ = step_;
    }
    if (e < good_start) break;
    const double tiny = std::numeric_limits<double>::min();
    const double primal = (x - y).norm() / std::max({x.norm(), y.norm(), tiny});
    const double change = rho * (y - y_before_).norm() / std::max(dual.norm(), tiny);
    const bool balanced = primal > 0.1 * change && primal < 10 * change;
    if (balanced || changes == most_changes || k > most_iterations - 50) continue;
    rho *= primal > change ? 10 : 0.1;
    factorized = false;
    ++changes;
  }
  Vector(lambda, rows_) = best_;
}

}  // namespace axode
