#pragma once
#include "axode/constraints/loops.hpp"
#include "axode/derivatives/products.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// Where ∂a/∂q, ∂a/∂v and ∂a/∂τ go, nv × nv each, and those of λ, loops().rows × nv each or empty, row by row, [component,
/// direction].
template <class T> struct ClosedDynamicsDerivatives {
  std::span<T> a_q, a_v, a_tau;
  std::span<T> lambda_q = {}, lambda_v = {}, lambda_tau = {};
};

/// The first derivatives of forward dynamics with loops, from the equations M a + h - Aᵀ λ = τ, A a + γ = 0 of the rows that
/// are independent at q; multipliers of the others are 0 and stay so. Where rows are redundant by geometry (Bricard's
/// mechanism) accelerations jump as the loops open: only derivatives along velocities that the loops allow mean
/// something. Directions of q are those of q ⊕ ε e_k. Allocates; O((nv + m)³). Throws std::invalid_argument for wrong sizes.
template <class T>
Solvability forward_dynamics_derivatives(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                         Numbers<T> v, Numbers<T> tau,
                                         const std::type_identity_t<ClosedDynamicsDerivatives<T>>& d,
                                         const std::type_identity_t<Loads<T>>& loads = {});

/// The derivative da (nv) of the accelerations along a direction (dq, dv, dtau), and the gradients of w a by q, v and tau: the
/// matrices of forward_dynamics_derivatives times a vector from either side, at their cost and with their meaning.
template <class T>
Solvability forward_dynamics_jvp(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                 Numbers<T> tau, Numbers<T> dq, Numbers<T> dv, Numbers<T> dtau,
                                 std::type_identity_t<std::span<T>> da,
                                 const std::type_identity_t<Loads<T>>& loads = {});
template <class T>
Solvability forward_dynamics_vjp(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                 Numbers<T> tau, Numbers<T> w,
                                 const std::type_identity_t<ForwardDynamicsGradients<T>>& gradient,
                                 const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
