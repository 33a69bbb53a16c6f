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

/// Computes the motion of a mechanism whose degrees of freedom all follow functions of time: the prescribed
/// motions of the model and those in `motions`. Positions are computed by Newton's method, and velocities,
/// accelerations and jerks from one factorisation of the Jacobian of loops and motions ((D12.5) of
/// docs/derivations). The motion is continuous and begins near q at the first of `times` (s). It ends early
/// if the prescribed motions cannot be followed to the last time, or if `monitor`, which is called before
/// every step, returns false. Masses and forces have no effect. Throws std::invalid_argument if q is not near
/// a configuration that closes the loops and follows the motions, if the motions leave a degree of freedom,
/// for q or times that are not finite, for times at which a motion is not known, and if times are empty or do
/// not increase. Allocates; O(m nv²) for each time with m rows of the Jacobian.
KinematicMotion kinematic_motion(const Model& model, std::span<const double> q, std::span<const double> times,
                                 std::span<const PrescribedMotion> motions = {},
                                 const std::function<bool()>& monitor = {});

}  // namespace axode
