#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "axode/constraints/prescribed/prescribed_motion.hpp"

namespace axode {

/// A motion that prescribed motions alone determine, without dynamics: its states at the requested times, up
/// to the last state that can be reached.
struct KinematicMotion {
  std::vector<double> t;
  std::vector<double> q, v, a, jerk;  ///< a row for each time: nq, nv, nv and nv numbers
  bool complete = true;               ///< whether all times were reached
  double reached = 0;                 ///< the last time that was reached, which may lie between two times
  std::string stop_reason;            ///< why the motion ended early, in a sentence; or empty
};

/// Computes the motion of a mechanism whose degrees of freedom are all determined by prescribed motions:
/// those of the model and those in `motions`. Positions are computed by Newton's method, and velocities,
/// accelerations and jerks from one factorisation of the Jacobian of loops and motions (D12.5). The motion
/// begins near q at the first of the times (s), which increase, and remains on the branch of configurations
/// on which it begins. If the motions cannot be followed to the last time, the result ends at the last state
/// that was reached and contains the reason. Masses, springs and forces have no effect. Throws
/// std::invalid_argument if q is not near a configuration that closes the loops and follows the motions, if
/// the motions leave a velocity of the mechanism undetermined, for q or times that are not finite, and for
/// times that do not increase. The function `monitor` is called before every step; if it returns false, the
/// result ends there. Allocates; O(m nv²) for each time with m rows of this Jacobian.
KinematicMotion kinematic_motion(const Model& model, std::span<const double> q, std::span<const double> times,
                                 std::span<const PrescribedMotion> motions = {},
                                 const std::function<bool()>& monitor = {});

}  // namespace axode
