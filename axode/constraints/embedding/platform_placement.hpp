#pragma once
#include "axode/constraints/embedding/task_space.hpp"
#include "axode/lie/se3.hpp"

namespace axode {

/// The result of place_platform().
struct PlatformPlacement {
  bool reached = false;
  /// The index of the limb (a chain that carries the platform) whose loops have the largest residual; -1 if
  /// the platform itself cannot have the wanted pose, because its own joint does not allow it.
  int limb = -1;
  double residual = 0;  ///< norm of the residual of this limb, or distance from the wanted pose if limb is
                        ///< -1, rad and m
  int iterations = 0;
};

/// Inverse kinematics of a parallel manipulator: moves the platform such that its body frame has the pose C
/// in the inertial frame, and closes every limb (a chain that carries the platform) by Newton's method on the
/// limb's own joints (D18.12). `q` (nq) contains the configuration to start from and receives the new one, or
/// the last iterate if a limb does not reach the pose. If C is near the pose at the start, the limbs stay in
/// their assembly mode. Limits of coordinates are ignored. Allocates; O(limbs) for each iteration. Throws
/// std::invalid_argument for a mechanism without a platform, a wrong size of q, quaternions that are not of
/// unit norm, and numbers that are not finite.
[[nodiscard]] PlatformPlacement place_platform(TaskSpace& space, const SE3<>& C, std::span<double> q);

/// A sentence that says that the pose is reached, or which limb or joint misses it and by how much.
std::string to_string(const TaskSpace& space, const PlatformPlacement& placement);

}  // namespace axode
