#pragma once
#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "axode/constraints/absolute/absolute_system.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/runs/simulation_run.hpp"
#include "axode/integration/schemes/anderson_iteration.hpp"
#include "axode/model/finite.hpp"

namespace axode {

/// A motion that is integrated in absolute coordinates: q are the poses of the bodies, and v and a are the
/// velocities and accelerations of the bodies. The trajectory contains joint coordinates, joint velocities
/// and joint accelerations instead.
class AbsoluteSimulationRun {
 public:
  using Vector = std::vector<double>;
  using Span = std::span<const double>;

  AbsoluteSimulationRun(const Model& model, Span q_0, Span v_0, double until,
                        const SimulationOptions& options)
      : run_(model, q_0, v_0, until, options),
        trajectory(run_.trajectory),
        bodies_(run_.closed_model(), group_of(options.coordinates)),
        group_(bodies_.group()),
        norm_(inertia_of(bodies_)) {
    if (run_.done()) return;
    bodies_.from_joint_state(q_0, v_0, q, v);
    a.resize(v.size());
    record_residuals();
    Failure failure = factorize_with_rank(0, q);
    if (!failure) failure = accelerate(0, q, v, a);
    if (failure) stop(failure);
  }
  AbsoluteSimulationRun(const AbsoluteSimulationRun&) = delete;

 private:
  SimulationRun run_;

 public:
  Trajectory& trajectory;
  Vector q, v, a, lambda;  ///< present state, accelerations and multipliers

  AbsoluteSystem& bodies() { return bodies_; }
  const Tree<double>& tree() const { return bodies_.group(); }
  LocalCoordinates local_coordinates() const { return run_.local_coordinates(); }
  ConfigurationGroup<double> group() const { return ConfigurationGroup<double>(tree(), local_coordinates()); }
  DriveStates& drives() { return run_.drives(); }
  bool is_driven_in_time() const { return run_.is_driven_in_time(); }
  bool done() const { return run_.done(); }
  double now() const { return run_.now(); }
  double step_end(double t_1) const { return run_.step_end(t_1); }
  void stop(const Failure& failure) { run_.stop(failure); }
  const EnergyNorm& norm() const { return norm_; }
  /// The scale with which rounding errors of velocities are compared, for a step of length h (s). It is the
  /// largest of three numbers: the norm of the velocities `v_t` of the bodies, the norm of the velocities
  /// that gravity or the joint forces cause in the time h, and 1e-8 times the norm of the joint coordinates,
  /// divided by h, so that the scale is not 0 at rest. All are energy norms √Σ m_c x_c², with a constant
  /// inertia m_c for each velocity.
  double velocity_scale(const Vector& v_t, double h) const {
    return std::max(norm_.of_velocities(as_eigen(v_t)), run_.velocity_scale(h));
  }

