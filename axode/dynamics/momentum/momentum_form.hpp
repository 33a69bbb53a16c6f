#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The rates of (q, p) with the generalised momenta p = M(q) v: velocities v = M⁻¹ p and
///   p'_i = τ_i + J_iᵀ W_i^A + (ad_{V_i} J_i)ᵀ Π_i^A
/// with the momentum Π_i^A of the subtree of body i and the wrench W_i^A of gravity and loads on it. O(n),
/// without accelerations and their bias terms; v and dp have nv entries. If the mass matrix is singular, the
/// status names a body, and both results are NaN. See (D5.1) and (D5.9) of docs/derivations.
///
/// These are forward dynamics in the state (q, p). The recursion runs in twists of Rep, on which the results
/// do not depend. In spatial twists momenta of bodies add up without a transformation. Hybrid twists are
/// those of Naudet et al., Multibody System Dynamics 10 (2003).
template <RecursionRepresentation Rep = Spatial, class T>
Solvability momentum_form(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                          Numbers<T> tau, std::type_identity_t<std::span<T>> v,
                          std::type_identity_t<std::span<T>> dp,
                          const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
