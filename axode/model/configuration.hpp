#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "axode/model/model.hpp"

/// The configuration manifold: q has model.nq() coordinates, tangent vectors have model.nv() components, in
/// the joints' left-trivialised directions. All functions throw std::invalid_argument for a wrong size, and for steps
/// so large that a result would not be finite.
namespace axode {

/// Every joint at zero, quaternions at the identity.
std::vector<double> neutral(const Model& model);

/// A configuration within the limits, uniform for each joint: unlimited angles in [-π, π], unlimited lengths
/// in [-1, 1] m, rotations uniform on SO(3). The same seed gives the same configuration.
std::vector<double> random_configuration(const Model& model, std::uint64_t seed);
/// n of them, one after the other: n * nq numbers, of which the first are random_configuration(model, seed).
std::vector<double> random_configurations(const Model& model, std::uint64_t seed, std::size_t n);

/// q with every quaternion brought to norm 1. Throws std::invalid_argument that names the joint where a norm is 0 or not
/// finite.
std::vector<double> normalize(const Model& model, std::span<const double> q);

/// q ⊕ dv: every joint moved along its left-trivialised direction dv.
std::vector<double> integrate(const Model& model, std::span<const double> q, std::span<const double> dv);

/// q1 ⊖ q0: the dv with q0 ⊕ dv = q1, by the shorter way round on rotations (a planar joint's angle is met up
/// to whole turns, a quaternion up to its sign).
std::vector<double> difference(const Model& model, std::span<const double> q0, std::span<const double> q1);

/// q0 ⊕ s (q1 ⊖ q0): screw motion of every joint, q0 at s = 0 and q1 at s = 1.
std::vector<double> interpolate(const Model& model, std::span<const double> q0, std::span<const double> q1,
                                double s);

/// q' = E(q) v: the rates of the coordinates, nq numbers, where the velocities are v. For a quaternion a it is
/// a (ω; 0) / 2, for the position of a free joint R v.
std::vector<double> coordinate_rates(const Model& model, std::span<const double> q,
                                     std::span<const double> v);
/// v, nv numbers, from the rates q' of the coordinates, E(q)⁺ q': the way back. Of a quaternion's rate the part along
/// the quaternion, which would change its norm, is left out.
std::vector<double> velocities_from_rates(const Model& model, std::span<const double> q,
                                          std::span<const double> dq);

/// The name of each coordinate and of each velocity: that of its joint, with a number where the joint has several, as in
/// `hip[0]`, `hip[1]`. Coupled and fixed joints have none. q[k] belongs to coordinate_names(model)[k]; v[k], a[k] and
/// tau[k] to velocity_names(model)[k].
std::vector<std::string> coordinate_names(const Model& model);
std::vector<std::string> velocity_names(const Model& model);

/// The largest speed (rad/s, m/s) and drive force (N m, N) for each velocity, nv numbers; infinite where there is no
/// limit. Those of coupled joints are on the joints, not on their leader's velocity.
std::vector<double> velocity_limits(const Model& model);
std::vector<double> effort_limits(const Model& model);

/// Lower and upper limit of each coordinate; infinite where there is none and for quaternions.
struct CoordinateLimits {
  std::vector<double> lower, upper;
};
CoordinateLimits limits(const Model& model);

/// The nearest configuration within the limits.
std::vector<double> clamp(const Model& model, std::span<const double> q);

/// Throws std::invalid_argument that names the caller's argument and the joint where q has the wrong size or
/// a quaternion's norm is off 1 by more than 1e-6 (1e-4 in float).
void check_configuration(const Model& model, std::span<const double> q, const char* argument = "q");
void check_configuration(const Model& model, std::span<const float> q, const char* argument = "q");

/// Throws std::invalid_argument that names the argument, the actual and the expected size.
void check_size(const char* argument, std::size_t actual, std::size_t expected, const char* meaning);

}  // namespace axode
