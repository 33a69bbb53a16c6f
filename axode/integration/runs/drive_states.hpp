#pragma once
#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "axode/drives/drive_system.hpp"
#include "axode/integration/trajectory.hpp"

namespace axode {

/// The states of the drives of a motion during its integration. Evaluations of forces take place at the
/// states that act_at() was called with last or, in an implicit step, at those that the step has at its end.
class DriveStates {
 public:
  using Vector = Eigen::VectorXd;
  using Span = std::span<const double>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  explicit DriveStates(DriveSystem system);

  /// The drives with their statuses and inputs.
  const DriveSystem& system() const { return system_; }
  bool empty() const { return system_.empty(); }
  std::size_t size() const { return system_.nx(); }
  const Vector& nominal() const { return nominal_; }
  std::vector<std::string> names() const;

  /// Chooses x, unless it is given, and the statuses at the start of a motion at time 0. Throws
  /// std::invalid_argument for a given x of a wrong size or with a number that is not finite.
  void start(Span q, Span v, Span given);
  /// Sets the states at which the drives act from now on.
  void act_at(Span x_t);
  /// Begins a step of generalised-α over h (D17.6). Until act_at(), the states of every evaluation are those
  /// that belong to its q and v at the end of the step.
  void begin_implicit_step(double h, double spectral_radius);
  /// The states at the last evaluation of forces.
  Span states() const { return {x_t_.data(), size()}; }
  /// Accepts the implicit step, or begins anew after a jump.
  void accept_implicit_step();
  void restart() { mean_0_ = dx; }
  /// Adds the derivatives of the drive forces by q and v, nv × nv, at the last evaluation to out. In an
  /// implicit step they contain those of the states (D17.7).
  void add_force_derivatives(Span q, Span v, Eigen::Ref<Matrix> by_q, Eigen::Ref<Matrix> by_v);
  /// Adds the drive forces to tau, and computes rates().
  void add_forces(double t, Span q, Span v, std::span<double> tau);
  /// Adds to tau the part of these forces that acts along lines, at the last evaluation of forces.
  void add_line_forces(std::span<double> tau) const { system_.add_line_forces(tau); }
  /// The rates of the states at the last evaluation of forces.
  Span rates() const { return {dx_t_.data(), size()}; }
  /// The name of the first state whose rate is not finite, if there is one.
  std::string first_not_finite() const;

  double next_jump(double t) const { return system_.next_jump(t); }
  double least_margin(double t, Span q, Span v, Span x_t) { return system_.least_margin(t, q, v, x_t); }
  /// DriveSystem::switch_at() for the present states.
  bool switch_at(double t, Span q, Span v);

  Vector x, dx;  ///< present states and their rates

 private:
  void solve_states(double t, Span q, Span v);

  DriveSystem system_;
  Vector nominal_, x_t_, dx_t_;
  // In an implicit step x_1 = base_ + kappa_ f(x_1, ...). The mean rates are those of generalised-α.
  double kappa_ = 0, c_x_ = 0, t_ = 0;
  Vector base_, mean_0_, old_mean_;
};

}  // namespace axode
