#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// Second derivatives contracted with weights w, as in optimal control, without a tensor.
///
/// Entry [k][l] of a block is the derivative along direction k, the outer one, of that along l. On a joint
/// with several velocities the displacement k of q comes first, q ⊕ ε_k e_k ⊕ ε_l e_l, and qq has an
/// antisymmetric part there, the derivative along the bracket [e_k, e_l]; elsewhere it is symmetric. nv × nv
/// each, row by row. Results must not overlap.
namespace axode {

/// Σ_i w_i ∂²τ_i of inverse dynamics: along (q, q), (q, v), (v, v), and (a, q). ∂²/∂v∂a and ∂²/∂a² vanish.
template <class T> struct InverseDynamicsHessian { std::span<T> qq, qv, vv, aq; };
/// O(n d), no allocation; less than twice inverse_dynamics_derivatives(). See (D2.8) of docs/derivations.
template <class T>
void inverse_dynamics_hessian(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                              Numbers<T> a, Numbers<T> w,
                              const std::type_identity_t<InverseDynamicsHessian<T>>& hessian,
                              const std::type_identity_t<Loads<T>>& loads = {});

/// Σ_i w_i ∂²a_i of forward dynamics: along (q, q), (q, v), (v, v), and (τ, q). Other second derivatives
/// vanish.
template <class T> struct ForwardDynamicsHessian { std::span<T> qq, qv, vv, tauq; };
/// O(n² d), no allocation. NaN if the status is not ok(). See (D2.9) of docs/derivations.
template <class T>
Solvability forward_dynamics_hessian(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                     Numbers<T> tau, Numbers<T> w,
                                     const std::type_identity_t<ForwardDynamicsHessian<T>>& hessian,
                                     const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