  // The schemes in absolute coordinates call the functions set_time() to take_closed().
  /// Sets the time (s) at which residuals and biases follow the prescribed motions.
  void set_time(double t) { bodies_.prescribe(run_.motion_rows(t)); }
  Failure factorize(double t, Span q_t) { return checked(t, bodies_.factorize(q_t)); }
  Failure factorize_with_rank(double t, Span q_t) { return checked(t, bodies_.factorize_with_rank(q_t)); }
  /// Factorises the mass matrix and the constraints at time t, configuration q_t and velocities v_t, which
  /// are an iterate of the end of an implicit step. The mass matrix includes the inertia that springs,
  /// dampers and drives seem to add in this step, in which a change x of accelerations changes q by c_x x and
  /// v by c_v x.
  Failure factorize(double t, Span q_t, Span v_t, double c_x, double c_v) {
    bodies_.to_joint_state(q_t, v_t, q_joints_, v_joints_);
    if (Failure failure = run_.joint_resistance(t, q_joints_, v_joints_, c_x, c_v, resistance_))
      return failure;
    return checked(t, bodies_.factorize(q_t, resistance_));
  }
  Failure forces(double t, Span q_t, Span v_t, Vector& f) {
    if (!finite(q_t) || !finite(v_t)) return {t, "the state is not finite"};
    bodies_.to_joint_state(q_t, v_t, q_joints_, v_joints_);
    Span tau;
    if (Failure failure = run_.joint_forces(t, q_joints_, v_joints_, tau)) return failure;
    bodies_.forces(q_t, v_t, tau, run_.loads(), f);
    return {};
  }
  /// Adds ad_vᵀ M v to f.
  void add_turning(Span v_t, Vector& f) {
    bodies_.momentum(v_t, p_);
    group_.ad_transpose(v_t, p_, p_);
    as_eigen(f) += as_eigen(p_);
  }
  Failure accelerate(double t, Span q_t, Span v_t, std::span<double> a_t) {
    if (Failure failure = forces(t, q_t, v_t, f_)) return failure;
    if (Failure failure = factorize(t, q_t)) return failure;
    add_turning(v_t, f_);
    set_time(t);
    bodies_.bias(v_t, rows_);
    bodies_.solve(f_, rows_, x_, lambda);
    weakest_row_ = std::min(weakest_row_, bodies_.weakest_row());
    std::ranges::copy(x_, a_t.begin());
    return finite(x_) ? Failure{} : Failure{t, "accelerations are not finite"};
  }
  /// Corrects q_1 and v_1 at time t (s) so that joints and loops are closed and prescribed motions are
  /// followed. With the mass matrix M, the change x of v_1 has the least norm √(xᵀ M x) among all changes
  /// that remove the residual of velocities. So has each Newton step x for q_1, which removes the residual of
  /// positions to first order. Returns an error if the residual of positions (rad, m) stays above 1e-6. On
  /// success the mass matrix and the constraints are factorised at the new q_1.
  Failure close(double t, Vector& q_1, Vector& v_1) {
    constexpr double rounding = 1e-13, tolerable = 1e-6;
    set_time(t);
    double before = position_error(q_1);
    if (!(before <= rounding))
      if (Failure failure = checked(t, bodies_.factorize(q_1, ConstraintLevel::position))) return failure;
    for (int n = 0; n < 10 && !(before <= rounding); ++n) {
      project();
      group_.move(q_1, x_, q_1);
      const double now = position_error(q_1);
      const bool stalled = !(now < 0.5 * before);  // stopped by rounding, or because joints and loops cannot
                                                   // be closed
      before = now;
      if (stalled) break;
    }
    if (!(before <= tolerable)) return {t, "joints and loops do not stay closed; use a shorter step"};
    if (Failure failure = factorize_with_rank(t, q_1)) return failure;
    bodies_.velocity_residual(q_1, v_1, rows_);
    project();
    as_eigen(v_1) += as_eigen(x_);
    return {};
  }
  /// Projects the state at the end of a step onto closed joints and loops, and appends it to the trajectory.
  /// If the law of a drive changes its form within the step, for example at a limit, the function first
  /// shortens the step: it searches for the time of the change, and computes the state at this time by
  /// `attempt`, a callback that computes the state at the end of a step to a given time.
  Failure take_up_to(double t_1, StepEnd& end, const Attempt& attempt) {
    if (!drives().empty())
      if (Failure failure = end_at_switch(t_1, end, attempt)) return failure;
    Vector q_1(end.q.begin(), end.q.end()), v_1(end.v.begin(), end.v.end());
    if (Failure failure = close(t_1, q_1, v_1)) return failure;
    if (Failure failure = take_closed(t_1, q_1, v_1, end.x)) return failure;
    if (done()) return {};
    if (Failure failure = run_.switch_drives()) return failure;
    return accelerate(t_1, q, v, a);
  }
  /// Lets the statuses and inputs of the drives change at the present time, and computes accelerations anew.
  Failure switch_drives() {
    if (Failure failure = run_.switch_drives()) return failure;
    return accelerations_jumped() ? accelerate(now(), q, v, a) : Failure{};
  }
  /// Whether accelerations jumped at the end of the last step.
  bool accelerations_jumped() const { return run_.accelerations_jumped(); }
  void begin_step() { weakest_row_ = 1; }
  double weakest_row() const { return weakest_row_; }
  /// Appends the state at the end of a step, with the states x_end of the drives, to the trajectory. The
  /// state is not projected, so that it must already obey the constraints of joints and loops.
  Failure take_closed(double t, Span q_end, Span v_end, const Eigen::VectorXd& x_end) {
    bodies_.to_joint_state(q_end, v_end, q_joints_, v_joints_);
    bodies_.set_reference_angles(q_joints_);
    q.assign(q_end.begin(), q_end.end());
    v.assign(v_end.begin(), v_end.end());
    const std::size_t before = trajectory.size();
    Failure failure = run_.take_closed(t, q_joints_, v_joints_, x_end);
    if (trajectory.size() > before) record_residuals();
    return failure;
  }

