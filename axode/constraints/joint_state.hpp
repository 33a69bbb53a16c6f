#pragma once
#include <span>
#include <vector>

#include "axode/lie/twist.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// Coordinates and velocities of the joints, and what they cannot say.
struct JointState {
  std::vector<double> q, v;
  double position_residual =
      0;  ///< by how much joints and loops are open, the largest number of any, rad and m
  double velocity_residual = 0;  ///< the same of their velocities, rad/s and m/s
};

/// The state of the joints of bodies 0 to n_bodies() that have the poses C and the body-fixed twists V, in the user's frames:
/// the way back from poses() and twists(). Of what is not a motion of the joints position_residual and velocity_residual say how much there is. Angles are
/// those nearest to the ones of `near`, neutral where that is empty. Throws std::invalid_argument for wrong sizes. O(n).
JointState joint_state(const Model& model, std::span<const SE3<>> C, std::span<const Twist<BodyFixed>> V,
                       std::span<const double> near = {});

}  // namespace axode
