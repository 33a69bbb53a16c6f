#pragma once
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "axode/contact/contact_shapes.hpp"
#include "axode/fmi/variables.hpp"
#include "axode/integration/momenta/contact_motion.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "axode/integration/runs/simulation_run.hpp"

namespace axode::fmi {

/// Whether the mechanism has settings of contact and collision shapes.
bool has_shapes_that_touch(const Model& model);
/// Whether a co-simulation of the mechanism is a simulation with contact.
inline bool moves_with_contact(const Model& model) {
  return has_shapes_that_touch(model) || has_hard_stops(model);
}

/// A motion in a co-simulation, integrated from one communication point to the next as by simulate(), or as
/// by simulate_contact() if the mechanism has hard stops or contacts. Loops are closed at the end of each
/// step. A step also ends when a joint begins to stick or to slide, when a drive changes to another branch of
/// its law (for example at a limit), and when a play (backlash of a coupling) reaches or leaves an end. Drive
/// forces and loads are constant between communication points.
class SteppedMotion {
 public:
  using Span = std::span<const double>;

  /// Starts at the state (q, v) at time t (s). The states of drives begin at the values in the description of
  /// the model, or else at values that the law of the drive chooses. `tolerance` is the relative tolerance of
  /// adaptive steps. If it is empty, the default tolerances of simulate() hold; a motion with contact then
  /// takes equal steps between two communication points, not longer than the default step of the method
  /// `contact`. Throws std::invalid_argument for a state that is not valid or has open loops, and if t is not
  /// 0 and the mechanism has prescribed motions or drives. Throws std::runtime_error if the accelerations at
  /// the start cannot be computed.
  SteppedMotion(const Model& model, const Settings& settings, double t, Span q, Span v,
                std::optional<double> tolerance);
  /// A copy continues independently; both write their forces to one memory before they integrate.
  SteppedMotion(const SteppedMotion& other);

  /// Sets the drive forces (nv) and the loads that act from now on.
  void set_forces(Span tau, std::vector<AppliedWrench<>> loads);
  /// Integrates until time t (s). Throws std::runtime_error if the motion ends early.
  void advance(double t);

  double t() const { return t_0_ + run_.now(); }
  Span q() const { return {run_.q.data(), static_cast<std::size_t>(run_.q.size())}; }
  Span v() const { return {run_.v.data(), static_cast<std::size_t>(run_.v.size())}; }
  /// The accelerations; after a step of a motion with contact, their means over the last step.
  Span a() const { return {run_.a.data(), static_cast<std::size_t>(run_.a.size())}; }
  /// The drives with their present inputs and statuses, the integers that select a branch of a drive's law.
  const DriveSystem& drives() { return run_.drives().system(); }
  const DryFriction& friction() const { return run_.friction(); }
  Span x() { return {run_.drives().x.data(), run_.drives().size()}; }
  Span dx() { return {run_.drives().dx.data(), run_.drives().size()}; }

 private:
  /// The model, the options and the forces, to which the integration refers; copies of a motion share them.
  struct Fixed {
    Model model;
    std::optional<ContactShapes> shapes = {};  ///< empty unless moves_with_contact()
    SimulationOptions options = {};
    std::vector<double> tau;
    std::vector<AppliedWrench<>> loads = {};
  };
  static std::shared_ptr<Fixed> fixed(const Model& model, const Settings& settings);
  void check() const;
  void forget_past(SimulationRun& run);
  void advance_with_contact(double t);
  void act();

  std::shared_ptr<Fixed> fixed_;
  std::vector<double> tau_;
  std::vector<AppliedWrench<>> loads_;
  double t_0_;
  bool adaptive_;  ///< whether the simulator has given a tolerance
  Tolerances tolerances_;
  SimulationRun run_;  ///< with contact, it has the present state alone
  std::unique_ptr<ContactMotion> contact_;
};

}  // namespace axode::fmi
