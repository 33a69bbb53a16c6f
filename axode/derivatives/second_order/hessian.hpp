#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// Second derivatives of a weighted sum of the forces τ of inverse dynamics or of the accelerations a of
/// forward dynamics.
///
/// For a pair of variables, for example (q, v), they are a matrix of nv × nv numbers, row by row. Its entry
/// [k][l] is the derivative by component k of the first variable (outer) and component l of the second one
/// (inner). Derivatives by q are along the left-trivialised unit directions e_k. In the matrix for (q, q),
/// the displacement along e_k comes first: q ⊕ ε_k e_k ⊕ ε_l e_l. Hence this matrix is symmetric except for
/// two directions of one joint with several velocities, where the entries [k][l] and [l][k] differ by the
/// derivative along the bracket [e_k, e_l]. Results must not overlap.
namespace axode {

/// Receives the second derivatives of Σ_i w_i τ_i, the forces of inverse dynamics with weights w, by the
/// pairs of variables (q, q), (q, v), (v, v) and (a, q): for each pair a matrix of nv × nv numbers, row by
/// row, with a row for each component of the first variable. The second derivatives by (v, a) and (a, a) are
/// 0.
template <class T> struct InverseDynamicsHessian { std::span<T> qq, qv, vv, aq; };
/// Computes the second derivatives of Σ_i w_i τ_i, the forces of inverse dynamics with weights w, at (q, v,
/// a). O(n d) on paths of d velocities, no allocation; takes less than twice as long as the first
/// derivatives. See (D2.8) of docs/derivations.
template <class T>
void inverse_dynamics_hessian(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                              Numbers<T> a, Numbers<T> w,
                              const std::type_identity_t<InverseDynamicsHessian<T>>& hessian,
                              const std::type_identity_t<Loads<T>>& loads = {});

/// Receives the second derivatives of Σ_i w_i a_i, the accelerations of forward dynamics with weights w, by
/// the pairs of variables (q, q), (q, v), (v, v) and (τ, q): for each pair a matrix of nv × nv numbers, row
/// by row, with a row for each component of the first variable. The second derivatives by (τ, v) and (τ, τ)
/// are 0.
template <class T> struct ForwardDynamicsHessian { std::span<T> qq, qv, vv, tauq; };
/// Computes the second derivatives of Σ_i w_i a_i, the accelerations of forward dynamics with weights w, at
/// (q, v, τ). O(n² d) on paths of d velocities, no allocation. The results are NaN if the status is not ok().
/// See (D2.9) of docs/derivations.
template <class T>
Solvability forward_dynamics_hessian(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                     Numbers<T> tau, Numbers<T> w,
                                     const std::type_identity_t<ForwardDynamicsHessian<T>>& hessian,
                                     const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
