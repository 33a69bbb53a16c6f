#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/solvability.hpp"

/// Second derivatives of every component: tensors of nv × nv × nv, [component][outer derivative][inner
/// derivative], without loads. The order of derivatives is that of hessian.hpp, whose functions are faster if
/// only a weighted sum of the components is needed. No allocation. Results must not overlap.
namespace axode {

/// Receives ∂²τ of inverse dynamics along (q, q), (q, v), (v, v) and (a, q), where the last is ∂M/∂q. O(n
/// d²), and the time to write the zeros.
template <class T> struct InverseDynamicsSecondDerivatives { std::span<T> qq, qv, vv, aq; };
template <class T>
void inverse_dynamics_second_derivatives(
    const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
    const std::type_identity_t<InverseDynamicsSecondDerivatives<T>>& second);

/// Receives ∂²a of forward dynamics along (q, q), (q, v), (v, v) and (τ, q), where the last is ∂M⁻¹/∂q. O(n³
/// d). NaN if the status is not ok().
template <class T> struct ForwardDynamicsSecondDerivatives { std::span<T> qq, qv, vv, tauq; };
template <class T>
Solvability forward_dynamics_second_derivatives(
    const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> tau,
    const std::type_identity_t<ForwardDynamicsSecondDerivatives<T>>& second);

}  // namespace axode
