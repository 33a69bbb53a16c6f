#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "axode/constraints/prescribed/prescribed_motion.hpp"

namespace axode {

/// A motion without dynamics, at the times that were asked for up to the last one that can be reached.
struct KinematicMotion {
  std::vector<double> t;
  std::vector<double> q, v, a, jerk;  ///< a row for each time: nq, nv, nv and nv numbers
  bool complete = true;               ///< whether all times were reached
  double reached = 0;                 ///< the last time that was reached, which may lie between two times
  std::string stop_reason;            ///< why the motion ended early, in a sentence; or empty
};

/// Computes the motion of a mechanism whose mobility is used up by prescribed motions: positions by Newton's
/// method, and velocities, accelerations and their derivatives from one factorisation of the rows (D12.5).
/// It begins near q at the first time and follows the branch on which it begins; the times increase. If a
/// motion cannot be followed further, the result ends there and has the reason. Masses, springs and forces
/// do not matter. Throws std::invalid_argument if q is not near a configuration that follows the motions,
/// with the remedy, if motions leave the mechanism a velocity, and for times that do not increase. The
/// monitor is called at every step; if it returns false, the result ends there. Allocates; O(m nv²) for each
/// time.
KinematicMotion kinematic_motion(const Model& model, std::span<const double> q, std::span<const double> times,
                                 std::span<const PrescribedMotion> motions = {},
                                 const std::function<bool()>& monitor = {});

}  // namespace axode
