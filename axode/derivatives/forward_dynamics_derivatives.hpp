#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// Receives the matrices ∂a/∂q, ∂a/∂v and ∂a/∂τ, nv × nv numbers each, row by row, [component of a,
/// direction], and the accelerations a (nv, or an empty span). The spans must not overlap.
template <class T> struct ForwardDynamicsDerivatives {
  std::span<T> q, v, tau, a = {};
};

/// Computes the first derivatives of the accelerations a of forward dynamics at (q, v, τ): ∂a/∂τ = M⁻¹, and
/// ∂a/∂x = -M⁻¹ ∂τ/∂x for x = q and v, with the mass matrix M and the derivatives ∂τ/∂x of inverse dynamics
/// at the accelerations a. Column k of ∂a/∂q is the derivative along q ⊕ ε e_k. The components of loads are
/// constant in the representation in which they are given. If loads.joint_losses is set, damping and Coulomb
/// friction act; friction has the derivative 0. M⁻¹ is applied by articulated bodies, O(n) for each column,
/// or by products with M⁻¹ if there are at most 100 velocities. No allocation. If the status is not ok(), all
/// results are NaN. Throws std::invalid_argument for a wrong size, quaternions that are not of unit norm, a
/// load on a frame that does not exist and results whose memory overlaps. See (D1.24) of docs/derivations.
template <class T>
Solvability forward_dynamics_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                         Numbers<T> v, Numbers<T> tau,
                                         const std::type_identity_t<ForwardDynamicsDerivatives<T>>& da,
                                         const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
