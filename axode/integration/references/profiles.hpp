#pragma once
#include <span>

#include "axode/integration/trajectory.hpp"

/// Motions from rest at a configuration `start` to rest at a configuration `goal`, within limits of
/// velocities and accelerations, for controllers to follow. Every joint moves along its geodesic: q = start ⊕
/// s X, v = s' X and a = s'' X, where X is the displacement from start to goal, start ⊕ X = goal, with
/// rotations the shorter way round. Each joint has a profile s, a function of time that rises from 0 to 1. It
/// is a polynomial of degree 5 in quintic_profile(), and has a trapezoidal velocity s' in
/// trapezoidal_profile(). All joints start and arrive together, in the shortest time in which such profiles
/// keep every joint within its limits.
///
/// The trajectory begins at t = 0. If start and goal are equal, it has one state. Otherwise it has at least
/// fifty steps, and a state at each jump of an acceleration. Between the states, Trajectory::at()
/// interpolates by polynomials of degree 5, which is exact because the profiles are polynomials of degree 5
/// or less there. Coupled joints follow their leaders; their limits are ignored. Loops are not closed between
/// start and goal. O(n) for n bodies.
///
/// The functions throw std::invalid_argument for wrong sizes, numbers that are not finite, quaternions that
/// are not of unit norm, a goal outside the limits of the joints, and limits that are not positive.
namespace axode {

/// Limits of velocities (rad/s or m/s) and accelerations (rad/s² or m/s²): nv numbers, or one for all.
struct ProfileLimits {
  std::span<const double> acceleration = {};  ///< finite
  std::span<const double> velocity = {};      ///< may be infinite; if empty, the limits of the model
};

/// Computes a motion with the profile s = 10 u³ - 15 u⁴ + 6 u⁵ in u = t / T with the duration T, whose
/// accelerations are continuous. The largest s' is 15/(8 T), and the largest |s''| is 10/(√3 T²).
Trajectory quintic_profile(const Model& model, std::span<const double> start, std::span<const double> goal,
                           const ProfileLimits& limits);

/// Computes a motion from rest at `start` to rest at `goal` with trapezoidal velocities. Each joint has
/// constant acceleration, then constant velocity, then constant deceleration. A joint has no phase of
/// constant velocity if it does not reach its velocity limit when it moves alone as fast as possible. All
/// joints start and arrive together, in the shortest time for which these profiles are within the limits of
/// velocity and acceleration of every joint. Accelerations jump.
Trajectory trapezoidal_profile(const Model& model, std::span<const double> start,
                               std::span<const double> goal, const ProfileLimits& limits);

}  // namespace axode
