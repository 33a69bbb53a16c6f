#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// Products of the derivative matrices of inverse and forward dynamics with vectors, without the matrices:
/// O(n), no allocation. Vectors have nv entries. A direction dq displaces q to q ⊕ ε dq. The components of
/// loads are constant in the representation in which they are given. If loads.joint_losses is set, damping
/// and Coulomb friction act; friction has the derivative 0.
namespace axode {

/// Computes δτ = ∂τ/∂q dq + ∂τ/∂v dv + ∂τ/∂a da of inverse dynamics at (q, v, a). It takes about two and a
/// half times as long as inverse dynamics. See (D1.20) of docs/derivations.
template <class T>
void inverse_dynamics_jvp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                          Numbers<T> a, Numbers<T> dq, Numbers<T> dv, Numbers<T> da,
                          std::type_identity_t<std::span<T>> dtau,
                          const std::type_identity_t<Loads<T>>& loads = {});

/// Receives the gradients of w·τ by q, v and a, nv entries each. They must not overlap.
template <class T> struct InverseDynamicsGradients { std::span<T> q, v, a; };
/// Computes the gradient of w·τ, the sum of the forces τ of inverse dynamics with weights w: wᵀ times the
/// three matrices ∂τ/∂q, ∂τ/∂v and ∂τ/∂a. See (D1.22) of docs/derivations.
template <class T>
void inverse_dynamics_vjp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                          Numbers<T> a, Numbers<T> w,
                          const std::type_identity_t<InverseDynamicsGradients<T>>& gradient,
                          const std::type_identity_t<Loads<T>>& loads = {});

/// Computes δa = ∂a/∂q dq + ∂a/∂v dv + ∂a/∂τ dtau of forward dynamics at (q, v, τ). The result is NaN if the
/// status is not ok(). See (D1.24) of docs/derivations.
template <class T>
Solvability forward_dynamics_jvp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                 Numbers<T> tau, Numbers<T> dq, Numbers<T> dv, Numbers<T> dtau,
                                 std::type_identity_t<std::span<T>> da,
                                 const std::type_identity_t<Loads<T>>& loads = {});

/// Receives the gradients of w·a by q, v and τ, nv entries each. They must not overlap.
template <class T> struct ForwardDynamicsGradients { std::span<T> q, v, tau; };
/// Computes the gradient of w·a, the sum of the accelerations a of forward dynamics with weights w, with
/// respect to q, v and τ. It is NaN if the status is not ok(). See (D1.24) of docs/derivations.
template <class T>
Solvability forward_dynamics_vjp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                 Numbers<T> tau, Numbers<T> w,
                                 const std::type_identity_t<ForwardDynamicsGradients<T>>& gradient,
                                 const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
