#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"

/// Derivatives of the terms of the equations of motion M(q) a + C(q, v) v + g(q) = τ + Q(q, v), each for itself: nv × nv,
/// [component, direction]. No allocation; O(n d) and the zeros. Directions and loads as in inverse_dynamics_derivatives().
namespace axode {

/// ∂g/∂q.
template <class T>
void gravity_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                         std::type_identity_t<std::span<T>> dq);

/// Where ∂/∂q and ∂/∂v of a vector go. They may not overlap.
template <class T> struct StateDerivatives { std::span<T> q, v; };

/// Those of C(q, v) v.
template <class T>
void coriolis_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                          const std::type_identity_t<StateDerivatives<T>>& d);
/// Those of Q, by v with loads.joint_losses alone. By a component of a load Q has the derivative Jᵀ, see jacobian(), and
/// accelerations M⁻¹ Jᵀ, see impulse_response().
template <class T>
void generalized_load_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                  const Loads<T>& loads, const std::type_identity_t<StateDerivatives<T>>& d);

/// ∂T/∂q and ∂T/∂v = M v of the kinetic energy: nv numbers each. O(n). See (D1.25) of docs/derivations.
template <class T>
void kinetic_energy_gradient(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             const std::type_identity_t<StateDerivatives<T>>& gradient);

}  // namespace axode
