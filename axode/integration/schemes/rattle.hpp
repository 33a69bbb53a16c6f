#pragma once
#include <span>
#include <vector>

#include "axode/constraints/absolute/absolute_system.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/schemes/anderson_iteration.hpp"
#include "axode/integration/tableau.hpp"
#include "axode/integration/trajectory.hpp"

namespace axode {

/// A step of RATTLE on a group with constant mass matrix M (D8.9), or of its symmetric composition. Φ are the
/// residuals of joints and loops, B is their Jacobian, and s(t) are the prescribed motions, 0 for all other
/// rows. The ends of all steps satisfy Φ(q) = s and B v = s'. The method is symplectic if the forces f have a
/// potential. With multipliers λ, the mean velocity w, p_0 = M v_0 and x = h w,
///   dexp⁻¹_xᵀ M w = p_0 + h/2 f(q_0, v_0) + B_0ᵀ λ = k,   q_1 = q_0 ⊕ x,   Φ(q_1) = s(t + h),
///   M v_1 = Ad_{exp x}ᵀ k + h/2 f(q_1, v_1) + B_1ᵀ λ_1,     B_1 v_1 = s'(t + h).
/// Nonholonomic constraints with the Jacobian N are imposed in the middle instead, N(q_0 ⊕ x/2) w = 0
/// (D8.10), by the discrete principle of Lagrange and d'Alembert (Cortés, Martínez). The method is then
/// symmetric and keeps its order, but is not symplectic. The equation for v_1 is implicit, so that damping
/// and drives keep the order. Newton's matrix consists of M and B at the predicted end of the step. The
/// states of drives follow the trapezoidal rule (D17.7a).
///
/// System is the class of the mechanism. It must have the member functions of AbsoluteSimulationRun that are
/// called here.
template <class System> class Rattle {
 public:
  using Vector = std::vector<double>;

  /// Starts at the state (q_0, v_0), at which the system must have been factorised with its rank.
  Rattle(System& system, int order, const Vector& q_0, const Vector& v_0)
      : q(q_0),
        v(v_0),
        system_(&system),
        group_(system.bodies().group()),
        lengths_(symmetric_composition(order)) {}

  /// Advances q, v and the states of the drives, which start at the present ones, from time t to t + h.
  Failure run(double t, double h) {
    drive_states = system_->drives().x;
    for (const double length : lengths_) {
      if (Failure failure = step(t, length * h)) return failure;
      t += length * h;
    }
    return {};
  }

  Vector q, v;
  Eigen::VectorXd drive_states;

 private:
  Failure step(double t, double h) {
    auto& bodies = system_->bodies();
    DriveStates& drives = system_->drives();
    drives.act_at(as_span(drive_states));
    if (Failure failure = system_->forces(t, q, v, f_)) return failure;
    drives.begin_trapezoidal_step(h);
    bodies.momentum(v, p_);
    k_0_ = p_;
    as_eigen(k_0_) += h / 2 * as_eigen(f_);
    w_ = v;
    x_.resize(v.size());
    q_1_.resize(q.size());
    q_middle_.resize(q.size());
    // If branches of the motion meet, the first guess decides which branch is followed. It is computed from
    // the accelerations.
    r_ = f_;
    system_->add_turning(v, r_);
    system_->set_time(t);
    bodies.bias(v, rhs_);
    bodies.solve(r_, rhs_, dw_, lambda_);
    as_eigen(w_) += h / 2 * as_eigen(dw_);
    as_eigen(lambda_) *= h / 2;
    advance(h, q_1_);
    if (Failure failure = system_->factorize(t + h, q_1_)) return failure;
    system_->set_time(t + h);
    AndersonIteration iteration(system_->norm());
    for (auto status = AndersonIteration::Status::iterating;;) {
      advance(h, q_1_);
      k_ = k_0_;
      bodies.add_constraint_forces(q, lambda_, k_);
      if (status == AndersonIteration::Status::converged) break;
      group_.dexp_transpose(x_, k_, r_);
      bodies.momentum(w_, p_);
      as_eigen(r_) -= as_eigen(p_);
      bodies.position_residual(q_1_, rhs_, ConstraintLevel::velocity);
      as_eigen(rhs_) *= -1 / h;
      if (bodies.has_nonholonomic_rows()) {
        advance(h / 2, q_middle_);
        bodies.set_nonholonomic_rates(q_middle_, w_, -1, rhs_);
      }
      bodies.solve(r_, rhs_, dw_, dlambda_);
      status = iteration.update(system_->velocity_scale(w_, h),
                                {{as_eigen(w_), as_eigen(dw_)}, {as_eigen(lambda_), as_eigen(dlambda_)}});
      if (status == AndersonIteration::Status::diverged) return {t + h, no_convergence};
    }
    group_.Ad_transpose(x_, k_, k_);
    if (Failure failure = system_->factorize_with_rank(t + h, q_1_)) return failure;
    v = w_;
    AndersonIteration second_iteration(system_->norm());
    old_.clear();
    for (auto status = AndersonIteration::Status::iterating; status != AndersonIteration::Status::converged;
         old_ = f_) {
      if (Failure failure = system_->forces(t + h, q_1_, v, f_)) return failure;
      if (old_ == f_) break;  // f does not depend on v
      bodies.momentum(v, p_);
      as_eigen(r_) = as_eigen(k_) + h / 2 * as_eigen(f_) - as_eigen(p_);
      bodies.velocity_residual(q_1_, v, rhs_);
      as_eigen(rhs_) *= -1;
      bodies.solve(r_, rhs_, dw_, dlambda_);
      status = second_iteration.update(system_->velocity_scale(v, h), {{as_eigen(v), as_eigen(dw_)}});
      if (status == AndersonIteration::Status::diverged) return {t + h, no_convergence};
    }
    q = q_1_;
    drive_states = as_eigen(drives.states());
    return drives.too_fast(h) ? Failure{t + h, DriveStates::runs_backwards} : Failure{};
  }

  /// Computes to = q ⊕ x with x = part w.
  void advance(double part, Vector& to) {
    as_eigen(x_) = part * as_eigen(w_);
    group_.move(q, x_, to);
  }

  System* system_;
  ConfigurationGroup<double> group_;
  std::span<const double> lengths_;
  Vector f_, old_, k_0_, k_, w_, x_, q_1_, q_middle_, r_, p_, rhs_, dw_, lambda_, dlambda_;
};

}  // namespace axode
