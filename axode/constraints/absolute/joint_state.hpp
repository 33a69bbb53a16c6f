#pragma once
#include <span>
#include <vector>

#include "axode/lie/twist.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// Coordinates and velocities of the joints that fit a motion of the bodies best, and the residuals of this
/// motion.
struct JointState {
  std::vector<double> q, v;
  double position_residual = 0;  ///< the largest residual of a joint or loop, rad and m
  double velocity_residual = 0;  ///< the largest residual of velocities, rad/s and m/s
};

/// Computes the state of the joints from the poses C and the body-fixed twists V of bodies 0 to n_bodies() in
/// the user's frames; the inverse of poses() and twists(). Angles are those nearest to the ones in `near`, or
/// to the neutral ones if this is empty. Throws std::invalid_argument for wrong sizes. O(n).
JointState joint_state(const Model& model, std::span<const SE3<>> C, std::span<const Twist<BodyFixed>> V,
                       std::span<const double> near = {});

}  // namespace axode
