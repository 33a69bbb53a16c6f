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

/// The partial derivatives of any order ν >= 0 of the Jacobian J of a place (a frame on a body), as a dense
/// tensor of nv^(ν + 1) columns. Column ((αν nv + ...) nv + α1) nv + j is ∂^ν J_j / ∂q_αν ... ∂q_α1, the
/// derivative of the column J_j of velocity j along α1 first. The order of derivatives matters only between
/// directions of one spherical, planar or free joint. Body-fixed: Müller's eqs. der1, der2Jb, nthorderBody;
/// spatial: eqs. Jsder, Jsder2, nthorder; hybrid and mixed: (D15.4) of docs/derivations. Müller's eq. Jhder,
/// the first derivative ∂J_j/∂q_k in the hybrid representation, is completed by the case k < j, in which
/// joint k is between joint j and the ground; the paper leaves it out, which causes errata 6 and 9 of
/// docs/errata.md. docs/notation.md names Müller's paper, to which the labels and errata refer.
/// O(ν m^(ν + 1)) for m joint screws between the place and the ground. If the caller's function
/// should_continue() returns false, the call ends early and the tensor is not complete.
template <RecursionRepresentation Rep = BodyFixed, class T>
void jacobian_partials(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                       const std::type_identity_t<Place<T>>& place, int order,
                       std::type_identity_t<std::span<Twist<Rep, T>>> J,
                       const std::function<bool()>& should_continue = {});

/// The directional derivative D_uν ... D_u1 J of the Jacobian of a place (a frame on a body), nv columns: the
/// tensor of its partial derivatives of order ν contracted with one direction u for each derivative.
/// `directions` has ν >= 0 rows of nv numbers, the innermost direction u1 first. Consecutive directions that
/// are equal form a run. For m joint screws between the place and the ground and R runs of k_1, ..., k_R
/// directions, the cost is O(m Π (k_r + 1)(k_r + 2)/2) screw products, and (m + R) Π (k_r + 1) screws are
/// allocated: two runs of 500 directions take 10^10 products for each joint screw. If the caller's function
/// should_continue(), which is called within every few milliseconds, returns false, the call ends early and
/// the columns have no meaning. Throws std::invalid_argument for a number of screws that no memory can hold.
template <RecursionRepresentation Rep = BodyFixed, class T>
void jacobian_derivative_along(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                               const std::type_identity_t<Place<T>>& place, int order, Numbers<T> directions,
                               std::type_identity_t<std::span<Twist<Rep, T>>> J,
                               const std::function<bool()>& should_continue = {});

}  // namespace axode
