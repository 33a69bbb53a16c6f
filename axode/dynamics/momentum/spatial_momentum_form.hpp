#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The equations of motion for the state (q, Π), where Π are the spatial momenta of all bodies (Müller,
/// eq. PEs with erratum 24 of docs/errata.md):
///   (J^s)ᵀ (Π' - W_app) = τ,    M_i^s J_i^s v = Π_i^s
/// with the applied wrenches W_app, the spatial inertia M_i^s and the spatial Jacobian J_i^s of body i, and
/// the Jacobian J^s of all bodies, one below the other. Computes the joint velocities v (nv numbers) and the
/// rates Π' of the momenta (n_bodies entries) about the inertial origin. The velocities follow from the
/// projection (JᵀMJ) v = JᵀΠ of the second equation, so that massless bodies are allowed. O(n) by the
/// articulated-body algorithm. If JᵀMJ is singular, because some motion of the joints moves no mass, all
/// results are NaN, and the returned Solvability names the body of a joint with such a motion. See (D5.8),
/// (D5.10) and (D5.11) of docs/derivations.
template <class T>
Solvability spatial_momentum_form(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                  std::type_identity_t<std::span<const Momentum<Spatial, T>>> Pi,
                                  Numbers<T> tau, std::type_identity_t<std::span<T>> v,
                                  std::type_identity_t<std::span<Wrench<Spatial, T>>> dPi,
                                  const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
