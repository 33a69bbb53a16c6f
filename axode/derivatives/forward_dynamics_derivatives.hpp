#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// Where ∂a/∂q, ∂a/∂v and ∂a/∂τ go: nv × nv each, row by row, [component of a, direction]; and a, where it is wanted. They may
/// not overlap.
template <class T> struct ForwardDynamicsDerivatives {
  std::span<T> q, v, tau, a = {};
};

/// The first derivatives of forward dynamics at a state, ∂a/∂τ = M⁻¹ among them: -M⁻¹ times those of inverse dynamics at
/// the accelerations a. Terms as there. Articulated bodies on all columns, O(n) for each of them, or products with M⁻¹ on
/// short paths; no allocation. Where the status is not ok(), everything is NaN.
/// See (D1.24) of docs/derivations.
template <class T>
Solvability forward_dynamics_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                         Numbers<T> v, Numbers<T> tau,
                                         const std::type_identity_t<ForwardDynamicsDerivatives<T>>& da,
                                         const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
