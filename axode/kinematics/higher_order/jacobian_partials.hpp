#pragma once
#include <functional>

#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

/// Partial derivatives of any order of Jacobians J with respect to the configuration, computed as nested Lie
/// brackets of joint screws. A derivative is taken along a left-trivialised direction e_k of a joint: d/dε of
/// J(q ⊕ ε e_k) at ε = 0.
namespace axode {

[[deprecated("jacobian_partials() has no largest order")]]  //
inline constexpr int largest_partial_order = 12;

/// The partial derivatives ∂^ν J / ∂q_αν ... ∂q_α1 of the Jacobian of a place (a frame or a point on a body),
/// as a dense tensor: nv^(ν + 1) columns; J[((αν nv + ...) nv + α1) nv + j] is the column of velocity j. The
/// derivative along α1 is taken first; the order matters only between directions of one spherical, planar or
/// free joint. Body-fixed: Müller's eqs. der1, der2Jb, nthorderBody; spatial: eqs. Jsder, Jsder2, nthorder;
/// hybrid and mixed: (D15.4) of docs/derivations. For the first order this is eq. Jhder for ∂J_j/∂q_k,
/// completed by the case k < j, in which joint k is between joint j and the ground (errata 6 to 12). Any
/// order ν >= 0 is allowed. O(ν m^(ν + 1)) for m joint screws between the place and the ground; the number of
/// allocations does not depend on the order. The caller's function should_continue() is called from time to
/// time; if it returns false, the call ends early and the tensor is not complete.
template <RecursionRepresentation Rep = BodyFixed, class T>
void jacobian_partials(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                       const std::type_identity_t<Place<T>>& place, int order,
                       std::type_identity_t<std::span<Twist<Rep, T>>> J,
                       const std::function<bool()>& should_continue = {});

/// The directional derivative D_uν ... D_u1 J of the Jacobian of a place (a frame or a point on a body), nv
/// columns: the tensor of its partial derivatives contracted with one direction u for each derivative.
/// `directions` has `order` rows of nv numbers, the innermost direction u1 first. Any order >= 0 is allowed.
/// If no two consecutive directions are equal, the cost is O(m 3^order) screw products for m joint screws
/// between the place and the ground, and (m + order) 2^order screws are allocated. A run of k equal
/// consecutive directions reduces both: it counts as one direction in the sum m + order, and in the powers
/// its factor is (k + 1)(k + 2)/2 instead of 3^k, and k + 1 instead of 2^k. Throws std::invalid_argument for
/// a number of screws that no memory can hold.
template <RecursionRepresentation Rep = BodyFixed, class T>
void jacobian_derivative_along(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                               const std::type_identity_t<Place<T>>& place, int order, Numbers<T> directions,
                               std::type_identity_t<std::span<Twist<Rep, T>>> J);

}  // namespace axode