 private:
  static BodyGroup group_of(Coordinates coordinates) {
    if (coordinates == Coordinates::absolute) return BodyGroup::SE3;
    return coordinates == Coordinates::absolute_SO3xR3 ? BodyGroup::SO3xR3 : BodyGroup::by_joint;
  }
  Failure checked(double t, const Solvability& how) {
    return how.ok() ? Failure{} : Failure{t, to_string(trajectory.model(), how)};
  }
  /// Shortens a step in which a status of a drive must change, as SimulationRun::end_at_switch() does.
  Failure end_at_switch(double& t_1, StepEnd& end, const Attempt& attempt) {
    const auto in_joints = [&] {
      bodies_.to_joint_state(as_span(end.q), as_span(end.v), q_joints_, v_joints_);
      return StepEnd{.q = as_eigen(q_joints_), .v = as_eigen(v_joints_), .x = end.x};
    };
    const Attempt attempt_in_joints = [&](double t, StepEnd& joints) {
      Failure failure = attempt(t, end);
      if (!failure) joints = in_joints();
      return failure;
    };
    const double whole = t_1;
    StepEnd joints = in_joints();
    if (Failure failure = run_.end_at_switch(t_1, joints, attempt_in_joints)) return failure;
    return t_1 == whole ? Failure{} : attempt(t_1, end);
  }
  /// The diagonal of the mass matrix M of the bodies, which is constant.
  static Eigen::VectorXd inertia_of(const AbsoluteSystem& bodies) {
    Eigen::VectorXd inertia(bodies.nv());
    Vector v(static_cast<std::size_t>(bodies.nv())), p;
    for (std::size_t c = 0; c < v.size(); ++c) {
      v[c] = 1;
      bodies.momentum(v, p);
      inertia[static_cast<Eigen::Index>(c)] = p[c];
      v[c] = 0;
    }
    return inertia;
  }
  /// Computes the change x = M⁻¹ Bᵀ λ of coordinates or velocities with B x = -r, which removes the residuals
  /// r of the constraints (rows_), and writes it to x_. M is the mass matrix and B the constraint Jacobian of
  /// the last factorisation, and λ are multipliers. Residuals of coordinates are removed to first order.
  /// Changes the sign of rows_.
  void project() {
    as_eigen(rows_) *= -1;
    f_.assign(static_cast<std::size_t>(bodies_.nv()), 0.0);
    bodies_.solve(f_, rows_, x_, multipliers_);
  }
  void record_residuals() {
    set_time(now());
    bodies_.position_residual(q, rows_);
    trajectory.position_residuals.push_back(largest_of(rows_));
    bodies_.velocity_residual(q, v, rows_);
    trajectory.velocity_residuals.push_back(largest_of(rows_));
    trajectory.body_energies.push_back(bodies_.energy(q, v));
  }
  double position_error(Span q_t) {
    bodies_.position_residual(q_t, rows_);
    return as_eigen(rows_).norm();
  }

  AbsoluteSystem bodies_;
  ConfigurationGroup<double> group_;
  EnergyNorm norm_;
  double weakest_row_ = 1;
  Vector q_joints_, v_joints_, resistance_, f_, p_, rows_, x_, multipliers_;
};

}  // namespace axode
