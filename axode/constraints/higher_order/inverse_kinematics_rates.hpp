#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

namespace axode {

/// The wanted motion of a place, which is a frame on a body: the twist V of the frame, and the time
/// derivatives V', V'', ... of the components of V in the representation Rep. If the place is given as a
/// point of another frame, its frame has the axes of that frame and its origin at the point.
template <RecursionRepresentation Rep = BodyFixed> struct TwistTarget {
  Place<> place;
  std::span<const TwistRate<Rep>> V;
  bool angular = true, linear = true;  ///< whether the angular and the linear part of V are wanted; the other
                                       ///< part is left free
};

/// How many derivatives of a wanted motion the joints can produce.
struct RatesReached {
  int orders = 0;      ///< number of leading terms of V, V', V'', ... that the joints can produce
  double missing = 0;  ///< if this is not all: the part of the next derivative, relative to its terms, that
                       ///< no joint can produce
};

/// Inverse kinematics of any order. Computes the velocities of the joints and their time derivatives v, v',
/// v'', ... (`rates`, K rows of nv numbers, in the left-trivialised directions of the joints), such that
/// places (frames on bodies) have given twists V and derivatives V', V'', ..., and loops stay closed. For
/// each place, `targets` has V and the first K - 1 derivatives. The k-th derivatives are solutions of a
/// linear system with the Jacobians J of the places and A of the loop equations A v = 0, the same for all k
/// (D3.13):
///   J v^(k) = V^(k) - (terms of V^(k) with lower derivatives of v)
///   A v^(k) = -(terms of (A v)^(k) with lower derivatives of v)
/// If the targets do not determine the motion of the joints, the v^(k) with the least Euclidean norm is taken
/// for each k. If they require a motion that the joints cannot make, as in a singular configuration, the rows
/// from that order on are NaN. The rounding error of derivative k grows like a power k of the condition
/// number of J.
///
/// Throws std::invalid_argument for wrong sizes, numbers that are not finite, a q at which a loop is open
/// and, with loops, more than 8 orders. Allocates; O(K nv³ + n K³).
template <RecursionRepresentation Rep = BodyFixed>
[[nodiscard]] RatesReached inverse_kinematics_rates(
    const Model& model, Numbers<double> q, std::type_identity_t<std::span<const TwistTarget<Rep>>> targets,
    std::span<double> rates);

}  // namespace axode
