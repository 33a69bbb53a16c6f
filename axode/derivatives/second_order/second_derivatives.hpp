#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/solvability.hpp"

/// Second derivatives of every component of the forces τ of inverse dynamics or of the accelerations a of
/// forward dynamics, without loads. For a pair of variables, for example (q, v), they are a tensor of nv³
/// numbers. Its entry [i][k][l] is the derivative of component i by component k of the first variable (outer)
/// and component l of the second one (inner). Derivatives by q are along the left-trivialised unit directions
/// e_k. In the tensor for (q, q), the displacement along e_k comes first: q ⊕ ε_k e_k ⊕ ε_l e_l. The order
/// matters only within one joint with several velocities. If only a weighted sum of the components is needed,
/// the functions in hessian.hpp are faster. No allocation. Results must not overlap.
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
