#pragma once
#include "axode/constraints/loops.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/recursion/solvability.hpp"

/// The response of a mechanism with loops to an impulse at a place. The loops transmit impulses. Hence a unit
/// of impulse changes the velocities by
///   (M⁻¹ - M⁻¹ Aᵀ (A M⁻¹ Aᵀ)⁺ A M⁻¹) Jᵀ
/// with the Jacobian J of the place and the rows A of the loops. q should be closed, see assemble().
namespace axode {

/// Computes the change of every velocity for a unit of impulse at a place, in nv columns, as the function for
/// trees does. O(n + m² d + m³), and O(n + m d) for each of the six components, for m rows on paths of d
/// joints.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability impulse_response(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& place,
                             std::type_identity_t<std::span<Twist<Rep, T>>> Y);

/// Computes the 6 × 6 matrix that maps an impulse at a place to the change of the twist of the place, 36
/// entries, symmetric and positive semi-definite. Allocates.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability inverse_operational_space_inertia(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                              const std::type_identity_t<Place<T>>& place,
                                              std::type_identity_t<std::span<T>> Lambda_inverse);

/// Computes the apparent inertia at a place, the inverse of the matrix of inverse_frame_inertia(), 36
/// entries. It is NaN unless the place can move in all six directions; the returned Solvability has the
/// number of directions in which it can. Allocates.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability operational_space_inertia(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                      const std::type_identity_t<Place<T>>& place,
                                      std::type_identity_t<std::span<T>> Lambda);

}  // namespace axode
