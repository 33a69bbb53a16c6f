#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "axode/model/model.hpp"

/// Functions on the configuration manifold. A configuration q has nq numbers. A tangent vector has nv
/// numbers, which are left-trivialised: for each joint they are components in the joint frame of the moved
/// body. Functions with arguments q, v or dv throw std::invalid_argument if one has the wrong size, if a
/// quaternion in q is not of unit norm (except normalize()), or if the result is not finite.
namespace axode {

/// The configuration with every coordinate 0 and every quaternion the identity.
std::vector<double> neutral(const Model& model);

/// The coordinates and velocities of a mechanism at one time.
struct InitialState {
  std::vector<double> q, v;  ///< nq and nv numbers
};
/// The initial state from the description. Joints that it does not name are at zero and at rest.
InitialState initial_state(const Model& model);

/// A random configuration within the limits, uniform for each joint. Without limits, angles are in [-π, π]
/// and lengths in [-1, 1] m; with one limit, they are at most 2π rad or 2 m away from it. Rotations are
/// uniform on SO(3). The same seed gives the same result.
std::vector<double> random_configuration(const Model& model, std::uint64_t seed);
/// n random configurations, n * nq numbers; the first one is random_configuration(model, seed).
std::vector<double> random_configurations(const Model& model, std::uint64_t seed, std::size_t n);

/// The configuration q with every quaternion scaled to norm 1. Throws std::invalid_argument with the name of
/// the joint if a norm is 0 or not finite.
std::vector<double> normalize(const Model& model, std::span<const double> q);

/// Computes q ⊕ dv: the configuration after every joint has moved along its left-trivialised direction dv.
std::vector<double> integrate(const Model& model, std::span<const double> q, std::span<const double> dv);

/// Computes q1 ⊖ q0: the tangent vector dv (nv numbers) with q0 ⊕ dv = q1, where q0 ⊕ dv is q0 displaced by
/// exp(dv) in each joint. Rotations go the shorter way round, so that q0 ⊕ dv can differ from q1 by whole
/// turns of planar joints and by the sign of quaternions.
std::vector<double> difference(const Model& model, std::span<const double> q0, std::span<const double> q1);

/// Computes q0 ⊕ s (q1 ⊖ q0): joints move along constant screws, from q0 at s = 0 to q1 at s = 1, or beyond.
std::vector<double> interpolate(const Model& model, std::span<const double> q0, std::span<const double> q1,
                                double s);

/// Computes the rates q' = E(q) v of the nq coordinates at velocities v (nv numbers). A quaternion a whose
/// joint has the angular velocity ω has as its rate half the quaternion product of a and (ω; 0). The position
/// of a free joint has the rate R u with the rotation R of the joint and its linear velocity u.
std::vector<double> coordinate_rates(const Model& model, std::span<const double> q,
                                     std::span<const double> v);
/// Computes v = E(q)⁺ q', the nv velocities from the nq rates; changes of quaternion norms have no influence.
std::vector<double> velocities_from_rates(const Model& model, std::span<const double> q,
                                          std::span<const double> dq);

/// The names of the nq coordinates, and of the nv velocities (also those of a and tau). A name is the name of
/// the joint, with an index if the joint has several, as in `hip[0]`, `hip[1]`. Fixed joints have no
/// coordinate and hence no name. A joint that is coupled to another one, its leader, has none either: it
/// moves with the coordinate of the leader.
std::vector<std::string> coordinate_names(const Model& model);
std::vector<std::string> velocity_names(const Model& model);

/// The largest speeds (rad/s, m/s) and drive forces (N m, N) for each of the nv velocities, infinite if there
/// is no limit. Limits of joints that are coupled to another joint are not included.
std::vector<double> velocity_limits(const Model& model);
std::vector<double> effort_limits(const Model& model);

/// The lower and upper limits of the nq coordinates, infinite without a limit and for quaternions.
struct CoordinateLimits {
  std::vector<double> lower, upper;
};
CoordinateLimits limits(const Model& model);

/// The configuration q with each coordinate that exceeds a limit set to this limit.
std::vector<double> clamp(const Model& model, std::span<const double> q);

/// Throws std::invalid_argument if q has another size than nq, or if the norm of a quaternion differs from 1
/// by more than 1e-6 (1e-4 in float).
void check_configuration(const Model& model, std::span<const double> q, const char* argument = "q");
void check_configuration(const Model& model, std::span<const float> q, const char* argument = "q");

/// A sentence about the first number that is not finite, as in `q of joint "a" is nan`; empty if all are.
std::string first_not_finite(const Model& model, std::span<const double> q, std::span<const double> v);

/// Throws std::invalid_argument if the sizes differ. `meaning` names the expected size, such as `nq`.
void check_size(const char* argument, std::size_t actual, std::size_t expected, const char* meaning);

}  // namespace axode
