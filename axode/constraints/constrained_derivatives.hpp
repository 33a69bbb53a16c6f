#pragma once
#include "axode/constraints/loops.hpp"
#include "axode/derivatives/products/products.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// Receives the derivatives of the accelerations of a mechanism with loops by q, v and τ (nv × nv each), and
/// the derivatives of the multipliers λ of the loops (a row of nv numbers for each of the loops().rows
/// equations), which may be empty. Matrices are stored row by row: a row belongs to a component of the
/// result, and a column to a direction of q, v or τ.
template <class T> struct ClosedDynamicsDerivatives {
  std::span<T> a_q, a_v, a_tau;
  std::span<T> lambda_q = {}, lambda_v = {}, lambda_tau = {};
};

/// Computes the first derivatives by q, v and τ of the accelerations a and multipliers λ of forward dynamics
/// with loops, M a + h - Aᵀ λ = τ and A a + γ = 0, where M is the mass matrix and h the bias force of the
/// spanning tree, A v = 0 are the loop equations, and γ = A' v. Derivatives by q are along q ⊕ ε e_k with the
/// unit vectors e_k. If loop equations are redundant, only independent ones are used (D7.15), and the
/// multipliers of the others are 0. If equations are redundant by geometry (Bricard's mechanism), only
/// derivatives along velocities v with A v = 0 are meaningful. Springs are ignored. Allocates; O((nv + m)³)
/// for m loop equations. Throws std::invalid_argument for wrong sizes and for a model with prescribed
/// motions.
template <class T>
Solvability forward_dynamics_derivatives(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                         Numbers<T> v, Numbers<T> tau,
                                         const std::type_identity_t<ClosedDynamicsDerivatives<T>>& d,
                                         const std::type_identity_t<Loads<T>>& loads = {});

/// Products of vectors with the derivatives of forward dynamics with loops. forward_dynamics_jvp() computes
/// the change da (nv) of the accelerations along a direction (dq, dv, dtau). forward_dynamics_vjp() computes
/// the gradients of w·a by q, v and tau for weights w (nv) of the accelerations a. Each costs as much as the
/// matrices of all derivatives.
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
