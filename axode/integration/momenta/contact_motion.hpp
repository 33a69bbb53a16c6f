#pragma once
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "axode/contact/contact_shapes.hpp"
#include "axode/integration/momenta/contact_step.hpp"
#include "axode/integration/runs/contact_simulation_run.hpp"
#include "axode/integration/simulation.hpp"

namespace axode {

/// A step of a motion with contact that has been computed. Its end has no accelerations.
struct ComputedContactStep {
  StepEnd end;
  double certificate = 0, unresolved = 0;
  bool touched = false;
  std::vector<ContactForce> forces = {};
};

/// Steps of a motion with contact and drives. A step ends early at a time at which a drive changes to another
/// branch of its law and its force, its states or their rates jump; it does not end where they change without
/// a jump. Simulations and rollouts take the same steps. After the first step, memory is allocated only if
/// there are more than 64 contacts.
class ContactSteps {
 public:
  ContactSteps(ContactSimulationRun& run, const ContactShapes& shapes, bool dry_friction);

  /// Computes the step from the state `from` at time t to t_1. Fails if loops are open or prescribed motions
  /// are not followed at its end.
  Failure compute(double t, double t_1, const StepEnd& from, ComputedContactStep& out);
  /// Computes the step from the present state of the run to t_1. If before t_1 a drive changes to another
  /// branch of its law and its force, its states or their rates jump, the step ends at this change, and t_1
  /// becomes its time.
  Failure compute_up_to_switch(double& t_1, ComputedContactStep& out);
  /// Lets parts() give, after each step, the data from which it is differentiated.
  void keep_parts() { scheme_.keep_parts = true; }
  const std::vector<ContactPart>& parts() const { return scheme_.kept; }
  /// Forgets the impulses of earlier steps.
  void restart() noexcept { scheme_.restart(); }
  /// Takes the impulses of the last step of another motion of the same mechanism as first guesses.
  void continue_from(const ContactSteps& other) { scheme_.continue_from(other.scheme_); }

 private:
  ContactSimulationRun* run_;
  ContactStep scheme_;
  StepEnd from_, end_;
  ComputedContactStep attempt_, after_;  ///< the last attempt, and the earliest one after a change
};

/// A motion with contact during its integration, as by simulate_contact().
class ContactMotion {
 public:
  using Span = std::span<const double>;

  /// Begins at time 0. Throws std::invalid_argument as simulate_contact() does.
  ContactMotion(const Model& model, const ContactShapes& shapes, Span q, Span v, double until,
                const SimulationOptions& options);
  ContactMotion(const ContactMotion&) = delete;
  ContactMotion& operator=(const ContactMotion&) = delete;
  /// Begins a motion that continues from the present state of this one, to the last bit as this one does.
  std::unique_ptr<ContactMotion> fork() const;

  /// Takes equal steps from the present time until the end of the motion; the last one may be shorter.
  void take_steps(double step);
  /// Takes adaptive steps until the end of the motion. Each step is computed as a whole and in two halves. If
  /// both results agree to the tolerances, the halves are taken; otherwise a shorter step is tried. If
  /// several contacts share an impact, the velocities of both results may differ however short the step is.
  /// Halves that disagree with the whole are therefore taken if two conditions hold. First, shorter steps do
  /// not help: an earlier step that would have ended after the present time was rejected, was at least a
  /// hundred times longer, and had an error at most four times as large. Second, the positions agree to the
  /// tolerances, where h times the magnitude of the difference of velocities is added to the difference of
  /// positions, with the length h of the step. A step not longer than 1e-9 of the duration of the motion is
  /// always taken; if it cannot be computed, the motion ends.
  void take_steps(const Tolerances& tolerances);
  /// Lets a motion that has reached its end continue until a later time (s).
  void continue_until(double until);

  ContactSimulationRun& run() { return run_; }

 private:
  /// An attempt at a step whose halves did not agree with the whole.
  struct Rejection {
    double end = 0, h = 0, error = 0;
  };
  /// Errors of a step as multiples of the tolerances.
  struct Difference {
    double of_all = std::numeric_limits<double>::infinity();
    double of_places = of_all;  ///< as of_all, with the differences of velocities times h
                                ///< added to those of positions
  };
  StepEnd present() const { return {.q = run_.q, .v = run_.v, .x = run_.drives().x}; }
  Failure take(double t_1, ComputedContactStep& step);
  Difference difference(const ComputedContactStep& whole, const ComputedContactStep& halves,
                        double unresolved, double h, const Tolerances& tolerances);

  Model model_;
  ContactShapes shapes_;
  SimulationOptions options_, free_options_;
  Eigen::VectorXd q_0_, v_0_;  ///< the state at the beginning
  ContactSimulationRun run_;
  ContactSteps steps_;
  double until_, length_ = 0;  ///< the end of the motion, and the length of the next adaptive step, s
};

}  // namespace axode
