#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "axode/constraints/absolute/absolute_system.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/schemes/anderson_iteration.hpp"
#include "axode/integration/trajectory.hpp"

namespace axode {

/// A step of the half-explicit method of third order (Brasey, Hairer) on a group with constant mass matrix M,
/// in the form of Munthe-Kaas. With the coefficients a_ij of the method, stage i has the configuration q_i =
/// q_0 ⊕ θ_i, the velocity V_i, the forces f, the Jacobian B_i of joints and loops, and multipliers λ_i:
///   M L_i = f(q_i, V_i) + ad_{V_i}ᵀ M V_i + B_iᵀ λ_i with the λ_i for which B_{i+1} V_{i+1} = s'_{i+1},
///   θ_{i+1} = h Σ a_ij K_j,  V_{i+1} = v_0 + h Σ a_ij L_j,  K_i = dexp⁻¹_{-θ_i} V_i,
/// and the states of drives x_{i+1} = x_0 + h Σ a_ij F_j with their rates F_i. The stages are i = 1, 2, 3,
/// and the sums are over j = 1, ..., i. The first stage is the start of the step, with θ_1 = 0, V_1 = v_0 and
/// x_1 = x_0; θ_4, V_4 and x_4 are the results. s' are the rates of prescribed motions, 0 for all other rows.
/// Velocities satisfy the constraints; positions may violate them by O(h⁴) in a step, and are then projected.
///
/// System is the class of the mechanism. It must have the member functions of AbsoluteSimulationRun that are
/// called here.
template <class System> class HalfExplicit {
 public:
  using Vector = std::vector<double>;

  HalfExplicit(System& system, const Vector& q_0, const Vector& v_0)
      : q(q_0), v(v_0), system_(&system), group_(system.bodies().group()) {}

  /// Advances q, v and the states of the drives, which start at the present ones, from time t to t + h.
  Failure run(double t, double h) {
    static constexpr std::array<std::array<double, 3>, 3> a{{{1.0 / 3, 0, 0}, {-1, 2, 0}, {0, 0.75, 0.25}}};
    static constexpr std::array<double, 3> c{0, 1.0 / 3, 1};
    const std::size_t nv = v.size();
    DriveStates& drives = system_->drives();
    drive_states = drives.x;
    q_i_ = q;
    V_ = v;
    theta_.assign(nv, 0.0);
    q_next_.resize(q.size());
    for (std::size_t i = 0; i < 3; ++i) {
      if (i > 0)
        if (Failure failure = system_->factorize(t + c[i] * h, q_i_)) return failure;
      drives.act_at(as_span(drive_states));
      if (Failure failure = system_->forces(t + c[i] * h, q_i_, V_, f_)) return failure;
      F_[i] = as_eigen(drives.rates());
      system_->add_turning(V_, f_);
      K_[i].resize(nv);
      group_.rate(theta_, V_, K_[i]);
      theta_.assign(nv, 0.0);
      base_ = v;
      drive_states = drives.x;
      for (std::size_t j = 0; j <= i; ++j) drive_states += h * a[i][j] * F_[j];
      for (std::size_t j = 0; j <= i; ++j) as_eigen(theta_) += h * a[i][j] * as_eigen(K_[j]);
      for (std::size_t j = 0; j < i; ++j) as_eigen(base_) += h * a[i][j] * as_eigen(L_[j]);
      group_.move(q, theta_, q_next_);
      system_->set_time(t + (i == 0 ? c[1] : 1) * h);
      if (!accelerate(h * a[i][i], L_[i])) return {t + h, no_convergence};
      as_eigen(V_) = as_eigen(base_) + h * a[i][i] * as_eigen(L_[i]);
      q_i_ = q_next_;
    }
    q = q_i_;
    v = V_;
    return system_->close(t + h, q, v);
  }

  Vector q, v;
  Eigen::VectorXd drive_states;

 private:
  /// Computes by iteration the acceleration L of a stage with the configuration q_i_. With this L the
  /// velocity of the next stage, base_ + part L, satisfies the constraints at the configuration q_next_ of
  /// the next stage; `part` is the step length times a coefficient of the method (s). Returns whether the
  /// iteration converged.
  bool accelerate(double part, Vector& L) {
    auto& bodies = system_->bodies();
    L.assign(v.size(), 0.0);
    lambda_.assign(static_cast<std::size_t>(bodies.rows(ConstraintLevel::velocity)), 0.0);
    AndersonIteration iteration(system_->norm());
    for (;;) {
      as_eigen(V_) = as_eigen(base_) + part * as_eigen(L);
      bodies.velocity_residual(q_next_, V_, rhs_);
      as_eigen(rhs_) *= -1 / part;
      bodies.momentum(L, p_);
      r_ = f_;
      bodies.add_constraint_forces(q_i_, lambda_, r_);
      as_eigen(r_) -= as_eigen(p_);
      bodies.solve(r_, rhs_, dL_, dlambda_);
      const double size = system_->velocity_scale(V_, part) / std::abs(part);
      const auto status =
          iteration.update(size, {{as_eigen(L), as_eigen(dL_)}, {as_eigen(lambda_), as_eigen(dlambda_)}});
      if (status != AndersonIteration::Status::iterating)
        return status == AndersonIteration::Status::converged;
    }
  }

  System* system_;
  ConfigurationGroup<double> group_;
  std::array<Vector, 3> K_, L_;
  std::array<Eigen::VectorXd, 3> F_;
  Vector q_i_, q_next_, V_, theta_, base_, f_, p_, lambda_, rhs_, r_, dL_, dlambda_;
};

}  // namespace axode
