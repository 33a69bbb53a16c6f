#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// Receives the matrices ∂τ/∂q, ∂τ/∂v and ∂τ/∂a, nv × nv numbers each, row by row, [component of τ,
/// direction], and the forces τ (nv, or an empty span). The spans must not overlap.
template <class T> struct InverseDynamicsDerivatives {
  std::span<T> q, v, a, tau = {};
};

/// Computes the first derivatives of the forces τ of inverse dynamics at a state (q, v, a); ∂τ/∂a is the mass
/// matrix, armatures included. Column k of ∂τ/∂q is the derivative along q ⊕ ε e_k. The components of loads
/// are constant in the representation in which they are given. If loads.joint_losses is set, damping is part
/// of ∂τ/∂v; Coulomb friction adds nothing to it. O(n d) for n velocities on paths of d velocities, and the
/// time to write the zeros of the matrices; no allocation. Throws std::invalid_argument for a wrong size,
/// quaternions that are not of unit norm, a load on a frame that does not exist and results whose memory
/// overlaps. See (D1.17) of docs/derivations.
template <class T>
void inverse_dynamics_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                  Numbers<T> a,
                                  const std::type_identity_t<InverseDynamicsDerivatives<T>>& dtau,
                                  const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
