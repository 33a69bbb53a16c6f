#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// The equations of motion in momenta: as rates of (q, p) with p = M(q) v, and as rates of (q, Π) with the
/// momenta Π of the bodies. Everything is in spatial twists, where momenta of bodies add up without a
/// transformation.
namespace axode {

/// The rates of (q, p): velocities v = M⁻¹ p and
///   p'_i = τ_i + J_iᵀ W_i^A + (ad_{V_i} J_i)ᵀ Π_i^A
/// with the momentum Π_i^A of the subtree of body i and the wrench W_i^A of gravity and loads on it. O(n),
/// without accelerations and their bias terms; v and dp have nv entries. If the mass matrix is singular, the
/// status names a body, and both results are NaN. See (D5.1) and (D5.2) of docs/derivations.
template <class T>
Solvability momentum_form(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                          Numbers<T> tau, std::type_identity_t<std::span<T>> v,
                          std::type_identity_t<std::span<T>> dp,
                          const std::type_identity_t<Loads<T>>& loads = {});

/// The equations of motion for the state (q, Π), where Π are the spatial momenta of all bodies (n + 6n
/// unknowns; eq. PEs with erratum 24). It computes the joint velocities v (nv entries), with which q changes,
/// and the rates dPi of the momenta (n_bodies entries). The velocities follow from JᵀΠ = (JᵀMJ) v, the
/// projection of Π_i = M_i J_i v, so that massless bodies are allowed. O(n). See (D5.8) of docs/derivations.
template <class T>
Solvability spatial_momentum_form(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                  std::type_identity_t<std::span<const Momentum<Spatial, T>>> Pi,
                                  Numbers<T> tau, std::type_identity_t<std::span<T>> v,
                                  std::type_identity_t<std::span<Wrench<Spatial, T>>> dPi,
                                  const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
