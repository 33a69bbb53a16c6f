#pragma once
#include "axode/dynamics/loads.hpp"
#include "axode/dynamics/solvability.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

namespace axode {

/// The accelerations a that the drive forces tau make: M(q) a + C(q, v) v + g(q) = τ + (applied forces), the
/// inverse of inverse_dynamics with the same loads. a has nv entries. O(n) by the articulated-body algorithm;
/// where joints are coupled, O(n d²) by the mass matrix that they project. Where the mass matrix is singular
/// the status names a body, and a is NaN.
template <class Rep = Fast, class T>
Solvability forward_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             Numbers<T> tau, std::type_identity_t<std::span<T>> a,
                             const std::type_identity_t<Loads<T>>& loads = {});

/// M⁻¹ Jᵀ for a place: a column for each velocity, Y_c | W = jump of velocity c under a unit of impulse W at
/// the place. nv columns. O(n) for each of the six components.
template <class Rep = BodyFixed, class T>
Solvability impulse_response(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& place,
                             std::type_identity_t<std::span<Twist<Rep, T>>> Y);

/// J M⁻¹ Jᵀ for a place, 36 entries, symmetric: the twist that it gets from an impulse. Positive
/// semi-definite; its rank is the number of directions in which the place can move.
template <class Rep = BodyFixed, class T>
Solvability mobility(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                     const std::type_identity_t<Place<T>>& place,
                     std::type_identity_t<std::span<T>> mobility);

/// What came of an operational-space inertia.
struct [[nodiscard]] OperationalSpace {
  Solvability mass_matrix;
  int directions = 0;  ///< in which the place can move
  bool ok() const { return mass_matrix.ok() && directions == 6; }
};
/// Λ = (J M⁻¹ Jᵀ)⁻¹ of a place, 36 entries: the inertia that it shows to a wrench. NaN where the place cannot
/// move in all six directions (or nearly cannot: condition above 1e12 in double, 1e5 in float, after scaling
/// to a unit diagonal).
template <class Rep = BodyFixed, class T>
OperationalSpace operational_space_inertia(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                           const std::type_identity_t<Place<T>>& place,
                                           std::type_identity_t<std::span<T>> Lambda);

}  // namespace axode
