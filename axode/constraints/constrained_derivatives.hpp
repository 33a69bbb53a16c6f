#pragma once
#include "axode/constraints/loops.hpp"
#include "axode/derivatives/products/products.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// Receives ∂a/∂q, ∂a/∂v and ∂a/∂τ (nv × nv each), and the derivatives of λ (loops().rows × nv each, may be
/// empty), row by row, [component, direction].
template <class T> struct ClosedDynamicsDerivatives {
  std::span<T> a_q, a_v, a_tau;
  std::span<T> lambda_q = {}, lambda_v = {}, lambda_tau = {};
};

/// First derivatives of forward dynamics with loops, by differentiating M a + h - Aᵀ λ = τ, A a + γ = 0 with
/// the rows that are independent at q (D7.15); the multipliers of the other rows are 0. If rows are redundant
/// by geometry (Bricard's mechanism), accelerations jump as the loops open: then only derivatives along
/// velocities that the loops allow are meaningful. Directions of q are those of q ⊕ ε e_k. Allocates; O((nv +
/// m)³). Throws std::invalid_argument for wrong sizes.
template <class T>
Solvability forward_dynamics_derivatives(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                         Numbers<T> v, Numbers<T> tau,
                                         const std::type_identity_t<ClosedDynamicsDerivatives<T>>& d,
                                         const std::type_identity_t<Loads<T>>& loads = {});

/// The derivative da (nv) of the accelerations along a direction (dq, dv, dtau), and the gradients of w·a by
/// q, v and tau: products of the matrices of forward_dynamics_derivatives with a vector, at the cost of the
/// matrices.
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
