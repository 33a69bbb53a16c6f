#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

namespace axode {

/// The wanted motion of a place: its twist and the time derivatives of the components of the twist in Rep, V,
/// V', V'', ..., as HigherOrderMotion::twist_derivative() has them.
template <RecursionRepresentation Rep = BodyFixed> struct TwistTarget {
  Place<> place;
  std::span<const TwistRate<Rep>> V;
  bool angular = true, linear = true;  ///< the parts of V that are wanted; the others are left free
};

/// How far joints can produce a wanted motion.
struct RatesReached {
  int orders = 0;      ///< how many of V, V', V'', ... the joints produce
  double missing = 0;  ///< the part of the next one, relative to its terms, that no joint produces
};

/// Inverse kinematics of any order: the velocities of the joints and their time derivatives v, v', v'', ...
/// (`rates`, K rows of nv, in the left-trivialised directions of the joints) with which places move as K
/// derivatives of their twists say, and loops stay closed. Each derivative follows from one linear system
/// with the same matrix, (D3.13):
///   J v^(k) = V^(k) - (terms with lower derivatives of v),   A v^(k) = -(the same terms of A v).
/// If the targets leave freedoms, each derivative is the least one by its norm. If they ask for a motion that
/// the joints cannot make, as in a singular configuration, the rows from that order on are NaN. Derivatives
/// of order k lose digits like a power of the condition number of J.
///
/// Throws std::invalid_argument for wrong sizes, numbers that are not finite, a q that leaves a loop open,
/// and, with loops, more than 8 orders. Allocates; O(K nv³ + n K³).
template <RecursionRepresentation Rep = BodyFixed>
[[nodiscard]] RatesReached inverse_kinematics_rates(
    const Model& model, Numbers<double> q, std::type_identity_t<std::span<const TwistTarget<Rep>>> targets,
    std::span<double> rates);

}  // namespace axode
