#pragma once
#include <span>
#include <vector>

#include "axode/lie/twist.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// Joint coordinates and velocities by poses and twists of the bodies, and the constraint residuals at these.
struct JointState {
  std::vector<double> q, v;
  double position_residual = 0;  ///< largest absolute entry of the residuals of joints and loops, rad and m
  double velocity_residual = 0;  ///< largest absolute entry of the velocity residuals of joints and loops,
                                 ///< rad/s and m/s
};

/// Computes the coordinates and velocities of the joints from the poses C and the body-fixed twists V of the
/// body frames that the user placed, beginning with the ground; the inverse of the functions poses() and
/// twists(), which compute these from joint coordinates. Of the angles that differ by whole turns, those
/// nearest to the coordinates `near` are taken, or to the neutral configuration if `near` is empty. Throws
/// std::invalid_argument for wrong sizes. O(n).
JointState joint_state(const Model& model, std::span<const SE3<>> C, std::span<const Twist<BodyFixed>> V,
                       std::span<const double> near = {});

}  // namespace axode
