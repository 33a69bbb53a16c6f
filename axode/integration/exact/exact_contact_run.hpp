#pragma once
#include <algorithm>
#include <limits>
#include <map>
#include <vector>

#include "axode/integration/exact/contact_phase.hpp"
#include "axode/integration/exact/gap_course.hpp"
#include "axode/integration/runs/simulation_run.hpp"

namespace axode {

/// A motion with contact during its integration in smooth phases, in each of which the same contacts touch,
/// stick and slide. Steps end at the events between phases: impacts, separations, and contacts and joints
/// that begin or cease to slide, see (D11.29) to (D11.35).
class ExactContactRun : public SimulationRun {
 public:
  /// The options must not ask for joint losses; `losses` says whether dry friction and damping of joints act.
  ExactContactRun(const Model& model, const ContactShapes& shapes, Span q_0, Span v_0, double until,
                  const SimulationOptions& options, bool losses, const Tolerances& tolerances);

  /// Computes the accelerations a_t under the constraints of the present phase.
  Failure accelerate(double t, Span q_t, Span v_t, std::span<double> a_t);
  /// Takes a step that ends at t_1, or at the first event before t_1. Events are impacts, contacts and hard
  /// stops that open or close, contacts and joints with dry friction that begin or cease to slide, and drives
  /// that change to another branch of their law. If the step is too long to find an event in it, takes no
  /// step and sets step_limit_.
  Failure take_up_to(double t_1, StepEnd& end, const Attempt& attempt);
  /// Takes a step to t_1 or somewhat later after attempts at the shortest steps have failed. If the points at
  /// which two faces touch change there, the step is taken with the present accelerations, and the phase with
  /// the new points begins. Otherwise takes no step and returns the failure of the attempts.
  Failure pass(double t_1, const Failure& why);
  /// As that of SimulationRun, and not after step_limit_.
  double step_end(double t_1) const { return std::min(SimulationRun::step_end(t_1), step_limit_); }

 private:
  /// The numbers that decide at a state whether the phase has ended.
  struct Marks {
    double reserve = 0;  ///< ContactPhase::reserve(): least distance of forces from their limits
    std::vector<double> slips = {}, speeds = {};
    std::vector<Gap> gaps = {};
  };
  /// For a contact or stop that is open at the start of a step: `closes` is the predicted time (s) in the
  /// step at which its gap becomes negative, or infinite if it does not. A negative gap counts as a closure
  /// only after the time `from`. It is minus infinity, except if the contact or stop has just opened, so that
  /// rounding may make its gap negative: then it is a time just before `closes`, or infinite if `closes` is.
  struct Window {
    double from, closes;
  };

  void begin();
  /// Computes accelerations and marks at the end of an attempt at a step.
  Failure mark(double t, StepEnd& end, Marks& out);
  Failure mark(double t, const Vector& q_t, const Vector& v_t, const Vector& x_t, Vector& a_t, Marks& out);
  Failure take_in_phase(double t_1, StepEnd& end, const Attempt& attempt);
  Failure switch_drives();
  /// Begins another phase at the present state, and adds its differences from the constraints `before` to the
  /// events. It takes a copy, because `before` may be the list of the phase.
  Failure begin_phase(double t, std::vector<ClosedConstraint> before);
  void predict(double t_1, const Marks& at_end);
  /// Numbers of which one is negative if a contact, stop or joint with friction has opened, closed, begun or
  /// ceased to slide before t. They are the least distance of the constraint forces from their limits, the
  /// velocity of each sliding constraint along its stored direction of sliding, the gap of each contact or
  /// stop that was open at the start of the step, and the least gap of all contacts that were found since.
  std::vector<double> entries(double t, const Marks& marks) const;
  /// Shortens a step in which an event ends the phase, so that the step ends at the time t_1 of the event.
  Failure find_event(double& t_1, StepEnd& end, std::vector<double>& at_high, Marks& marks,
                     const Attempt& attempt);
  /// The time at which a step to t should end. It is t, except if at t a sliding velocity has a negative
  /// component along its stored direction without being near 0. The velocity has then turned, and the result
  /// is the middle of the step.
  bool is_beyond_a_root(const std::vector<double>& found, std::size_t slips) const;
  double before_turn(double t, const std::vector<double>& found, const Marks& marks) const;
  Failure look_ahead(double t, double t_far, double reserve_far, const Attempt& attempt,
                     std::vector<ClosedConstraint>& next);
  Failure accept(double t, StepEnd& end);
  std::vector<char> stopping(double t, const std::vector<double>& found, const Marks& marks) const;
  Failure change(double t, const std::vector<double>& found, const std::vector<char>& stopped,
                 const std::vector<ClosedConstraint>& next);
  Failure meet(double t, const std::vector<double>& found, const std::vector<char>& stopped);
  Failure end_short_flights(double t, std::vector<ContactPhase::Impact>& met);
  Failure settle(double t);
  void note_changes(double t, const std::vector<ClosedConstraint>& before,
                    const std::vector<ContactPhase::Impact>& met, const std::vector<char>& stopped);
  void add_event(const ContactPhase::Impact& it, double t);
  /// Lets the phase follow the prescribed motions at time t.
  void follow(double t) { phase_.follow(motion_rows(t)); }
  /// Computes the forces at a state without those of contacts and dry friction, and calls follow().
  Failure find_forces(double t, Span q_t, Span v_t, ContactPhase::Forces& out);
  /// Chooses the phase of the present state, at time t.
  Failure decide(double t);

  ContactPhase phase_;
  double last_;  ///< end of the motion, s
  Tolerances tolerances_;
  Marks now_;
  std::vector<Window> windows_;
  std::map<std::pair<ContactLaw, std::uint64_t>, double> last_impact_;
  double certificate_ = 0, last_event_ = -1;
  double step_limit_ = std::numeric_limits<double>::infinity();  ///< the end of a step that is repeated
  int quick_events_ = 0;
};

}  // namespace axode
