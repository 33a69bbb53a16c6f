#pragma once
#include "axode/constraints/loops.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/recursion/solvability.hpp"

/// The response of a mechanism with loops to an impulse at a place, which is a frame or a point on a body.
/// The loops transmit impulses. Hence a unit of impulse changes the velocities by
///   (M⁻¹ - M⁻¹ Aᵀ (A M⁻¹ Aᵀ)⁺ A M⁻¹) Jᵀ
/// with the mass matrix M of the spanning tree, the Jacobian J of the place and the Jacobian A of the loop
/// equations A v = 0; the matrix before Jᵀ is Φ of (D7.14). The configuration q should close the loops, see
/// assemble().
namespace axode {

/// Computes the change of the velocities for a unit of impulse at a place (a frame or a point on a body) of a
/// mechanism with loops. Y has nv entries. Entry c has six components, each the change of velocity c for a
/// unit of one component of the impulse, in the representation Rep. O(n + m² d + m³), and O(n + m d) for each
/// of the six components, for n bodies and m loop equations on paths of d joints. Throws
/// std::invalid_argument for wrong sizes and for a model with prescribed motions.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability impulse_response(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& place,
                             std::type_identity_t<std::span<Twist<Rep, T>>> Y);

/// Computes the 6 × 6 matrix that maps an impulse at a place (a frame or a point on a body) of a mechanism
/// with loops to the change of the twist of the place. It has 36 entries and is symmetric and positive
/// semi-definite. Allocates.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability inverse_operational_space_inertia(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                              const std::type_identity_t<Place<T>>& place,
                                              std::type_identity_t<std::span<T>> Lambda_inverse);

/// Computes the apparent inertia at a place (a frame or a point on a body) of a mechanism with loops, 36
/// entries: the inverse of the matrix of inverse_operational_space_inertia(). It is NaN unless the place can
/// move in all six directions; `directions` of the returned Solvability is the number of directions in which
/// the place can move. Allocates.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability operational_space_inertia(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                      const std::type_identity_t<Place<T>>& place,
                                      std::type_identity_t<std::span<T>> Lambda);

}  // namespace axode
