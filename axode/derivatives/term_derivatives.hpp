#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"

/// Derivatives of the terms of the equations of motion M(q) a + C(q, v) v + g(q) = τ + Q(q, v), each term on
/// its own; Q are the generalised forces of the loads. A matrix has nv × nv numbers, [component, direction].
/// Direction k of q is q ⊕ ε e_k. The components of loads are constant in the representation in which they
/// are given. No allocation; O(n d) on paths of d velocities, and the time to write the zeros.
namespace axode {

/// Computes ∂g/∂q of the gravity forces g(q).
template <class T>
void gravity_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                         std::type_identity_t<std::span<T>> dq);

/// Receives the derivatives of a vector (or number) by q and by v. They must not overlap.
template <class T> struct StateDerivatives { std::span<T> q, v; };

/// Computes the derivatives of the Coriolis and centrifugal forces C(q, v) v by q and v, nv × nv numbers
/// each.
template <class T>
void coriolis_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                          const std::type_identity_t<StateDerivatives<T>>& d);
/// Computes ∂Q/∂q and ∂Q/∂v of the generalised forces Q of the loads; ∂Q/∂v is 0 unless loads.joint_losses is
/// set. The derivatives by a component of a load W on a frame are simpler: Q changes by a row of the Jacobian
/// J of the frame, see jacobian(), and the accelerations change by a column of M⁻¹ Jᵀ with the mass matrix M,
/// see impulse_response().
template <class T>
void generalized_load_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                  const Loads<T>& loads, const std::type_identity_t<StateDerivatives<T>>& d);

/// Computes ∂T/∂q and ∂T/∂v = M v of the kinetic energy T with the mass matrix M, nv numbers each. O(n). See
/// (D1.25) of docs/derivations.
template <class T>
void kinetic_energy_gradient(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             const std::type_identity_t<StateDerivatives<T>>& gradient);

}  // namespace axode
