#pragma once
#include <memory>
#include <span>
#include <vector>

#include "axode/fmi/variables.hpp"
#include "axode/integration/runs/simulation_run.hpp"

namespace axode::fmi {

/// A motion in a co-simulation, which is integrated from one communication point to the next with the method
/// of simulate(): loops are closed at the end of each step, and steps end at times at which dry friction,
/// drives or plays change. Drive forces and loads are constant between communication points.
class SteppedMotion {
 public:
  using Span = std::span<const double>;

  /// Starts at the state (q, v) at time t (s). The states of drives start at the values in the description.
  /// Throws std::invalid_argument for a state in which a motion cannot start. Also throws it if t is not 0
  /// and the mechanism has prescribed motions or drives, because these are functions of time.
  SteppedMotion(const Model& model, const Settings& settings, double t, Span q, Span v,
                const Tolerances& tolerances);
  /// A copy continues independently. Both use one memory for the forces, into which each writes its own
  /// before it integrates.
  SteppedMotion(const SteppedMotion& other);

  /// Sets the drive forces (nv) and the loads that act from now on.
  void set_forces(Span tau, std::vector<AppliedWrench<>> loads);
  /// Integrates until time t (s). Throws std::runtime_error if the motion ends early.
  void advance(double t);

  double t() const { return t_0_ + run_.now(); }
  Span q() const { return {run_.q.data(), static_cast<std::size_t>(run_.q.size())}; }
  Span v() const { return {run_.v.data(), static_cast<std::size_t>(run_.v.size())}; }
  Span a() const { return {run_.a.data(), static_cast<std::size_t>(run_.a.size())}; }
  /// The drives with their present discrete statuses and inputs.
  const DriveSystem& drives() { return run_.drives().system(); }
  Span x() { return {run_.drives().x.data(), run_.drives().size()}; }
  Span dx() { return {run_.drives().dx.data(), run_.drives().size()}; }

 private:
  /// The data to which the integration has references: the model, the options and the forces. Copies of a
  /// motion share them.
  struct Fixed {
    Model model;
    SimulationOptions options = {};
    std::vector<double> tau;
    std::vector<AppliedWrench<>> loads = {};
  };
  static std::shared_ptr<Fixed> fixed(const Model& model, const Settings& settings);
  void check() const;
  void forget_past();
  void act();

  std::shared_ptr<Fixed> fixed_;
  std::vector<double> tau_;
  std::vector<AppliedWrench<>> loads_;
  double t_0_;
  Tolerances tolerances_;
  SimulationRun run_;
};

}  // namespace axode::fmi
