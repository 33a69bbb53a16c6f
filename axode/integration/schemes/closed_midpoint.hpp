#pragma once
#include <Eigen/Core>
#include <algorithm>

#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/schemes/anderson_iteration.hpp"
#include "axode/integration/schemes/midpoint.hpp"

namespace axode {

/// A step of the midpoint rule between two impulses that close loops, one at each end of the step (D8.7).
/// With the residuals r(q, t) of loops and prescribed motions, their Jacobian R, multipliers λ and μ, momenta
/// p, the mass matrix M, and the step length h,
///   p_0⁺ = p_0 + h/2 R(q_0)ᵀ λ,   (q_1, p_1⁻) = midpoint step of (q_0, p_0⁺),   r(q_1, t + h) = 0.
/// After the step the caller projects p_1 = p_1⁻ + R(q_1)ᵀ μ so that R M⁻¹ p_1 = s', with the rates s' of the
/// prescribed motions, 0 for loops. Then the method is symmetric, of second order, and symplectic on the
/// closed configurations if the midpoint rule is and the prescribed motions are constant.
///
/// System is the class of the mechanism. It must have the member functions of MomentumSimulationRun that are
/// called here and in Midpoint.
template <class System> class ClosedMidpoint {
 public:
  using Vector = Eigen::VectorXd;

  explicit ClosedMidpoint(System& system) : ClosedMidpoint(system, system.closed_model()) {}

  /// Computes the step of length h (s), which may be negative, from time t and the state (q0, p0), in which
  /// loops must be closed. Before the call, v must contain a first guess of the velocity in the middle of the
  /// step. The results are in the public members.
  Failure run(double t, double h, const Vector& q0, const Vector& p0) {
    LoopSystem<double>&ends = ends_.system(model_), &middle = middle_.system(model_);
    constexpr auto places = ConstraintLevel::position;
    ends.prescribe(system_->motion_rows(t));
    middle.prescribe(system_->motion_rows(t));
    if (Failure failure = system_->checked(t, ends.determine_rank(q0.data(), rank_))) return failure;
    middle.update_kinematics(q0.data());
    middle.set_filter(q0.data(), rank_);
    ends.make_rows(places);
    ends.write(R_.data());
    ends.prescribe(system_->motion_rows(t + h));
    advance(h / 2, q0, q_middle);
    middle.update_kinematics(q_middle.data());
    if (Failure failure = system_->checked(t, middle.factorize())) return failure;
    middle.make_rows(places);
    middle.factorize_rows();
    AndersonIteration iteration(system_->norm());
    for (auto status = AndersonIteration::Status::iterating;;) {
      advance(h / 2, q0, q_middle);
      p_0_ = p0 + h / 2 * (R_.transpose() * lambda_);
      group_.Ad_transpose(y_, p_0_, p);
      if (status == AndersonIteration::Status::converged) break;
      if (Failure failure = system_->partials(t + h / 2, q_middle, v, momenta_, f)) return failure;
      p += h * f;
      r_ = (p_0_ + p) / 2;
      group_.dexp_transpose(y_, r_, r_);
      r_ -= momenta_;
      const double scale = system_->velocity_scale(v, h);
      const double residual = system_->norm().of_forces(r_);
      group_.move_twice(q0, y_, q);
      ends.update_kinematics(q.data());
      ends.residual(q.data(), rhs_.data());
      rhs_ /= h;
      middle.add_response(r_.data(), rhs_.data());
      middle.solve_rows(rhs_.data(), dlambda_.data(), rank_);
      middle.add_transposed_times(dlambda_.data(), r_.data());
      middle.solve(r_.data());
      dlambda_ *= 2 / h;
      status = iteration.update(scale, {{v, r_}, {lambda_, dlambda_}},
                                [&] { return residual <= 1e-12 * terms(h, scale); });
      if (status == AndersonIteration::Status::diverged) return {t + h, no_convergence};
    }
    p += h * f;
    group_.Ad_transpose(y_, p, p);
    group_.move_twice(q0, y_, q);
    return {};
  }

  Vector q, q_middle, p, v, f;  ///< results of run(): q and p at the end of the step; q_middle, v and f in
                                ///< its middle

 private:
  ClosedMidpoint(System& system, const Model& model)
      : q(model.nq()),
        q_middle(model.nq()),
        p(model.nv()),
        v(model.nv()),
        f(model.nv()),
        system_(&system),
        model_(model),
        group_(model_.tree<double>(), system.local_coordinates()),
        ends_(model_),
        middle_(model_),
        R_(model.loops().residuals, model.nv()),
        lambda_(Vector::Zero(model.loops().residuals)),
        rhs_(lambda_),
        dlambda_(lambda_),
        y_(model.nv()),
        p_0_(model.nv()),
        momenta_(model.nv()),
        r_(model.nv()) {}

  /// Computes to = q_0 ⊕ y with y = part v.
  void advance(double part, const Vector& q0, Vector& to) {
    y_ = part * v;
    group_.move(q0, y_, to);
  }
  /// The norm of the largest term of the residual: momenta, forces, and the impulse of each loop row.
  double terms(double h, double scale) const {
    double most = std::max({system_->norm().of_forces(p_0_), system_->norm().of_forces(momenta_), scale});
    for (Eigen::Index row = 0; row < lambda_.size(); ++row)
      most =
          std::max(most, std::abs(h / 2 * lambda_[row]) * system_->norm().of_forces(R_.row(row).transpose()));
    return most;
  }

  System* system_;
  Model model_;
  ConfigurationGroup<double> group_;
  LoopWorkspace<double> ends_, middle_;
  RowRank rank_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> R_;
  Vector lambda_, rhs_, dlambda_, y_, p_0_, momenta_, r_;
};

}  // namespace axode
