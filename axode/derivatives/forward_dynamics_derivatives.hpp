#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// Receives ∂a/∂q, ∂a/∂v and ∂a/∂τ, nv × nv numbers each, row by row, [component of a, direction], and the
/// accelerations a. A span that is empty receives nothing. The spans must not overlap.
template <class T> struct ForwardDynamicsDerivatives {
  std::span<T> q, v, tau, a = {};
};

/// First derivatives of forward dynamics at a state, with ∂a/∂τ = M⁻¹: -M⁻¹ times the derivatives of inverse
/// dynamics at the accelerations a, with the same directions and terms. M⁻¹ is applied by articulated bodies,
/// O(n) for each column, or by products with M⁻¹ if paths are short. No allocation. If the status is not
/// ok(), all results are NaN. See (D1.24) of docs/derivations.
template <class T>
Solvability forward_dynamics_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                         Numbers<T> v, Numbers<T> tau,
                                         const std::type_identity_t<ForwardDynamicsDerivatives<T>>& da,
                                         const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
