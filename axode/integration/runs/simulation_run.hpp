#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "axode/derivatives/inverse_dynamics_derivatives.hpp"
#include "axode/integration/dry_friction.hpp"
#include "axode/integration/prescribed/closed_motion.hpp"
#include "axode/integration/runs/drive_states.hpp"
#include "axode/integration/runs/friction_response.hpp"
#include "axode/integration/runs/plays.hpp"
#include "axode/integration/runs/switch_search.hpp"
#include "axode/integration/schemes/energy_norm.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/model/workspace.hpp"

namespace axode {

/// The state at the end of a step: q, v and the accelerations a, and the states x of the drives with their
/// rates dx. a and dx are empty if the scheme does not compute accelerations.
struct StepEnd {
  Eigen::VectorXd q, v, a = {}, x = {}, dx = {};
};
/// Callback that computes the state at the end of a step from the present time to t_1. For each acceleration
/// that it computes, SimulationRun records the violation of dry friction and how near the loop equations are
/// to linear dependence. The records of earlier attempts at the step must be reset. For this the callback
/// calls begin_step() at its beginning. If only the acceleration at the end of the step is to be recorded, it
/// calls check_sticking() at its end instead, which resets the records and, if joints stick, computes this
/// acceleration.
using Attempt = std::function<Failure(double t_1, StepEnd& end)>;

/// The part of a simulation in joint coordinates that all integration schemes share: trajectory and present
/// state, accelerations, events, dry friction, drives with states, and couplings with play.
class SimulationRun {
 public:
  using Vector = Eigen::VectorXd;
  using Span = std::span<const double>;

  /// `damping` says whether joints are damped although the options ask for no joint losses.
  SimulationRun(const Model& model, Span q_0, Span v_0, double until, const SimulationOptions& options,
                bool damping = false);

  /// Computes the accelerations a_t at time t and state (q_t, v_t) under springs, drives, loads and friction.
  Failure accelerate(double t, Span q_t, Span v_t, std::span<double> a_t);

  /// Computes the residual r (nv numbers) of the equations of motion, which is 0 if a_t are the accelerations
  /// at time t and state (q_t, v_t). It is r = ID(q_t, v_t, a_t) - τ with the inverse dynamics ID and the
  /// joint forces τ or, for a mechanism with loops, r = a_t - FD(q_t, v_t, τ) with the forward dynamics FD.
  /// For a velocity that sticks by dry friction, the entry of r is the acceleration in a_t.
  Failure residual(double t, const Vector& q_t, const Vector& v_t, const Vector& a_t, Vector& r);
  double size_of_residual(const Vector& r) const {
    return loops_ ? norm_.of_velocities(r) : norm_.of_forces(r);
  }
  /// Computes the derivatives by q, v and a of the residual of the equations of motion, nv × nv each. The
  /// derivatives of the drive forces that the function SimulationOptions::drive gives are not included.
  void residual_derivatives(const Vector& q_t, const Vector& v_t, const Vector& a_t,
                            const InverseDynamicsDerivatives<double>& dr);
  bool is_driven() const { return static_cast<bool>(options_.drive); }
  /// The part of the residual of the equations of motion, with the opposite sign, that is due to the drive
  /// forces τ that the function SimulationOptions::drive gives: τ or, with loops, the accelerations (∂a/∂τ) τ
  /// with the last ∂a/∂τ that was computed. Entries for velocities that stick by dry friction are 0.
  Span drive(double t, const Vector& q_t, const Vector& v_t);

  const EnergyNorm& norm() const { return norm_; }
  /// The scale with which rounding errors of velocities are compared, for a step of length h (s). It is the
  /// largest of three numbers: the norm of the velocities v_t (nv) at a time in the step, the norm of the
  /// velocities that gravity or the joint forces cause in the time h, and 1e-8 times the norm of the
  /// coordinates, divided by h, so that the scale is not 0 at rest. The function without the argument v_t
  /// leaves out the first number. All are energy norms √Σ m_c x_c², with a constant inertia m_c for each
  /// velocity.
  double velocity_scale(const Vector& v_t, double h) const {
    return std::max(norm_.of_velocities(v_t), velocity_scale(h));
  }
  double velocity_scale(double h) const {
    return std::max(std::abs(h) * std::max(weight_, norm_.of_forces(forces_)), 1e7 * place_resolution(h));
  }
  /// The norm of velocities that change q, in a step of length h, by no more than the rounding error of q.
  double place_resolution(double h) const { return 1e-15 * places_ / std::abs(h); }

