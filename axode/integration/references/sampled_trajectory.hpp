#pragma once
#include <span>

#include "axode/constraints/prescribed/prescribed_motion.hpp"
#include "axode/integration/trajectory.hpp"

/// Trajectories from samples or from functions of time, for controllers to follow. Their drive forces are 0.
namespace axode {

/// Computes the motion through samples at two or more times t (s). q has a row of nq numbers for each time, v
/// and a have a row of nv numbers for each time or are empty.
///
/// If v is empty, v and a are derivatives of interpolations of q: for a joint of one velocity, of the spline
/// of degree 5 through its samples, which are not reduced by whole turns; for a joint of several velocities,
/// of polynomials of degree 5 through up to six neighbouring samples, in exponential coordinates relative to
/// a motion with constant velocity. Such a joint must turn by less than half a turn between two samples. If
/// only a is empty, a is the derivative of the splines of degree 5 through v. For samples at distances h,
/// Trajectory::at() interpolates q with errors of order h⁶, v with h⁵ and a with h⁴. O(n) for each time and n
/// bodies.
///
/// Quaternions are normalised. Throws std::invalid_argument for fewer than two times, times that do not
/// increase, wrong sizes, a without v, numbers that are not finite, and quaternions that are not of unit
/// norm.
Trajectory trajectory_from_samples(const Model& model, std::span<const double> t, std::span<const double> q,
                                   std::span<const double> v = {}, std::span<const double> a = {});

/// Computes the motion in which joints of one velocity follow functions of time: the prescribed motions of
/// the model, and those in `motions`. All other joints rest at q, or at the initial state of the model if q
/// is empty. The trajectory has states at the two or more times t (s), and at times at which a derivative of
/// a function jumps. Between its states, Trajectory::at() interpolates q with an error of order h⁶ for steps
/// of length h. Loops are not closed. O(n) for each time and n bodies.
///
/// Throws std::invalid_argument for fewer than two times, times that do not increase, a wrong size of q,
/// numbers that are not finite, quaternions that are not of unit norm, a function that is not known at all
/// these times, two motions of one joint, and the motion of a rod (which prescribes its length), of a joint
/// that follows a leader, or of a joint of several velocities.
Trajectory trajectory_from_functions(const Model& model, std::span<const double> t,
                                     std::span<const PrescribedMotion> motions,
                                     std::span<const double> q = {});

}  // namespace axode
