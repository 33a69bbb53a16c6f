#pragma once
#include <memory>
#include <span>
#include <vector>

#include "axode/fmi/variables.hpp"
#include "axode/integration/runs/simulation_run.hpp"

namespace axode::fmi {

/// A motion that is integrated from one communication point of a co-simulation to the next, as simulate()
/// does it: loops are closed at the end of each step, and steps end where dry friction, drives or plays
/// change. Drive forces and loads are constant between communication points.
class SteppedMotion {
 public:
  using Span = std::span<const double>;

  /// Starts at (q, v) at a time (s), with the initial states of drives that the description has. Throws
  /// std::invalid_argument for a state in which a motion cannot start, and for a time that is not 0 if the
  /// mechanism has motions or drives, which are functions of time.
  SteppedMotion(const Model& model, const Settings& settings, double t, Span q, Span v,
                const Tolerances& tolerances);
  /// A copy continues independently, but shares the forces.
  SteppedMotion(const SteppedMotion& other);

  /// Sets the drive forces (nv) and the loads that act from now on.
  void set_forces(Span tau, std::vector<AppliedWrench<>> loads);
  /// Integrates until a time. Throws std::runtime_error if the motion ends early.
  void advance(double t);

  double t() const { return t_0_ + run_.now(); }
  Span q() const { return {run_.q.data(), static_cast<std::size_t>(run_.q.size())}; }
  Span v() const { return {run_.v.data(), static_cast<std::size_t>(run_.v.size())}; }
  Span a() const { return {run_.a.data(), static_cast<std::size_t>(run_.a.size())}; }
  /// The drives with their present statuses and inputs.
  const DriveSystem& drives() { return run_.drives().system(); }
  Span x() { return {run_.drives().x.data(), run_.drives().size()}; }
  Span dx() { return {run_.drives().dx.data(), run_.drives().size()}; }

 private:
  /// The model, the options and the forces, to which the run has references.
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
