#pragma once
#include <span>
#include <string>
#include <vector>

#include "axode/constraints/prescribed/motion_function.hpp"
#include "axode/model/model.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// Prescribed motions: a joint of one velocity, or the length of a rod, follows a function s of time. A
/// motion is a row A v = s' beside those of the loops; its multiplier is the force that the motion takes, in
/// N m for an angle and in N for a length. The force along a rod pushes its ends apart if it is positive.
/// The power of a motion is its force times s'. See (D12.1) to (D12.4) of docs/derivations.
namespace axode {

/// A motion besides those that the description of a mechanism has.
struct PrescribedMotion {
  std::string of;  ///< joint of one velocity, or loop of kind rod
  MotionFunction function;
};

/// The result of forward_dynamics_at().
struct DynamicsAtTime {
  Solvability solvability;
  std::vector<double> a;              ///< accelerations (nv)
  std::vector<double> lambda;         ///< multipliers of the loops (loops().rows)
  std::vector<double> motion_forces;  ///< force of each motion, those of the model first
};

/// Computes the accelerations at a time at which joints or rods follow prescribed motions, with the
/// multipliers of the loops and the forces that the motions take. If motions use up the mobility, this is
/// their inverse dynamics. q and v should be closed and follow the motions; their residuals are not
/// corrected. Loops are counted as in forward_dynamics(), and springs are ignored. Throws
/// std::invalid_argument for wrong sizes. Allocates; O(n + m d + m² d + m³).
[[nodiscard]] DynamicsAtTime forward_dynamics_at(const Model& model, double t, std::span<const double> q,
                                                 std::span<const double> v, std::span<const double> tau,
                                                 const Loads<double>& loads = {},
                                                 std::span<const PrescribedMotion> motions = {});

}  // namespace axode
