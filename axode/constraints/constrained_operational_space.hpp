#pragma once
#include "axode/constraints/loops.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/recursion/solvability.hpp"

/// The response of a mechanism with loops to an impulse at a place (a frame on a body). A unit of impulse
/// changes the joint velocities by
///   (M⁻¹ - M⁻¹ Aᵀ (A M⁻¹ Aᵀ)⁺ A M⁻¹) Jᵀ
/// with the mass matrix M of the spanning tree, the Jacobian J of the place and the Jacobian A of the loop
/// equations A v = 0 (D7.14). The loops should be closed at q.
namespace axode {

/// Computes the change of the velocities for a unit of impulse at a place (a frame on a body) of a mechanism
/// with loops. Y has nv entries; the six components of entry c are the changes of velocity c for units of the
/// components of the impulse, in the representation Rep. O(n + m² d + m³), plus O(n + m d) for each of the
/// six components, for n bodies and m loop equations on paths of d joints. Throws std::invalid_argument for
/// wrong sizes and for a model with prescribed motions.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability impulse_response(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& place,
                             std::type_identity_t<std::span<Twist<Rep, T>>> Y);

/// Computes the matrix (36 entries) that maps an impulse at a place (a frame on a body) of a mechanism with
/// loops to the change of the place's twist. Impulse and twist are in the representation Rep, which
/// determines their axes and their point of reference. The matrix is symmetric and positive semi-definite.
/// Allocates.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability inverse_operational_space_inertia(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                              const std::type_identity_t<Place<T>>& place,
                                              std::type_identity_t<std::span<T>> Lambda_inverse);

/// Computes the apparent inertia (36 entries) at a place (a frame on a body) of a mechanism with loops, in
/// the representation Rep: the inverse of inverse_operational_space_inertia(). It is NaN unless the place can
/// move in all six directions; the returned Solvability has the number of `directions` in which it can move.
/// Allocates.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability operational_space_inertia(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                      const std::type_identity_t<Place<T>>& place,
                                      std::type_identity_t<std::span<T>> Lambda);

}  // namespace axode
