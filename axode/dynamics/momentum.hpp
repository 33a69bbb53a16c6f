#pragma once
#include "axode/dynamics/loads.hpp"
#include "axode/dynamics/solvability.hpp"
#include "axode/kinematics/arguments.hpp"

/// The momentum form of the equations of motion: the state is (q, p) with p = M(q) v. Everything is in
/// spatial twists, where momenta of bodies add up without a transformation.
namespace axode {

/// p = M v, the generalised momenta ∂T/∂v, armature included: p_i = J_iᵀ Π_i^A with the momentum of all that
/// joint i moves. nv entries, O(n).
template <class T>
void generalized_momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                         std::type_identity_t<std::span<T>> p);

/// The rates of (q, p): velocities v = M⁻¹ p and
///   p'_i = τ_i + J_iᵀ W_i^A + (ad_{V_i} J_i)ᵀ Π_i^A
/// with the momentum Π_i^A of all that joint i moves and the wrench W_i^A of gravity and loads on it. O(n),
/// without accelerations and their bias terms; where joints are coupled, v costs O(n d²). v and dp have nv
/// entries. Where the mass matrix is singular the status names a body, and both are NaN.
template <class T>
Solvability momentum_form(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                          Numbers<T> tau, std::type_identity_t<std::span<T>> v,
                          std::type_identity_t<std::span<T>> dp,
                          const std::type_identity_t<Loads<T>>& loads = {});

/// Π_i = M_i V_i of every body in its own frame, n_bodies entries, O(n).
template <class Rep = BodyFixed, class T>
void body_momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                  std::type_identity_t<std::span<Momentum<Rep, T>>> Pi);
/// Σ Π_i^s, the momentum of the whole system about the inertial origin, O(n). Armatures are not part of it.
template <class T>
Momentum<Spatial, T> spatial_momentum(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                      Numbers<T> v);
/// The same about the centre of mass, in inertial axes. Throws std::domain_error for a massless model.
template <class T>
Momentum<Hybrid, T> centroidal_momentum(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                        Numbers<T> v);

/// The state as (q, V), n + 6n unknowns: the rates of q and V that belong to the twists V of all bodies (in
/// their own frames) and the drive forces. v and dV are the results, nv and n_bodies entries. V should come
/// from some v; of others the part that the joints allow is taken. O(n).
template <class Rep = BodyFixed, class T>
Solvability twist_form(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                       std::type_identity_t<std::span<const Twist<Rep, T>>> V, Numbers<T> tau,
                       std::type_identity_t<std::span<T>> v,
                       std::type_identity_t<std::span<TwistRate<Rep, T>>> dV,
                       const std::type_identity_t<Loads<T>>& loads = {});

/// The state as (q, Π^s), n + 6n unknowns (eqs. PEs with erratum 24): the rates of q and Π that belong to the
/// spatial momenta Π of all bodies. v has nv and dPi n_bodies entries. M_i J_i v = Π_i is solved by its
/// projection JᵀΠ = (JᵀMJ) v, so that massless bodies do no harm. O(n).
template <class T>
Solvability spatial_momentum_form(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                  std::type_identity_t<std::span<const Momentum<Spatial, T>>> Pi,
                                  Numbers<T> tau, std::type_identity_t<std::span<T>> v,
                                  std::type_identity_t<std::span<Wrench<Spatial, T>>> dPi,
                                  const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
