#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/recursion/solvability.hpp"

/// The response of a place (a frame on a body) to a wrench or an impulse on it.
namespace axode {

/// Computes Y = M⁻¹ Jᵀ for the Jacobian J of a place (a frame on a body) and the mass matrix M, as nv twists
/// Y_c: an impulse W on the place changes velocity c by Y_cᵀ W. O(n) for each of the six components of W. If
/// the mass matrix is singular, the returned Solvability says so, and Y is NaN.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability impulse_response(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& place,
                             std::type_identity_t<std::span<Twist<Rep, T>>> Y);

/// Computes the inverse operational-space inertia J M⁻¹ Jᵀ (36 entries, symmetric) for the Jacobian J of a
/// place (a frame on a body) and the mass matrix M. It maps an impulse on the place to the jump of its twist;
/// its rank is the number of directions in which the place can move. If the mass matrix is singular, the
/// result is NaN.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability inverse_operational_space_inertia(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                              const std::type_identity_t<Place<T>>& place,
                                              std::type_identity_t<std::span<T>> Lambda_inverse);

/// Computes the operational-space inertia (J M⁻¹ Jᵀ)⁻¹ (36 entries) for the Jacobian J of a place (a frame on
/// a body) and the mass matrix M: the apparent inertia of the place against a wrench. If the place cannot
/// move in all six directions, the result is NaN, and the returned Solvability has the number of directions
/// in which it can move. A place counts as unable to move in all six directions if the condition number of J
/// M⁻¹ Jᵀ, scaled to a unit diagonal, is above 1e12 in double or 1e5 in float.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability operational_space_inertia(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                      const std::type_identity_t<Place<T>>& place,
                                      std::type_identity_t<std::span<T>> Lambda);

}  // namespace axode
