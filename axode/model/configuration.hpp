#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "axode/model/model.hpp"

/// The configuration manifold. q has model.nq() coordinates; tangent vectors have model.nv() components, in
/// the left-trivialised directions of the joints. All functions throw std::invalid_argument for a wrong size,
/// and for steps so large that a result would not be finite.
namespace axode {

/// The configuration with every coordinate 0 and every quaternion the identity.
std::vector<double> neutral(const Model& model);

/// A configuration and velocities.
struct InitialState {
  std::vector<double> q, v;  ///< nq and nv numbers
};
/// The state in which a motion of the mechanism starts, as its description says: see
/// InitialStateDescription. Joints that the description does not name are at 0 and at rest.
InitialState initial_state(const Model& model);

/// A random configuration within the limits, uniform for each joint: unlimited angles in [-π, π], unlimited
/// lengths in [-1, 1] m, rotations uniform on SO(3). The same seed gives the same configuration.
std::vector<double> random_configuration(const Model& model, std::uint64_t seed);
/// n random configurations, one after the other: n * nq numbers. The first is random_configuration(model,
/// seed).
std::vector<double> random_configurations(const Model& model, std::uint64_t seed, std::size_t n);

/// The configuration q with every quaternion scaled to norm 1. Throws std::invalid_argument with the name of
/// the joint if a norm is 0 or not finite.
std::vector<double> normalize(const Model& model, std::span<const double> q);

/// Computes q ⊕ dv: the configuration after every joint has moved along its left-trivialised direction dv.
std::vector<double> integrate(const Model& model, std::span<const double> q, std::span<const double> dv);

/// Computes q1 ⊖ q0: the dv with q0 ⊕ dv = q1. Rotations go the shorter way round, so that the angle of a
/// planar joint is reached up to whole turns, and a quaternion up to its sign.
std::vector<double> difference(const Model& model, std::span<const double> q0, std::span<const double> q1);

/// Computes q0 ⊕ s (q1 ⊖ q0): a screw motion of every joint from q0 at s = 0 to q1 at s = 1.
std::vector<double> interpolate(const Model& model, std::span<const double> q0, std::span<const double> q1,
                                double s);

/// Computes q' = E(q) v: the rates of the nq coordinates at velocities v. The rate of a quaternion a is a (ω;
/// 0) / 2, and the rate of the position of a free joint is R v.
std::vector<double> coordinate_rates(const Model& model, std::span<const double> q,
                                     std::span<const double> v);
/// Computes v = E(q)⁺ q': the nv velocities from the rates q' of the coordinates. The part of a quaternion's
/// rate that would change its norm is left out.
std::vector<double> velocities_from_rates(const Model& model, std::span<const double> q,
                                          std::span<const double> dq);

/// The names of the coordinates and of the velocities. Each is the name of its joint, with a number if the
/// joint has several, as in `hip[0]`, `hip[1]`. Coupled and fixed joints have none. q[k] belongs to
/// coordinate_names(model)[k]; v[k], a[k] and tau[k] belong to velocity_names(model)[k].
std::vector<std::string> coordinate_names(const Model& model);
std::vector<std::string> velocity_names(const Model& model);

/// The largest speed (rad/s, m/s), and below the largest drive force (N m, N), for each velocity: nv numbers,
/// infinite if there is no limit. Limits of coupled joints are not included: they hold for the joints, not
/// for the velocity of their leader.
std::vector<double> velocity_limits(const Model& model);
std::vector<double> effort_limits(const Model& model);

/// Lower and upper limit of each coordinate. They are infinite if there is no limit, and for quaternions.
struct CoordinateLimits {
  std::vector<double> lower, upper;
};
CoordinateLimits limits(const Model& model);

/// The nearest configuration within the limits.
std::vector<double> clamp(const Model& model, std::span<const double> q);

/// Throws std::invalid_argument with the name of the argument and the joint if q has the wrong size, or if
/// the norm of a quaternion differs from 1 by more than 1e-6 (1e-4 in float).
void check_configuration(const Model& model, std::span<const double> q, const char* argument = "q");
void check_configuration(const Model& model, std::span<const float> q, const char* argument = "q");

/// A sentence about the first number of q (nq) and v (nv, or empty) that is not finite, as in `q of joint "a"
/// is nan`. Empty if all are finite.
std::string first_not_finite(const Model& model, std::span<const double> q, std::span<const double> v);

/// Throws std::invalid_argument with the name of the argument, the actual and the expected size, if these
/// differ.
void check_size(const char* argument, std::size_t actual, std::size_t expected, const char* meaning);

}  // namespace axode
