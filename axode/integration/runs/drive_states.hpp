#pragma once
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "axode/drives/drive_system.hpp"
#include "axode/integration/trajectory.hpp"
#include "axode/recursion/decompositions.hpp"

namespace axode {

/// The states of the drives of a motion during its integration. Forces are evaluated with the drive states
/// that were set last or, in an implicit step, with those that solve the equation of the step.
class DriveStates {
 public:
  using Vector = Eigen::VectorXd;
  using Span = std::span<const double>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  explicit DriveStates(DriveSystem system);

  /// The drives with their present statuses and inputs.
  const DriveSystem& system() const { return system_; }
  bool empty() const { return system_.empty(); }
  std::size_t size() const { return system_.nx(); }
  const Vector& nominal() const { return nominal_; }
  std::vector<std::string> names() const;

  /// Sets the states x of the drives at time t, the start of a motion, and their statuses, the integers that
  /// say which form of each drive's law holds. If `given` is empty, the drives choose x. Throws
  /// std::invalid_argument for a wrong size or a number that is not finite.
  void start(double t, Span q, Span v, Span given);
  /// Sets the states with which forces are evaluated from now on, and ends an implicit step.
  void act_at(Span x_t);
  /// Begins an implicit step of length h of the generalised-α method (D17.6) from the present drive states.
  /// Until act_at() sets the drive states, every evaluation of forces at a (q, v) assumes that this is the
  /// state of the mechanism at the end of the step, and solves for the drive states there.
  void begin_implicit_step(double h, double spectral_radius);
  /// Begins a step of length h of the implicit midpoint rule from the drive states x_0 (D17.7a). Until
  /// act_at() sets the drive states, every evaluation of forces at a (q, v) assumes that this is the state of
  /// the mechanism in the middle of the step, and solves for the drive states x_m there.
  void begin_midpoint_step(double h, const Vector& x_0);
  /// Begins a step of length h of the trapezoidal rule (D17.7a) from the drive states and rates in the last
  /// evaluation of forces. Until act_at() sets the drive states, every evaluation of forces at a (q, v)
  /// assumes that this is the state of the mechanism at the end of the step, and solves for the drive states
  /// there.
  void begin_trapezoidal_step(double h) { begin_stage(h / 2, x_t_ + h / 2 * dx_t_, x_t_); }
  /// Computes the states x_1 = 2 x_m - x_0 of the drives at the end of a step of the midpoint rule, from the
  /// states x_0 at its start and x_m in its middle. x_1 may have the memory of x_0.
  void end_midpoint_step(Vector& x_1) const { x_1 = 2 * x_t_ - base_; }
  /// Computes the states x_1 at the end of a step of length h from x_0 at time t, in which the mechanism has
  /// the state (q_s, v_s) at t + stage h and (q_1, v_1) at t + h, by the L-stable method of two implicit
  /// stages (D17.7b). x_1 may have the memory of x_0.
  void take_two_stages(double t, double h, const Vector& x_0, Span q_s, Span v_s, Span q_1, Span v_1,
                       Vector& x_1);
  /// Whether a step backwards in time (h < 0) is too long for the drives: whether |h σ| > 1 for an eigenvalue
  /// σ of ∂x'/∂x, the derivative of the rates of the drive states by these states (1/s). The midpoint rule
  /// and the trapezoidal rule have a pole at h σ = 2.
  bool too_fast(double h) const;
  static constexpr const char* runs_backwards =
      "states of drives change too fast for those parts of the step in which time runs backwards; use a "
      "shorter step, or a method of order 2";
  /// The fraction s = 1 - 1/√2 of the L-stable method with two implicit stages, see take_two_stages(). In a
  /// step of length h from time t, its first stage is at t + s h and its second one at t + h (D17.7b).
  static constexpr double stage = 1 - 0.5 * std::numbers::sqrt2;
  /// The states in the last evaluation of forces.
  Span states() const { return {x_t_.data(), size()}; }
  /// The generalised-α method starts each step with an auxiliary variable ŵ, a mean of rates of the drive
  /// states (D17.6). accept_implicit_step() stores the ŵ at the end of a step for the next one. restart()
  /// sets ŵ to the present rates of the drive states, at the start of a motion and after a jump of
  /// accelerations.
  void accept_implicit_step();
  void restart() { mean_0_ = dx; }
  /// Adds the derivatives of the drive forces by q and v at the last evaluation to by_q and by_v (nv × nv).
  /// In an implicit step they include the dependence of the drive states on q and v (D17.7).
  void add_force_derivatives(Span q, Span v, Eigen::Ref<Matrix> by_q, Eigen::Ref<Matrix> by_v);
  /// Evaluates the drives at time t and state (q, v): adds their forces to tau (nv), and computes rates().
  void add_forces(double t, Span q, Span v, std::span<double> tau);
  /// Adds to tau the last forces of drives along lines between two points, which add_forces() also adds.
  void add_line_forces(std::span<double> tau) const { system_.add_line_forces(tau); }
  /// The rates of the states in the last evaluation of forces.
  Span rates() const { return {dx_t_.data(), size()}; }
  /// The name of the first state whose rate is not finite, if there is one.
  std::string first_not_finite() const;

  double next_jump(double t) const { return system_.next_jump(t); }
  double least_margin(double t, Span q, Span v, Span x_t) { return system_.least_margin(t, q, v, x_t); }
  /// Applies jumps of inputs and changes of statuses that are due at time t. Returns whether there was one.
  bool switch_at(double t, Span q, Span v);
  /// Whether the change of statuses that is due at the end of a step alters a drive state, or its rate times
  /// h, by more than 1e-9 of the size of the state. A status is the integer that says which form of a drive's
  /// law holds. The step has the length h and ends at time t in the state (q_1, v_1) of the mechanism with
  /// the drive states x_1. Writes the change of the drive forces to dtau (nv numbers).
  bool jumps_at(double t, double h, Span q_1, Span v_1, const Vector& x_1, Vector& dtau);

  Vector x, dx;  ///< present states and their rates

 private:
  void begin_stage(double kappa, const Vector& base, const Vector& guess);
  void solve_states(double t, Span q, Span v);
  void factorize_stage(const Eigen::MatrixXd& f_x);

  DriveSystem system_;
  Vector nominal_, x_t_, dx_t_;
  // In an implicit step x_1 = base_ + kappa_ f(x_1, ...). The mean rates are those of generalised-α.
  double kappa_ = 0, c_x_ = 0, t_ = 0;
  Vector base_, mean_0_, old_mean_;
  Eigen::MatrixXd f_x_;  ///< ∂x'/∂x in the last evaluation of an implicit step
  // Memory of solve_states(), take_two_stages(), add_force_derivatives() and jumps_at().
  Eigen::MatrixXd stage_matrix_;
  LuFactor lu_;
  Vector residual_, change_, start_, rates_;
  DriveDerivatives by_;
  std::vector<std::size_t> discrete_;  ///< of the drives, in jumps_at()
};

}  // namespace axode