  /// Takes the step to t_1, or to an earlier time at which a joint comes to rest or begins to slide under dry
  /// friction, the law of a drive changes its form, or a play (backlash) reaches or leaves an end. `attempt`
  /// is a function that computes the state at the end of a step from the present time to a given time. Before
  /// the call, it must have been called for the time t_1, and `end` must be its result.
  Failure take_up_to(double t_1, StepEnd& end, const Attempt& attempt);
  /// Prepares an attempt at a step: resets the violation of dry friction and weakest_row().
  void begin_step();
  /// The least LoopSystem::weakest_row() of all accelerations that were computed since begin_step().
  double weakest_row() const { return weakest_row_; }
  /// Whether accelerations jumped at the end of the last step, by dry friction, a drive or a play.
  bool accelerations_jumped() const { return accelerations_jumped_; }
  /// For schemes without accelerations at the end of a step: computes them there if joints stick, to find out
  /// whether friction can hold the joints.
  Failure check_sticking(double t, const StepEnd& end);

  /// Projects the state at the end of a step onto closed loops, computes its accelerations unless the scheme
  /// has done so, and appends it to the trajectory.
  Failure take(double t, const StepEnd& end);
  /// Appends the state at the end of a step, with the states x_end of the drives, to the trajectory without
  /// projection onto closed loops.
  Failure take_closed(double t, Span q_end, Span v_end, const Vector& x_end);
  /// Shortens a step in which a status of a drive must change, so that it ends just after the change. A
  /// status is the integer that says which form of the drive's law holds. t_1 and `end`, the time and the
  /// state at the end of the step, become those of the shorter step. `attempt` computes the state at the end
  /// of a step from the present time to a given time. Its last call may be for another time than the final
  /// t_1. If `abrupt` is true, steps are shortened only for changes by which forces, rates or states of
  /// drives jump.
  Failure end_at_switch(double& t_1, StepEnd& end, const Attempt& attempt, bool abrupt = false);
  /// Lets the statuses and inputs of the drives change at the present time, and computes accelerations anew.
  Failure switch_drives();
  /// Calls the monitor of the options with a time t (s). Fails if it returns false.
  Failure interruption(double t) const;
  /// Ends the motion: the trajectory is then not complete and contains the reason.
  void stop(const Failure& failure);
  /// Lets a motion that has reached its end continue until a later time (s).
  Failure continue_until(double until);
  /// Computes the accelerations at the present state anew, after a force of the options has changed.
  Failure forces_changed();
  bool done() const { return trajectory.size() == 0 || ended_ || !trajectory.complete || now() >= until_; }
  double now() const { return trajectory.t().back(); }
  /// The time up to t_1 at which a step has to end: t_1, or a jump of a prescribed motion or a drive's input.
  double step_end(double t_1) const {
    const double t = std::min(t_1, drives_.next_jump(now()));
    return loops_ ? std::min(t, loops_->motions().next_jump(now())) : t;
  }
  /// closed_model() is the model in which prescribed motions are loop equations as well. motion_rows()
  /// returns for each of these equations its right sides at time t (s) for the position (rad or m), the
  /// velocity and the acceleration.
  const Model& closed_model() const { return loops_ ? loops_->motions().model() : model_; }
  std::span<const PrescribedRow<double>> motion_rows(double t) {
    return loops_ ? loops_->motion_rows(t) : std::span<const PrescribedRow<double>>();
  }
  /// Whether forces or motions are functions of time.
  bool is_driven_in_time() const { return options_.drive || (loops_ && !loops_->motions().rows().empty()); }
  DriveStates& drives() { return drives_; }
  const DriveStates& drives() const { return drives_; }
  /// The friction of joints, with the directions in which they slide at present.
  const DryFriction& friction() const { return friction_; }
  const Tree<double>& tree() const { return model_.tree<double>(); }
  LocalCoordinates local_coordinates() const { return options_.local_coordinates; }
  ConfigurationGroup<double> group() const { return ConfigurationGroup<double>(tree(), local_coordinates()); }
  /// Computes the sum tau (nv) of drive forces, spring forces and, with dry friction, losses of joints.
  Failure joint_forces(double t, Span q_t, Span v_t, Span& tau);
  /// Computes for each velocity the inertia that joint forces τ seem to add in an implicit step, in which a
  /// change x of an acceleration changes the coordinate by c_x x and the velocity by c_v x: the diagonal of
  /// -(c_x ∂τ/∂q + c_v ∂τ/∂v), or 0 where it is negative. τ are the forces of springs, dampers, drives with
  /// states and the caller's function SimulationOptions::drive, whose derivatives are difference quotients.
  Failure joint_resistance(double t, Span q_t, Span v_t, double c_x, double c_v, std::vector<double>& out);
  Loads<double> loads() const { return {loads_, options_.joint_losses && !friction_.active()}; }

