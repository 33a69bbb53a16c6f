#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "axode/constraints/prescribed/prescribed_motion.hpp"

namespace axode {

/// A motion that prescribed motions alone determine, without dynamics: its states at given times, up to the
/// last one that can be reached.
struct KinematicMotion {
  std::vector<double> t;
  std::vector<double> q, v, a, jerk;  ///< a row for each time: nq, nv, nv and nv numbers
  bool complete = true;               ///< whether all times were reached
  double reached = 0;                 ///< the last time that was reached, which may lie between two times
  std::string stop_reason;            ///< why the motion ended early, in a sentence; or empty
};

/// Computes the motion of a mechanism whose degrees of freedom are all prescribed, by the model and by
/// `motions`: positions by Newton's method, and velocities, accelerations and jerks from one factorisation of
/// the Jacobian of loops and motions (D12.5). The motion begins near q at the first of the increasing times
/// (s), and is continuous. It ends early if the motions cannot be followed to the last time, for a reason
/// that the result contains, or if `monitor`, which is called before every step, returns false. Masses and
/// forces have no effect. Throws std::invalid_argument if q is not near a configuration that closes the loops
/// and follows the motions, if a velocity remains undetermined, for q or times that are not finite, and for
/// times that do not increase. Allocates; O(m nv²) for each time with m rows of the Jacobian.
KinematicMotion kinematic_motion(const Model& model, std::span<const double> q, std::span<const double> times,
                                 std::span<const PrescribedMotion> motions = {},
                                 const std::function<bool()>& monitor = {});

}  // namespace axode
