#pragma once
#include <span>

#include "axode/integration/trajectory.hpp"

/// Motions from rest at a configuration to rest at another one, within limits, which controllers follow.
/// Every joint moves along its geodesic: q = start ⊕ s X with X = goal ⊖ start, v = s' X and a = s'' X, where
/// rotations take the shorter way round. The profile s of time goes from 0 to 1 for each joint. All joints
/// start and arrive together, and the time is the shortest in which every joint alone can move by a profile
/// of the kind: profiles of faster joints are stretched in time.
///
/// The trajectory begins at t = 0 and is exact at all times; it has states where accelerations jump, and
/// about fifty more. If start and goal are equal, it has one state. Coupled joints follow their leaders, and
/// their own limits do not count. With loops, states between the start and the goal are not closed;
/// controllers follow the coordinates of the driven joints. O(n).
///
/// The functions throw std::invalid_argument for wrong sizes, numbers that are not finite, quaternions that
/// are not of unit norm, a goal outside the limits of the joints, and limits that are not positive.
namespace axode {

/// Limits of each velocity (rad/s or m/s) and its derivative (rad/s² or m/s²), or one number for all.
struct ProfileLimits {
  std::span<const double> acceleration = {};  ///< finite
  std::span<const double> velocity = {};      ///< perhaps infinite; if empty, the limits of the model
};

/// s = 10 u³ - 15 u⁴ + 6 u⁵ in u = t / T: accelerations are continuous. s' T is 15/8 at most, and |s''| T² is
/// 10/√3 (Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots, section 2.1).
Trajectory quintic_profile(const Model& model, std::span<const double> start, std::span<const double> goal,
                           const ProfileLimits& limits);

/// Constant acceleration, constant velocity and constant deceleration: the fastest motion within limits of
/// velocity and acceleration. Accelerations jump. A joint that does not reach its velocity limit has no phase
/// of constant velocity.
Trajectory trapezoidal_profile(const Model& model, std::span<const double> start,
                               std::span<const double> goal, const ProfileLimits& limits);

}  // namespace axode