  Trajectory trajectory;
  Vector q, v, a;  ///< present state and accelerations

 protected:
  using SquareMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  static constexpr const char* open = "the loops do not stay closed; use a shorter step";

  /// residual_derivatives() and drive() of the mechanism without its loops.
  void tree_residual_derivatives(const Vector& q_t, const Vector& v_t, const Vector& a_t,
                                 const InverseDynamicsDerivatives<double>& dr);
  Span tree_drive(double t, const Vector& q_t, const Vector& v_t);
  /// Appends the state at the end of a step to the trajectory, finds its events and calls the monitor.
  Failure record(double t, StepEnd end);
  /// Computes the sum of drive forces, spring forces and, if there is dry friction, losses.
  Span joint_force_sum(Span q_t, Span v_t);
  /// Computes drive forces and loads at a time and state. Fails if a number is not finite.
  Failure begin_evaluation(double t, Span q_t, Span v_t);
  /// The reason for the end of a motion with more than `most_short_steps` changes in succession.
  static std::string too_many_changes(const char* what);
  std::string joint_of(Span x) const;
  Failure not_finite(double t, const char* what, Span x) const;

  const Model& model_;
  const SimulationOptions& options_;
  Workspace<> workspace_;
  std::optional<ClosedMotion> loops_;
  DryFriction friction_;
  DriveStates drives_;
  EnergyNorm norm_;
  double places_;                       ///< EnergyNorm::of_places() of q
  double weight_;                       ///< the norm of gravity as a force on the whole mechanism
  Vector tau_, forces_;                 ///< drive forces, and the sum of all joint forces
  std::vector<AppliedWrench<>> loads_;  ///< loads at the state of the last evaluation
  int short_steps_ = 0;                 ///< successive steps that a change has ended at once

 private:
  void compute_loads(double t, Span q_t, Span v_t);
  void check_friction_of_motions() const;
  bool find_force_derivatives(Span q_t, Span v_t);
  /// Computes in tau_ the forces of SimulationOptions::drive and of the drives with states.
  void compute_drive_forces(double t, Span q_t, Span v_t);
  /// Computes the accelerations a, and the rates of the states of the drives, at the present state.
  Failure accelerate_now();
  Failure take_under_friction(double t_1, StepEnd& end, const Attempt& attempt);
  bool jumps_at_switch(double t, const StepEnd& end);
  Failure ensure_accelerations(double t, StepEnd& end);
  void start_plays();
  void engage_plays();
  Plays::Engage engagement();
  void note_plays(Plays::Events events);
  Failure reserves(double t, const StepEnd& end, std::vector<double>& out);
  double time_of_dip(double t_1, const StepEnd& end) const;
  Failure take_up_to_play(double t_1, StepEnd& end, const Attempt& attempt);
  Failure find_change(double& t_1, StepEnd& end, const Attempt& attempt, std::vector<double>& reserve);
  Failure change_plays(const std::vector<double>& reserve);
  Failure settle_plays();
  bool friction_changes(double t_0, double t_1, const StepEnd& end) const;
  bool stop_sliding(double within);
  void add_resistance_of_drive(double t, Span q_t, Span v_t, double c_x, double c_v,
                               std::vector<double>& out);
  std::vector<double> values_at(double t, Span q_t, Span v_t) const;
  double value_at(const Event& event, double t) const;
  int parts_by_rotation(double before);
  void find_occurrences(std::size_t e, double before, double after, double begin, double end,
                        std::vector<Trajectory::EventOccurrence>& met) const;
  Failure find_events(double before, double after);

  /// Derivatives of the forces of springs, and of drives and damping, by find_force_derivatives().
  SquareMatrix springs_by_q_, springs_by_v_, drives_by_q_, drives_by_v_;
  StepEnd after_switch_;     ///< the end of a step just after a change of a drive's status
  Vector jump_;              ///< the change of drive forces there
  Vector driven_;            ///< the result of drive()
  SquareMatrix compliance_;  ///< ∂a/∂τ
  FrictionResponse response_;
  Vector through_gears_;  ///< the part of tau_ that passes through gears, if there are any
  std::vector<double> values_;
  double until_, weakest_row_ = 1;
  bool damping_, ended_ = false, accelerations_jumped_ = false;
  Plays plays_;
};

}  // namespace axode
