#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The equations of motion for the state (q, p) with the generalised momenta p = M(q) v. Computes the
/// velocities v = M⁻¹ p and the rates of the momenta (nv numbers each),
///   p'_i = τ_i + J_iᵀ W_i^A + (ad_{V_i} J_i)ᵀ Π_i^A.
/// Body i has the joint screw J_i and the twist V_i. Π_i^A is the momentum of its subtree, and W_i^A the
/// wrench of gravity and loads on the subtree. O(n). If the mass matrix is singular, the returned Solvability
/// names a body, and v and p' are NaN. See (D5.1) and (D5.9) of docs/derivations.
///
/// Rep is the representation of twists in the recursion; the results do not depend on it. In the spatial
/// representation momenta of bodies add up without a transformation. The hybrid one is that of Naudet et al.,
/// Multibody System Dynamics 10 (2003).
template <RecursionRepresentation Rep = Spatial, class T>
Solvability momentum_form(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                          Numbers<T> tau, std::type_identity_t<std::span<T>> v,
                          std::type_identity_t<std::span<T>> dp,
                          const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
