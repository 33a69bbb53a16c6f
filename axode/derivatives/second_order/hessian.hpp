#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// Second derivatives contracted with weights w, as in optimal control, without a tensor.
///
/// Entry [k][l] of a block is the derivative along direction k, the outer one, of that along l. For a joint
/// with several velocities, the displacement k of q comes first, q ⊕ ε_k e_k ⊕ ε_l e_l. There qq has an
/// antisymmetric part, which is the derivative along the bracket [e_k, e_l]; elsewhere qq is symmetric. Each
/// block has nv × nv numbers, row by row. Results must not overlap.
namespace axode {

/// Receives the second derivatives of Σ_i w_i τ_i of inverse dynamics along (q, q), (q, v), (v, v) and (a,
/// q). Those along (v, a) and (a, a) vanish.
template <class T> struct InverseDynamicsHessian { std::span<T> qq, qv, vv, aq; };
/// Computes the second derivatives of Σ_i w_i τ_i at a state. O(n d), no allocation; less than twice
/// inverse_dynamics_derivatives(). See (D2.8) of docs/derivations.
template <class T>
void inverse_dynamics_hessian(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                              Numbers<T> a, Numbers<T> w,
                              const std::type_identity_t<InverseDynamicsHessian<T>>& hessian,
                              const std::type_identity_t<Loads<T>>& loads = {});

/// Receives the second derivatives of Σ_i w_i a_i of forward dynamics along (q, q), (q, v), (v, v) and (τ,
/// q). All others vanish.
template <class T> struct ForwardDynamicsHessian { std::span<T> qq, qv, vv, tauq; };
/// Computes the second derivatives of Σ_i w_i a_i at a state. O(n² d), no allocation. They are NaN if the
/// status is not ok(). See (D2.9) of docs/derivations.
template <class T>
Solvability forward_dynamics_hessian(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                     Numbers<T> tau, Numbers<T> w,
                                     const std::type_identity_t<ForwardDynamicsHessian<T>>& hessian,
                                     const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
