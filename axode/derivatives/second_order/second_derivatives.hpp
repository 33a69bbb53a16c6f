#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/solvability.hpp"

/// Second derivatives of every component of τ or a, without loads. A tensor has nv × nv × nv numbers,
/// [component][outer derivative][inner derivative]. For the outer direction k and the inner direction l of
/// q they are derivatives of a function of q ⊕ ε_k e_k ⊕ ε_l e_l: if k and l belong to one joint with
/// several velocities, q is displaced along k first, and then along l. If only a weighted sum of the
/// components is needed, the functions in hessian.hpp are faster. No allocation. Results must not overlap.
namespace axode {

/// Receives the second derivatives of τ of inverse dynamics along the pairs of directions (q, q), (q, v), (v,
/// v) and (a, q); the last tensor has the derivatives of the mass matrix by q. They take O(n d²) on paths of
/// d velocities, and the time to write the zeros.
template <class T> struct InverseDynamicsSecondDerivatives { std::span<T> qq, qv, vv, aq; };
template <class T>
void inverse_dynamics_second_derivatives(
    const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
    const std::type_identity_t<InverseDynamicsSecondDerivatives<T>>& second);

/// Receives the second derivatives of a of forward dynamics along the pairs of directions (q, q), (q, v), (v,
/// v) and (τ, q); the last tensor has the derivatives of the inverse mass matrix by q. They take O(n³ d) on
/// paths of d velocities. They are NaN if the status is not ok().
template <class T> struct ForwardDynamicsSecondDerivatives { std::span<T> qq, qv, vv, tauq; };
template <class T>
Solvability forward_dynamics_second_derivatives(
    const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> tau,
    const std::type_identity_t<ForwardDynamicsSecondDerivatives<T>>& second);

}  // namespace axode
