#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <limits>

#include "axode/integration/schemes/step_matrix.hpp"
#include "axode/integration/trajectory.hpp"

namespace axode {

/// The equations of the generalised-α method for a step of length h from (q_0, v_0, a_0) to (q_1, v_1, a_1),
/// with the auxiliary acceleration of the method, â_0 at the start and â_1 at the end, and the parameters
/// α_m, α_f, β and γ:
///   (1 - α_m) â_1 + α_m â_0 = (1 - α_f) a_1 + α_f a_0,   v_1 = v_0 + h ((1 - γ) â_0 + γ â_1),
///   x = h v_0 + h² ((1/2 - β) â_0 + β â_1),   q_1 = q_0 ⊕ x.
/// With c = (1 - α_f) / (1 - α_m), the derivatives by a_1 are h γ c for v_1 and h² β c for x.
struct AlphaMeans {
  using Vector = Eigen::VectorXd;

  double a_f, a_m, gamma, beta, c;

  explicit AlphaMeans(double spectral_radius)
      : a_f(spectral_radius / (spectral_radius + 1)),
        a_m((2 * spectral_radius - 1) / (spectral_radius + 1)),
        gamma(0.5 + a_f - a_m),
        beta((gamma + 0.5) * (gamma + 0.5) / 4),
        c((1 - a_f) / (1 - a_m)) {}

  /// Computes â_1, v_1 and x of a step of length h from v_0, a_0 and â_0 with the new acceleration a_1.
  void advance(double h, const auto& v_0, const Vector& a_0, const Vector& mean_0, const auto& a_1,
               Vector& mean_1, auto& v_1, Vector& x) const {
    mean_1 = (a_f * a_0 - a_m * mean_0) / (1 - a_m) + c * a_1;
    v_1 = v_0 + h * ((1 - gamma) * mean_0 + gamma * mean_1);
    x = h * v_0 + h * h * ((0.5 - beta) * mean_0 + beta * mean_1);
  }
};

/// One step of the generalised-α method on the group, from (q_0, v_0, a_0) to (q_1, v_1, a_1) with q_1 = q_0
/// ⊕ x. Newton's method, with the matrix StepMatrix, finds the a_1 for which the residual r(q_1, v_1, a_1) of
/// the equations of motion is 0. It has converged if the change of a_1 is a rounding error or moves q_1 by no
/// more than the rounding error of q_1, or if r is a rounding error of its terms.
///
/// System is the class of the mechanism. It must have the member functions of SimulationRun that are called
/// here and in StepMatrix.
template <class System> class GeneralizedAlpha {
 public:
  using Vector = Eigen::VectorXd;

  GeneralizedAlpha(System& system, const Tree<double>& tree, double spectral_radius, const Vector& a_0)
      : q(tree->nq),
        v(tree->nv),
        a(a_0),
        system_(&system),
        group_(tree, system.local_coordinates()),
        matrix_(system, tree),
        means_(spectral_radius),
        mean_0_(a_0),
        mean_(tree->nv),
        x_(tree->nv),
        r_(tree->nv) {}

  /// Computes the step from (q0, v0, a0) over h. q, v and a receive the state at its end, which is at time t.
  Failure run(double t, double h, const Vector& q0, const Vector& v0, const Vector& a0) {
    constexpr int most = 40;
    const EnergyNorm& norm = system_->norm();
    a = a0;
    double before = std::numeric_limits<double>::infinity();
    for (int iteration = 0; iteration < most; ++iteration) {
      end_with(h, q0, v0, a0);
      if (Failure failure = system_->residual(t, q, v, a, r_)) return failure;
      if (iteration == 0) linearize(t, h, q0);
      const double size = std::max(system_->velocity_scale(v, h) / h, norm.of_velocities(a));
      da_ = r_;
      matrix_.solve(da_);
      const double change = norm.of_velocities(da_);
      if (!(change < 0.1 * before)) {
        const bool rests = with_drive_ && h * change <= system_->place_resolution(h);
        if (rests || system_->size_of_residual(r_) <= 1e-13 * size) return {};
        with_drive_ = true;
        linearize(t, h, q0);
        da_ = r_;
        matrix_.solve(da_);
      }
      a -= da_;
      if (change <= 1e-13 * size) {
        end_with(h, q0, v0, a0);
        return {};
      }
      before = change;
    }
    return {t, "Newton's method did not converge; a shorter step may help"};
  }
  /// accept() stores the auxiliary acceleration â of the generalised-α method at the end of the step, with
  /// which the next step starts. restart() replaces it by the accelerations a_0; it must be called after a
  /// jump of the accelerations.
  void accept() { mean_0_ = mean_; }
  void restart(const Vector& a_0) { mean_0_ = a_0; }

  Vector q, v, a;  ///< results of run(): the state at the end of the step

 private:
  /// Computes q, v and the auxiliary acceleration â at the end of the step for the acceleration a.
  void end_with(double h, const Vector& q0, const Vector& v0, const Vector& a0) {
    means_.advance(h, v0, a0, mean_0_, a, mean_, v, x_);
    group_.move(q0, x_, q);
  }
  /// Computes Newton's matrix; derivatives of SimulationOptions::drive are added after slow convergence.
  void linearize(double t, double h, const Vector& q0) {
    const double c_x = h * h * means_.beta * means_.c, c_v = h * means_.gamma * means_.c;
    if (with_drive_)
      matrix_.compute_with_drive(t, q0, x_, q, v, a, c_x, c_v);
    else
      matrix_.compute(x_, q, v, a, c_x, c_v);
  }

  System* system_;
  ConfigurationGroup<double> group_;
  StepMatrix<System> matrix_;
  AlphaMeans means_;
  Vector mean_0_, mean_, x_, r_, da_;
  bool with_drive_ = false;
};

}  // namespace axode
