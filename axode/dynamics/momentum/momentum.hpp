#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/solvability.hpp"

/// Momenta of joints, of bodies and of the whole system.
namespace axode {

/// The generalised momenta p = M v = ∂T/∂v with the mass matrix M and the kinetic energy T: p_i = J_iᵀ Π_i^A
/// plus the momentum of the armature, where J_i is the joint screw and Π_i^A the momentum of the subtree of
/// body i. p has nv entries, O(n).
template <class T>
void momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
             std::type_identity_t<std::span<T>> p);

/// The velocities v = M⁻¹ p (nv) for given generalised momenta p, with the mass matrix M; O(n). If M is
/// singular, the returned Solvability says so, and v is NaN.
template <class T>
Solvability from_momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                         std::type_identity_t<std::span<T>> v);
/// The momentum of the whole system about the inertial origin, Σ Π_i^s over all bodies, without armatures;
/// O(n).
template <class T>
Momentum<Spatial, T> spatial_momentum(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                      Numbers<T> v);
/// The momentum of the whole system about the centre of mass, in inertial axes, O(n). Throws
/// std::domain_error for a massless model.
template <class T>
Momentum<Hybrid, T> centroidal_momentum(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                        Numbers<T> v);

}  // namespace axode
