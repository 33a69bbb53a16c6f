#pragma once
#include <map>
#include <span>
#include <string>
#include <vector>

#include "axode/contact/contact_force.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// The reason why a motion ends early, and the time at which it does. As a condition it is false if there is
/// no failure.
struct [[nodiscard]] Failure {
  double t = 0;
  std::string why = {};

  explicit operator bool() const { return !why.empty(); }
};

/// A motion: its states at the ends of steps, t_0 < t_1 < ..., with interpolation between them.
class Trajectory {
 public:
  explicit Trajectory(const Model& model) : model_(model) {}

  const Model& model() const { return model_; }
  std::size_t size() const { return t_.size(); }
  std::span<const double> t() const { return t_; }
  /// Coordinates, velocities, accelerations and drive forces, one row for each time: size() × nq numbers for
  /// q, size() × nv for the others. τ is 0 if there is no drive.
  std::span<const double> q() const { return q_; }
  std::span<const double> v() const { return v_; }
  std::span<const double> a() const { return a_; }
  std::span<const double> tau() const { return tau_; }
  std::span<const double> q(std::size_t k) const { return std::span(q_).subspan(k * nq(), nq()); }
  std::span<const double> v(std::size_t k) const { return std::span(v_).subspan(k * nv(), nv()); }
  std::span<const double> a(std::size_t k) const { return std::span(a_).subspan(k * nv(), nv()); }

  /// The states of the drives and their rates, size() × nx numbers, and the names of the states; empty
  /// without drives that have states. Units are those of DriveState.
  std::span<const double> x() const { return x_; }
  std::span<const double> x(std::size_t k) const { return std::span(x_).subspan(k * nx(), nx()); }
  std::span<const double> dx(std::size_t k) const { return std::span(dx_).subspan(k * nx(), nx()); }
  std::span<const std::string> drive_states() const { return drive_states_; }
  std::size_t nx() const { return drive_states_.size(); }
  /// Sets the names of the states of the drives, before the first append().
  void set_drive_states(std::vector<std::string> names) { drive_states_ = std::move(names); }
  /// Interpolates the states of the drives at a time, by the cubic with the states and rates at both ends of
  /// the step; the error is of order h⁴. Throws std::invalid_argument for a time outside the trajectory.
  void drive_states_at(double time, std::span<double> x) const;

  /// Interpolates q, v and, unless it is empty, a at a time on the group: in the step from t_k, q = (q_k ⊕ (t
  /// - t_k) z) ⊕ x(t). z is the mean velocity of the step for joints of several velocities, and 0 for the
  /// others. x(t) is the quintic with the q, v and a of the step at both ends. A body may turn by any angle
  /// in a step if z is right within half a turn. The errors are of order h⁶ in q, h⁵ in v and h⁴ in a. Throws
  /// std::invalid_argument for a time outside the trajectory.
  void at(double time, std::span<double> q, std::span<double> v, std::span<double> a = {}) const;

  /// Appends the end of a step.
  void append(double t, std::span<const double> q, std::span<const double> v, std::span<const double> a,
              std::span<const double> tau, std::span<const double> x = {}, std::span<const double> dx = {});

  /// Replaces v, a, x and dx from the last end of a step on. v, a and dx may jump there, and x changes by
  /// rounding. v(k), a(k) and dx(k) are the values after the jump.
  void jump(std::span<const double> v, std::span<const double> a, std::span<const double> x = {},
            std::span<const double> dx = {});

  /// Removes the last end of a step.
  void pop_back();
  [[deprecated("use pop_back()")]] void take_back() { pop_back(); }

  std::size_t steps = 0, rejected = 0;  ///< steps that were taken, and attempts that were rejected
  std::size_t evaluations = 0;          ///< number of evaluations of accelerations
  bool complete = true;                 ///< whether the motion reached its end, or a terminal event
  std::string stop_reason;              ///< why the motion ended early, in a sentence; or empty
  /// An event of the options, by its index, and the time at which it occurred.
  struct EventOccurrence {
    std::size_t event;
    double t;
  };
  using Met [[deprecated("use EventOccurrence")]] = EventOccurrence;
  std::vector<EventOccurrence> events;  ///< in the order of time

  /// A play of a coupling that reaches one of its ends, or leaves it.
  struct PlayEvent {
    std::string coupling;
    double t = 0;
    int side = 0;        ///< -1 at the lower end, 1 at the upper one
    bool impact = true;  ///< whether the play reaches the end; otherwise it leaves
    bool stays = false;  ///< whether the play is at the end after the event
    double speed = 0;    ///< speed of the play before an impact, in units of the offset per s
    double impulse = 0;  ///< impulse of an impact along the coupling
  };
  std::vector<PlayEvent> play_events;  ///< in the order of time

  /// In absolute coordinates, at each end of a step: the largest residual of a joint or loop (rad, m), and of
  /// its velocity (rad/s, m/s). Coordinates of the joints do not contain these parts of the motion.
  std::vector<double> position_residuals, velocity_residuals;
  /// In absolute coordinates, at each end of a step: kinetic and potential energy of gravity of the bodies,
  /// J.
  std::vector<double> body_energies;

  /// With contact, for each step: how exactly the laws of contact hold, see certificate(); rounding is 1e-12.
  std::vector<double> certificates;
  /// With contact: the names of the collision shapes, by the numbers that contacts have.
  std::vector<std::string> contact_shapes;

  /// With contact: the points with a gap below the margin of the shapes at t_k, and those that received an
  /// impulse in the step that ends there. Forces are the means over this step, in which an impact is a force.
  /// Empty at t_0, and without contact.
  std::span<const ContactForce> contacts(std::size_t k) const;
  /// The contacts of the step that a time (s) belongs to; a time at the end of a step belongs to that step.
  std::span<const ContactForce> contacts_at(double time) const;
  /// Sets the contacts at the last end of a step.
  void set_contacts(std::span<const ContactForce> contacts);

 private:
  std::size_t nq() const { return static_cast<std::size_t>(model_.nq()); }
  std::size_t nv() const { return static_cast<std::size_t>(model_.nv()); }

  /// Velocities, accelerations and rates of the drives at the end of step k, before a jump if there is one
  /// there.
  struct Rates {
    std::vector<double> v, a, dx;
  };
  std::span<const double> v_before(std::size_t k) const;
  std::span<const double> a_before(std::size_t k) const;
  /// The step in which a time lies: the index of its start, or of the last state.
  std::size_t step_at(double time) const;

  Model model_;
  std::vector<double> t_, q_, v_, a_, tau_, x_, dx_;
  std::vector<std::string> drive_states_;
  std::vector<ContactForce> contacts_;
  std::vector<std::size_t> contacts_end_;  ///< for each time from t_0 on, as far as contacts are set
  std::map<std::size_t, Rates> before_jumps_;
};

}  // namespace axode
