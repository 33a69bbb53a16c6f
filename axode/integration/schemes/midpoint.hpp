#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/integration/schemes/anderson_iteration.hpp"
#include "axode/integration/schemes/step_matrix.hpp"
#include "axode/integration/trajectory.hpp"

namespace axode {

/// One step of the midpoint rule on the group for (q, p) (D8.5): with the forces f, the time t_m and the
/// velocity v in the middle, y = h v / 2 and q_m = q_0 ⊕ y,
///   p⁻ = Ad_{exp y}ᵀ p_0,   p⁺ = p⁻ + h f(t_m, q_m, v),   M(q_m) v = dexp_yᵀ (p_0 + p⁺) / 2,
///   q_1 = q_m ⊕ y,        p_1 = Ad_{exp y}ᵀ p⁺.
/// The step is symmetric and of second order, and symplectic if f = ∂L/∂q, because it follows from the
/// discrete Lagrangian h L(q_m, v). Forces that depend on v enter by d'Alembert's discrete principle. With
/// Cayley's map the step is (D14.9).
///
/// The iteration for v uses M, factorised once, and then Newton's matrix (D8.6) if the residual r of the
/// equation for M(q_m) v has not halved in an iteration. It has converged if the change of v is a rounding
/// error, or if r is a rounding error of its terms, as it becomes even for nearly singular M. With a stiff
/// drive at rest, it has also converged if the change of v moves q by no more than the rounding error of q.
///
/// System is the class of the mechanism, for example a SimulationRun. Its member functions are partials(t, q,
/// v, p, f), which computes p = M v and f; factorize(t, q) and solve(x) with M; norm(), the EnergyNorm of
/// velocities; velocity_scale(v, h), the size of the terms of v in a step of length h; place_resolution(h),
/// the velocity that moves q by its rounding error in a step; and those that StepMatrix requires.
template <class System> class Midpoint {
 public:
  using Vector = Eigen::VectorXd;

  Midpoint(System& system, const Tree<double>& tree)
      : q(tree->nq),
        q_middle(tree->nq),
        p(tree->nv),
        v(tree->nv),
        f(tree->nv),
        system_(&system),
        group_(tree, system.local_coordinates()),
        matrix_(system, tree),
        y_(tree->nv),
        momenta_(tree->nv),
        r_(tree->nv),
        none_(Vector::Zero(tree->nv)) {}

  /// Computes the step from (q0, p0) at time t over h, which may be negative; v must contain a first guess.
  /// The results are in the public members.
  Failure run(double t, double h, const Vector& q0, const Vector& p0) {
    constexpr int most = 60;
    const EnergyNorm& norm = system_->norm();
    const double terms = norm.of_forces(p0);
    bool newton = false;
    double before = std::numeric_limits<double>::infinity(), scale = 0;
    for (int iteration = 0; iteration < most; ++iteration) {
      y_ = h / 2 * v;
      group_.move(q0, y_, q_middle);
      if (iteration == 0)
        if (Failure failure = system_->factorize(t + h / 2, q_middle)) return failure;
      if (Failure failure = system_->partials(t + h / 2, q_middle, v, momenta_, f)) return failure;
      group_.Ad_transpose(y_, p0, p);
      p += h * f;
      r_ = (p0 + p) / 2;
      group_.dexp_transpose(y_, r_, r_);
      r_ = momenta_ - r_;
      if (iteration == 0) scale = system_->velocity_scale(v, h);
      const double residual = norm.of_forces(r_);
      if (newton)
        matrix_.solve(r_);
      else
        system_->solve(r_);
      v -= r_;
      const bool slow = !(residual < 0.5 * before);
      const double change = norm.of_velocities(r_);
      if (change <= 1e-13 * scale || residual <= (slow ? 1e-13 : 1e-14) * std::max(terms, scale) ||
          (newton && slow && change <= system_->place_resolution(h))) {
        // q and p must be advanced with the same v, otherwise momenta would not be conserved.
        y_ = h / 2 * v;
        group_.Ad_transpose(y_, p0, p);
        p += h * f;
        group_.Ad_transpose(y_, p, p);
        group_.move_twice(q0, y_, q);
        return {};
      }
      before = residual;
      if (!slow) continue;
      newton = true;
      before = std::numeric_limits<double>::infinity();
      matrix_.compute_with_drive(t + h / 2, q0, y_, q_middle, v, none_, h * h / 4, h / 2);
    }
    return {t + h, no_convergence};
  }

  Vector q, q_middle, p, v, f;  ///< results of run(): q and p at the end of the step; q_middle, v and f in
                                ///< its middle

 private:
  System* system_;
  ConfigurationGroup<double> group_;
  StepMatrix<System> matrix_;
  Vector y_, momenta_, r_, none_;
};

}  // namespace axode
