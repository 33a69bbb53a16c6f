#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "axode/contact/contact_force.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// The reason why a motion ends early, and the time at which it does; false if there is no failure.
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
  /// The states at all times, one row for each: coordinates q (nq numbers), velocities v, accelerations a and
  /// drive forces tau (nv numbers each). Forces are 0 without a drive.
  std::span<const double> q() const { return q_; }
  std::span<const double> v() const { return v_; }
  std::span<const double> a() const { return a_; }
  std::span<const double> tau() const { return tau_; }
  std::span<const double> q(std::size_t k) const { return std::span(q_).subspan(k * nq(), nq()); }
  std::span<const double> v(std::size_t k) const { return std::span(v_).subspan(k * nv(), nv()); }
  std::span<const double> a(std::size_t k) const { return std::span(a_).subspan(k * nv(), nv()); }

  /// The states x of the drives and their rates x', one row of nx() numbers for each time, and the names of
  /// the states. They are empty if no drive has states.
  std::span<const double> x() const { return x_; }
  std::span<const double> x(std::size_t k) const { return std::span(x_).subspan(k * nx(), nx()); }
  std::span<const double> dx(std::size_t k) const { return std::span(dx_).subspan(k * nx(), nx()); }
  std::span<const std::string> drive_states() const { return drive_states_; }
  std::size_t nx() const { return drive_states_.size(); }
  /// Sets the names of the states of the drives. It must be called before the first append().
  void set_drive_states(std::vector<std::string> names) { drive_states_ = std::move(names); }
  /// Interpolates the states x of the drives (nx() numbers) at a time (s), by the cubic with the states and
  /// rates at both ends of the step. The error is of order h⁴ in the length h of the step. Throws
  /// std::invalid_argument for a time outside the trajectory and for a wrong size.
  void drive_states_at(double time, std::span<double> x) const;

  /// Interpolates q, v and, unless it is empty, a at a time (s), on the group of configurations. It uses q, v
  /// and a at both ends of the step that contains the time. For steps of length h the errors are of order h⁶
  /// in q, h⁵ in v and h⁴ in a. For spherical, planar and free joints the step must be so short that its
  /// rotation, as estimated from v and a at both ends, differs from the true rotation by less than half a
  /// turn. Throws std::invalid_argument for a time outside the trajectory and for a wrong size.
  void at(double time, std::span<double> q, std::span<double> v, std::span<double> a = {}) const;

  /// Appends the state at the end of a step: the time t (s), q, v, a, the drive forces tau, and the states x
  /// of the drives with their rates dx.
  void append(double t, std::span<const double> q, std::span<const double> v, std::span<const double> a,
              std::span<const double> tau, std::span<const double> x = {}, std::span<const double> dx = {});

  /// Records a jump at the end of the last step. v, a, the states x of the drives and their rates dx are the
  /// values just after the jump, which the accessors return from now on; an empty x or dx means no change.
  /// The step before the jump is still interpolated with the v, a and dx before the jump. It is interpolated
  /// with the new x, which may therefore differ from the old one by rounding only.
  void jump(std::span<const double> v, std::span<const double> a, std::span<const double> x = {},
            std::span<const double> dx = {});

  /// Removes the state at the last end of a step.
  void pop_back();

  std::size_t steps = 0, rejected = 0;  ///< steps that were taken, and attempts that were rejected
  /// Number of adaptive steps that ignored their error estimate, near a meeting of branches of the motion
  std::size_t uncontrolled = 0;
  std::size_t evaluations = 0;  ///< number of evaluations of accelerations
  bool complete = true;         ///< whether the motion reached its end, or a terminal event
  std::string stop_reason;      ///< why the motion ended early, in a sentence; or empty
  /// An event of the options, by its index, and the time at which it occurred.
  struct EventOccurrence {
    std::size_t event;
    double t;
  };
  std::vector<EventOccurrence> events;  ///< in the order of time

  /// An event of a coupling with play: the play reaches one of its ends or leaves it.
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

  /// A change of a contact, a hard stop or a joint with dry friction in a motion by simulate_contact_exact().
  struct ContactEvent {
    enum class Kind {
      bounce,  ///< an impact after which it is open
      close,   ///< an impact, or a contact without speed, after which it is closed
      open,    ///< the normal force becomes 0
      slip,    ///< a sticking contact or joint begins to slide
      stick,   ///< the sliding velocity becomes 0, and friction can hold it
      reverse  ///< the sliding velocity becomes 0, and friction cannot hold it
    };
    Kind kind{};
    double t = 0;
    std::string of;          ///< the shapes of a contact, as `"floor" and "ball"`, or the name of the joint
    std::uint64_t key = 0;   ///< of a contact, see ContactPoint; 0 for a joint
    double speed = 0;        ///< speed of approach before a bounce or a closure, m/s or rad/s
    bool shortened = false;  ///< whether it was closed because its next bounces are below rounding (D11.35)
  };
  std::vector<ContactEvent> contact_events;  ///< in the order of time

  /// In absolute coordinates: how far joints and loops are violated at the end of each step, as the largest
  /// residual in positions (rad, m) and the largest one in velocities (rad/s, m/s).
  std::vector<double> position_residuals, velocity_residuals;
  /// In absolute coordinates, for each end of a step: kinetic energy plus potential energy of gravity, J.
  std::vector<double> body_energies;

  /// For each step of a motion with contact, the relative error of the laws of contact: the norm of the
  /// velocities that the error of the impulses causes, divided by the sum of the norms of the velocities
  /// without impulses and of those that the impulses add. The norm of velocities v is √(vᵀ M v) with the mass
  /// matrix M. Rounding errors make it about 1e-12.
  std::vector<double> certificates;
  /// The names of the collision shapes in a motion with contact, in the order of their numbers in contacts.
  std::vector<std::string> contact_shapes;

  /// The contacts at the end t_k of a step of a motion with contact: the points at which the gap between two
  /// shapes is below ContactDescription::margin (m), and the points that received an impulse in the step.
  /// Forces are the means over the step, so that an impact counts as a force. Empty for k = 0, and in a
  /// motion without contact.
  std::span<const ContactForce> contacts(std::size_t k) const;
  /// The contacts of the step in which a time (s) lies; a time at the end of a step belongs to that step.
  std::span<const ContactForce> contacts_at(double time) const;
  /// Sets the contacts at the last end of a step; see contacts().
  void set_contacts(std::span<const ContactForce> contacts);

 private:
  std::size_t nq() const { return static_cast<std::size_t>(model_.nq()); }
  std::size_t nv() const { return static_cast<std::size_t>(model_.nv()); }

  /// Velocities, accelerations and rates of the states of drives just before a jump at the end of a step.
  struct Rates {
    std::vector<double> v, a, dx;
  };
  std::span<const double> v_before(std::size_t k) const;
  std::span<const double> a_before(std::size_t k) const;
  /// The index k of the state from which the step that contains a time (s) begins: t_k ≤ time < t_{k+1}. For
  /// the last time it is the index of the last state. Throws std::invalid_argument for a time outside the
  /// trajectory.
  std::size_t step_at(double time) const;

  Model model_;
  std::vector<double> t_, q_, v_, a_, tau_, x_, dx_;
  std::vector<std::string> drive_states_;
  std::vector<ContactForce> contacts_;
  std::vector<std::size_t> contacts_end_;  ///< end of the contacts of each state, as far as they are set
  std::map<std::size_t, Rates> before_jumps_;
};

/// The name of a kind of contact events.
constexpr std::string_view to_string(Trajectory::ContactEvent::Kind kind) {
  using Kind = Trajectory::ContactEvent::Kind;
  switch (kind) {
    case Kind::bounce: return "bounce";
    case Kind::close: return "close";
    case Kind::open: return "open";
    case Kind::slip: return "slip";
    case Kind::stick: return "stick";
    case Kind::reverse: break;
  }
  return "reverse";
}

}  // namespace axode
