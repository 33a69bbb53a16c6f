#pragma once
#include <vector>

#include "axode/constraints/absolute/absolute_system.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/schemes/anderson_iteration.hpp"
#include "axode/integration/schemes/generalized_alpha.hpp"

namespace axode {

/// A step of the generalised-α method under constraints, on a group with constant mass matrix M (Arnold,
/// Brüls). Φ are the residuals of joints and loops, B is their Jacobian, λ are the multipliers, f the forces,
/// and s the prescribed motions at the end of the step, 0 for all other rows. The displacement x of the step
/// to q_1 = q_0 ⊕ x and the velocity v_1 follow from the acceleration a_1 by the formulas of the method
/// (AlphaMeans). a_1 and λ satisfy
///   M a_1 = f(q_1, v_1) + ad_{v_1}ᵀ M v_1 + B_1ᵀ λ,   Φ(q_1) = s                    (index 3).
/// The form that is stabilised to index 2 also satisfies B_1 v_1 = s': it has additional multipliers η, and a
/// multiple of the displacement M⁻¹ Bᵀ η is added to x. Nonholonomic constraints with the Jacobian N require
/// N v_1 = 0 in both forms and, in the stabilised form, also N M⁻¹ Bᵀ η = 0.
///
/// System is the class of the mechanism. It must have the member functions of AbsoluteSimulationRun that are
/// called here.
template <class System> class ConstrainedAlpha {
 public:
  using Vector = std::vector<double>;

  /// Starts at the state (q_0, v_0) with the acceleration a_0 and multipliers lambda_0. The linear system of
  /// the mechanism must have been factorised at this state, by factorize_with_rank().
  ConstrainedAlpha(System& system, double spectral_radius, bool stabilized, const Vector& q_0,
                   const Vector& v_0, const Vector& a_0, const Vector& lambda_0)
      : q(q_0),
        v(v_0),
        lambda(lambda_0),
        system_(&system),
        group_(system.bodies().group()),
        stabilized_(stabilized),
        means_(spectral_radius),
        a_(as_eigen(a_0)),
        mean_(a_) {}

  /// Advances q, v and λ from time t to t + h.
  Failure run(double t, double h) {
    auto& bodies = system_->bodies();
    const std::size_t nv = v.size();
    const double c_x = h * h * means_.beta * means_.c, c_v = h * means_.gamma * means_.c;
    a_1_.assign(a_.begin(), a_.end());
    moved_.assign(nv, 0.0);
    q_1_.resize(q.size());
    end_with(h);
    if (Failure failure = system_->factorize(t + h, q_1_, v_1_, c_x, c_v)) return failure;
    system_->set_time(t + h);
    AndersonIteration iteration(system_->norm());
    for (auto status = AndersonIteration::Status::iterating;;) {
      end_with(h);
      if (status == AndersonIteration::Status::converged) break;
      if (Failure failure = system_->forces(t + h, q_1_, v_1_, r_)) return failure;
      system_->add_turning(v_1_, r_);
      bodies.momentum(a_1_, p_);
      as_eigen(r_) -= as_eigen(p_);
      bodies.add_constraint_forces(q_1_, lambda, r_);
      bodies.position_residual(q_1_, gap_, ConstraintLevel::velocity);
      as_eigen(gap_) /= -c_x;
      if (stabilized_) {
        bodies.velocity_residual(q_1_, v_1_, rhs_);
        as_eigen(rhs_) /= -c_v;
        bodies.solve(r_, rhs_, da_, dlambda_);
        as_eigen(gap_) -= as_eigen(rhs_);  // subtracts the contribution B da
        bodies.set_nonholonomic_rates(q_1_, moved_, -1, gap_);
        r_.assign(nv, 0.0);
        bodies.solve(r_, gap_, dmoved_, deta_);
      } else {
        bodies.set_nonholonomic_rates(q_1_, v_1_, -1 / c_v, gap_);
        bodies.solve(r_, gap_, da_, dlambda_);
        dmoved_.assign(nv, 0.0);
      }
      status =
          iteration.update(system_->velocity_scale(v_1_, h) / h, {{as_eigen(a_1_), as_eigen(da_)},
                                                                  {as_eigen(moved_), as_eigen(dmoved_)},
                                                                  {as_eigen(lambda), as_eigen(dlambda_)}});
      if (status == AndersonIteration::Status::diverged) return {t + h, no_convergence};
    }
    q = q_1_;
    v = v_1_;
    a_ = as_eigen(a_1_);
    mean_ = mean_1_;
    return system_->factorize_with_rank(t + h, q);
  }

  /// Replaces the auxiliary acceleration â of the method by the present accelerations a_0, after a jump.
  void restart(const Vector& a_0) { a_ = mean_ = as_eigen(a_0); }

  Vector q, v, lambda;

 private:
  /// Computes q, v and the auxiliary acceleration â of the method at the end of a step of length h. They
  /// follow from a_1_, the acceleration at the end of the step, and from moved_, the displacement M⁻¹ Bᵀ η
  /// with the mass matrix M and multipliers η of the position constraints with the Jacobian B.
  void end_with(double h) {
    v_1_.resize(v.size());
    Eigen::Map<Eigen::VectorXd> v_1 = as_eigen(v_1_);
    means_.advance(h, as_eigen(v), a_, mean_, as_eigen(a_1_), mean_1_, v_1, x_);
    x_ += h * h * means_.beta * means_.c * as_eigen(moved_);
    group_.move(q, x_, q_1_);
  }

  System* system_;
  ConfigurationGroup<double> group_;
  bool stabilized_;
  AlphaMeans means_;
  Eigen::VectorXd a_, mean_, mean_1_, x_;
  Vector a_1_, v_1_, moved_, q_1_, r_, p_, gap_, rhs_, da_, dlambda_, dmoved_, deta_;
};

}  // namespace axode
