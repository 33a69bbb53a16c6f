#include "axode/integration/runs/drive_states.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <stdexcept>
#include <string>

#include "axode/eigen.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/finite.hpp"

namespace axode {

DriveStates::DriveStates(DriveSystem system) : system_(std::move(system)) {
  const auto n = static_cast<Eigen::Index>(size());
  x = dx = x_t_ = dx_t_ = nominal_ = base_ = mean_0_ = old_mean_ = Vector::Zero(n);
  for (Eigen::Index k = 0; k < n; ++k) nominal_[k] = system_.states()[static_cast<std::size_t>(k)].nominal;
}

std::vector<std::string> DriveStates::names() const {
  std::vector<std::string> all;
  for (const DriveState& state : system_.states()) all.push_back(state.name);
  return all;
}

std::string DriveStates::first_not_finite() const {
  for (std::size_t k = 0; k < size(); ++k)
    if (!std::isfinite(rates()[k])) return system_.states()[k].name;
  return {};
}

void DriveStates::start(double t, Span q, Span v, Span given) {
  if (given.empty()) {
    system_.start(t, q, v, as_span(x));
  } else {
    check_size("x", given.size(), size(), "nx");
    for (std::size_t k = 0; k < size(); ++k)
      if (!finite(given[k]))
        throw std::invalid_argument("x[" + std::to_string(k) + "], the state \"" + system_.states()[k].name +
                                    "\", is not finite");
    x = as_eigen(given);
    system_.set_state(t, q, v, given);
  }
  x_t_ = x;
}

void DriveStates::act_at(Span x_t) {
  x_t_ = as_eigen(x_t);
  kappa_ = 0;
}

void DriveStates::add_forces(double t, Span q, Span v, std::span<double> tau) {
  if (empty()) return;
  t_ = t;
  if (kappa_ != 0) solve_states(t, q, v);
  system_.evaluate(t, q, v, as_span(std::as_const(x_t_)), tau, as_span(dx_t_));
}

void DriveStates::begin_implicit_step(double h, double rho) {
  const double d_m = (3 * rho - 1) / (2 * (rho + 1)), d_f = rho / (rho + 1), theta = 0.5 + d_f - d_m;
  c_x_ = (1 - d_f) / (1 - d_m);
  kappa_ = h * theta * c_x_;
  old_mean_ = (d_f * dx - d_m * mean_0_) / (1 - d_m);
  base_ = x + h * (1 - theta) * mean_0_ + h * theta * old_mean_;
  x_t_ = x;
}

/// From now on the states are the solution x of x = base + kappa x'(x, q, v).
void DriveStates::begin_stage(double kappa, const Vector& base, const Vector& guess) {
  kappa_ = kappa;
  base_ = base;
  x_t_ = guess;
}

void DriveStates::begin_midpoint_step(double h, const Vector& x_0) { begin_stage(h / 2, x_0, x_0); }

void DriveStates::take_two_stages(double t, double h, const Vector& x_0, Span q_s, Span v_s, Span q_1,
                                  Span v_1, Vector& x_1) {
  if (empty()) return;
  const double kappa = stage * h;
  start_ = x_0;
  begin_stage(kappa, start_, start_);
  solve_states(t + kappa, q_s, v_s);
  rates_ = (x_t_ - start_) / kappa;
  base_ = start_ + (h - kappa) * rates_;
  x_t_ = start_ + h * rates_;
  solve_states(t + h, q_1, v_1);
  x_1 = x_t_;
}

bool DriveStates::too_fast(double h) const {
  return h < 0 && f_x_.size() > 0 && !(-h * f_x_.eigenvalues().cwiseAbs().maxCoeff() <= 1);
}

void DriveStates::accept_implicit_step() { mean_0_ = old_mean_ + c_x_ * dx; }

/// Computes the states x of the drives at the end of an implicit step by Newton's method: x = base + κ x'(x,
/// q, v), where base and κ are constants of the step. Errors are relative to the nominal values of the
/// states.
void DriveStates::solve_states(double t, Span q, Span v) {
  constexpr int most = 20;
  for (int k = 0; k < most; ++k) {
    system_.rates_by_states(t, q, v, as_span(std::as_const(x_t_)), as_span(dx_t_), f_x_);
    factorize_stage(f_x_);
    residual_ = base_ + kappa_ * dx_t_ - x_t_;
    lu_.solve(residual_, change_);
    x_t_ += change_;
    const auto size_of_x = nominal_.cwiseMax(x_t_.cwiseAbs());
    if (!(change_.cwiseQuotient(size_of_x).lpNorm<Eigen::Infinity>() > 1e-14)) break;
  }
}

/// Factorises 1 - κ ∂x'/∂x.
void DriveStates::factorize_stage(const Eigen::MatrixXd& f_x) {
  stage_matrix_ = -kappa_ * f_x;
  stage_matrix_.diagonal().array() += 1;
  lu_.compute(stage_matrix_);
}

void DriveStates::add_force_derivatives(Span q, Span v, Eigen::Ref<Matrix> by_q, Eigen::Ref<Matrix> by_v) {
  system_.derivatives(t_, q, v, as_span(std::as_const(x_t_)), by_);
  by_q += by_.tau_q;
  by_v += by_.tau_v;
  if (kappa_ == 0) return;
  factorize_stage(by_.f_x);
  for (auto* f : {&by_.f_q, &by_.f_v})
    for (Eigen::Index c = 0; c < f->cols(); ++c) {
      residual_ = f->col(c);
      lu_.solve(residual_, change_);
      f->col(c) = change_;
    }
  by_q.noalias() += kappa_ * by_.tau_x * by_.f_q;
  by_v.noalias() += kappa_ * by_.tau_x * by_.f_v;
}

bool DriveStates::jumps_at(double t, double h, Span q_1, Span v_1, const Vector& x_1, Vector& dtau) {
  constexpr double small = 1e-9;
  dtau.setZero();
  start_ = rates_ = change_ = x_1;
  system_.evaluate(t, q_1, v_1, as_span(x_1), as_span(dtau), as_span(rates_));
  dtau = -dtau;
  system_.discrete(discrete_);
  system_.switch_at(t, q_1, v_1, as_span(start_));
  system_.evaluate(t, q_1, v_1, as_span(std::as_const(start_)), as_span(dtau), as_span(change_));
  system_.set_discrete(discrete_);
  const auto change = (start_ - x_1).cwiseAbs() + h * (change_ - rates_).cwiseAbs();
  const auto size_of_x = nominal_.cwiseMax(start_.cwiseAbs());
  return !(change.cwiseQuotient(size_of_x).lpNorm<Eigen::Infinity>() <= small);
}

bool DriveStates::switch_at(double t, Span q, Span v) {
  const bool changed = !empty() && system_.switch_at(t, q, v, as_span(x));
  x_t_ = x;
  return changed;
}

}  // namespace axode
