#pragma once
#include "axode/constraints/embedding/task_space.hpp"
#include "axode/lie/se3.hpp"

namespace axode {

/// Where place_platform() ended.
struct PlatformPlacement {
  bool reached = false;
  /// The limb that reaches the pose least; -1 if the joint of the platform itself does not have this pose.
  int limb = -1;
  double residual = 0;  ///< the residual |r| of this limb, or of the platform's pose, rad and m
  int iterations = 0;
};

/// Inverse kinematics: moves the platform to the pose C of its body frame in the inertial frame, and closes
/// every limb by itself, by Newton's method on its own joints (D18.12). `q` (nq) has a configuration to start
/// from and receives the new one, whose limbs are in the same assembly mode if the pose is not far. Joint
/// velocities that the platform does not determine stay as they are. If a limb does not reach the pose, q is
/// the last iterate. Limits of coordinates are ignored. Allocates; O(limbs) an iteration. Throws
/// std::invalid_argument for a mechanism without a platform, a wrong q and numbers that are not finite.
[[nodiscard]] PlatformPlacement place_platform(TaskSpace& space, const SE3<>& C, std::span<double> q);

/// One sentence for the user: what does not reach the pose.
std::string to_string(const TaskSpace& space, const PlatformPlacement& placement);

}  // namespace axode
