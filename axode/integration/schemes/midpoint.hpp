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
/// equation for M(q_m) v has not halved in an iteration. If M is already factorised at q_0, it is used first;
/// if the residual then falls, but does not halve, M at q_m replaces it. The iteration has converged if the
/// next change of v would be a rounding error, or if r is a rounding error of its terms. With a stiff drive
/// at rest, it has also converged if the change of v moves q by no more than the rounding error of q.
///
/// System is the class of the mechanism. It must have the member functions of MomentumSimulationRun that are
/// called here and in StepMatrix.
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

  /// Computes the step of length h, which may be negative, from the coordinates q0 and the momenta p0 at time
  /// t. Before the call the member v must contain a first guess of the velocity in the middle of the step.
  /// The results are in the public members.
  Failure run(double t, double h, const Vector& q0, const Vector& p0) {
    matrix_in_use_ = system_->is_factorized_at(q0) ? MatrixKind::masses_at_start : MatrixKind::none;
    return iterate(t, h, q0, p0, 0, 0.5);
  }
  /// Computes the step of length h from (q0, p0) at time t with fewer factorisations than run(). The
  /// iteration for the velocity v in the middle of the step begins with the factorised mass matrix or
  /// Newton's matrix that the last call used or, if h has changed, with the mass matrix. Newton's matrix is
  /// computed if the residual of the equation for v does not fall to a tenth in an iteration. The iteration
  /// ends when the change of v is at most `enough` times the magnitude of the velocities; is_exact() says
  /// whether v is then exact to rounding.
  Failure run_again(double t, double h, const Vector& q0, const Vector& p0, double enough) {
    if (h != h_) matrix_in_use_ = MatrixKind::none;
    h_ = h;
    return iterate(t, h, q0, p0, enough, 0.1);
  }
  bool is_exact() const { return exact_; }
  /// Prepares run_again() for a new step. If run_again() iterates with factors of Newton's matrix, they are
  /// computed anew only if the last iteration with them converged slowly. Factors of the mass matrix are
  /// always computed anew, because the mechanism (System), which stores them, may have replaced them by those
  /// at another configuration.
  void renew_matrix() noexcept {
    renew_ = slowest_ > 0.02;
    if (matrix_in_use_ == MatrixKind::masses) matrix_in_use_ = MatrixKind::none;
  }
  /// Takes over the matrix with which another motion of the same mechanism iterates.
  void continue_from(const Midpoint& other) {
    matrix_in_use_ = other.matrix_in_use_;
    h_ = other.h_;
    slowest_ = other.slowest_;
    rate_ = other.rate_;
    if (matrix_in_use_ == MatrixKind::newton) matrix_.continue_from(other.matrix_);
  }
  /// Forgets the matrix of earlier runs.
  void forget_matrix() noexcept { matrix_in_use_ = MatrixKind::none; }
  /// Adds to v, the velocity in the middle of the step, an estimate x of the change of v if p0, the momenta
  /// at the start of the step, change by dp, for the next call of run_again(). x solves A x = dp with the
  /// matrix A of the last iteration, the mass matrix or Newton's matrix. Overwrites dp with x. Requires an
  /// earlier call of run() or run_again().
  void follow(Vector& dp) {
    solve(dp);
    v += dp;
  }
  /// The inertia that springs, dampers and drives seem to add to each velocity in a step of length h (nv
  /// numbers, kg m² or kg): the diagonal of Newton's matrix minus that of the mass matrix, or 0 where this
  /// difference is negative. Newton's matrix (D8.6) approximates the derivative of the equations of the step
  /// by the velocity in its middle, and contains the derivatives of the forces of springs, dampers and
  /// drives. Null if the last call of run_again(), which computes a step, had another step length than h or
  /// iterated only with the mass matrix.
  const double* resistance(double h) const {
    return matrix_in_use_ == MatrixKind::newton && h == h_ ? matrix_.resistance().data() : nullptr;
  }

  Vector q, q_middle, p, v, f;  ///< results of run(): q and p at the end of the step; q_middle, v and f in
                                ///< its middle

 private:
  /// The matrix of the iteration: the mass matrix in the middle of the step or at its start, or Newton's.
  enum class MatrixKind { none, masses_at_start, masses, newton };

  /// Iterates for v with the matrix in use: the mass matrix, or Newton's matrix from an earlier call. If the
  /// residual does not fall to the part `least` of itself in an iteration, Newton's matrix is computed at the
  /// present v and replaces the matrix in use. From then on it is computed again only if the residual does
  /// not halve in an iteration.
  Failure iterate(double t, double h, const Vector& q0, const Vector& p0, double enough, double least) {
    constexpr int most = 60;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const EnergyNorm& norm = system_->norm();
    const double terms = norm.of_forces(p0);
    const bool renew = renew_ && matrix_in_use_ == MatrixKind::newton;
    renew_ = false;
    slowest_ = 0;
    double before = infinity, scale = 0;
    for (int iteration = 0; iteration < most; ++iteration) {
      y_ = h / 2 * v;
      group_.move(q0, y_, q_middle);
      if (matrix_in_use_ == MatrixKind::none) {
        if (Failure failure = system_->factorize(t + h / 2, q_middle)) return failure;
        matrix_in_use_ = MatrixKind::masses;
        rate_ = 1;
      }
      if (Failure failure = system_->partials(t + h / 2, q_middle, v, momenta_, f)) return failure;
      if (iteration == 0 && renew) {
        compute_matrix(t, h, q0);
        least = 0.5;
      }
      group_.Ad_transpose(y_, p0, p);
      p += h * f;
      r_ = (p0 + p) / 2;
      group_.dexp_transpose(y_, r_, r_);
      r_ = momenta_ - r_;
      if (iteration == 0) scale = system_->velocity_scale(v, h);
      const double residual = norm.of_forces(r_);
      solve(r_);
      v -= r_;
      const bool newton = matrix_in_use_ == MatrixKind::newton, slow = !(residual < least * before);
      const double change = norm.of_velocities(r_);
      // The ratio of residuals is known as long as they are more than rounding errors.
      if (newton && before < infinity && before > 1e-8 * std::max(terms, scale))
        rate_ = std::max(residual / before, 1e-3);
      const double next_change = rate_ < 0.1 ? rate_ * change : change;
      exact_ = next_change <= 1e-13 * scale || residual <= (slow ? 1e-13 : 1e-14) * std::max(terms, scale) ||
               (newton && slow && change <= system_->place_resolution(h));
      if (exact_ || change <= enough * scale) {
        // q and p must be advanced with the same v, otherwise momenta would not be conserved.
        y_ = h / 2 * v;
        group_.Ad_transpose(y_, p0, p);
        p += h * f;
        group_.Ad_transpose(y_, p, p);
        group_.move_twice(q0, y_, q);
        return {};
      }
      slowest_ = std::max(slowest_, residual / before);
      const bool diverges = !(residual < before);
      before = slow ? infinity : residual;
      if (!slow) continue;
      if (matrix_in_use_ == MatrixKind::masses_at_start && !diverges) {
        matrix_in_use_ = MatrixKind::none;
        continue;
      }
      compute_matrix(t, h, q0);
      least = 0.5;
    }
    return {t + h, no_convergence};
  }
  /// Computes Newton's matrix at q_middle = q0 ⊕ y_.
  void compute_matrix(double t, double h, const Vector& q0) {
    matrix_in_use_ = MatrixKind::newton;
    rate_ = 1;
    matrix_.compute_with_drive(t + h / 2, q0, y_, q_middle, v, none_, h * h / 4, h / 2);
  }
  /// Replaces x by the solution for the matrix in use.
  void solve(Vector& x) {
    if (matrix_in_use_ == MatrixKind::newton)
      matrix_.solve(x);
    else
      system_->solve(x);
  }

  System* system_;
  ConfigurationGroup<double> group_;
  StepMatrix<System> matrix_;
  Vector y_, momenta_, r_, none_;
  MatrixKind matrix_in_use_ = MatrixKind::none;
  double h_ = 0;        ///< length of the last run_again()
  double slowest_ = 0;  ///< the largest ratio of successive residuals in the last run
  double rate_ = 1;     ///< the last known ratio of successive residuals with Newton's matrix, or 1
  bool renew_ = false, exact_ = false;
};

}  // namespace axode
