#pragma once
#include "axode/constraints/loops.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/recursion/solvability.hpp"

/// The response of a mechanism with loops to an impulse at a place. The loops transmit impulses, so that the
/// velocities change by
///   (M⁻¹ - M⁻¹ Aᵀ (A M⁻¹ Aᵀ)⁺ A M⁻¹) Jᵀ
/// for a unit of impulse. q should be closed, see assemble().
namespace axode {

/// Computes the change of every velocity for a unit of impulse at a place, nv columns as without loops. O(n +
/// m² d + m³), and O(n + m d) for each of the six components, for m rows on paths of d joints.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability impulse_response(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& place,
                             std::type_identity_t<std::span<Twist<Rep, T>>> Y);

/// Computes the matrix from an impulse at a place to the change of its twist, 36 entries, symmetric and
/// positive semi-definite. Allocates.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability inverse_operational_space_inertia(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                              const std::type_identity_t<Place<T>>& place,
                                              std::type_identity_t<std::span<T>> Lambda_inverse);

/// The inverse of the mobility, 36 entries: the apparent inertia at the place. NaN unless the place can move
/// in all six directions; Solvability has the number of directions. Allocates.
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability operational_space_inertia(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                      const std::type_identity_t<Place<T>>& place,
                                      std::type_identity_t<std::span<T>> Lambda);

}  // namespace axode
