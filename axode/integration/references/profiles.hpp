#pragma once
#include <span>

#include "axode/integration/trajectory.hpp"

/// Motions from rest at a configuration `start` to rest at a configuration `goal`, within limits of
/// velocities and accelerations, for controllers to follow. Every joint moves along its geodesic: q = start ⊕
/// s X, v = s' X and a = s'' X, where X is the displacement from start to goal, start ⊕ X = goal, and
/// rotations take the shorter way round. Each joint has its profile, a function s of time that rises from 0
/// to 1. All joints start and arrive together. The duration is the shortest one in which every joint alone
/// can move by a profile of the kind; profiles of faster joints are stretched in time.
///
/// The trajectory begins at t = 0 and is exact at all times; it has states where accelerations jump, and
/// about fifty more. If start and goal are equal, it has one state. Coupled joints follow their leaders, and
/// the limits of coupled joints are ignored. In a mechanism with loops, the loops are open between the start
/// and the goal; controllers follow the coordinates of the driven joints. O(n).
///
/// The functions throw std::invalid_argument for wrong sizes, numbers that are not finite, quaternions that
/// are not of unit norm, a goal outside the limits of the joints, and limits that are not positive.
namespace axode {

/// Limits of the magnitudes of velocities (rad/s or m/s) and accelerations (rad/s² or m/s²): nv numbers, or
/// one number for all.
struct ProfileLimits {
  std::span<const double> acceleration = {};  ///< finite
  std::span<const double> velocity = {};      ///< may be infinite; if empty, the limits of the model
};

/// Computes a motion with the profile s = 10 u³ - 15 u⁴ + 6 u⁵ in u = t / T with the duration T:
/// accelerations are continuous. The largest s' is 15/(8 T), and the largest |s''| is 10/(√3 T²) (Biagiotti
/// and Melchiorri, Trajectory Planning for Automatic Machines and Robots, section 2.1).
Trajectory quintic_profile(const Model& model, std::span<const double> start, std::span<const double> goal,
                           const ProfileLimits& limits);

/// Computes a motion with a profile of constant acceleration, constant velocity and constant deceleration:
/// the fastest motion within limits of velocity and acceleration. Accelerations jump. A joint that does not
/// reach its velocity limit has no phase of constant velocity.
Trajectory trapezoidal_profile(const Model& model, std::span<const double> start,
                               std::span<const double> goal, const ProfileLimits& limits);

}  // namespace axode
