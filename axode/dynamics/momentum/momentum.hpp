#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/solvability.hpp"

/// Momenta of joints, of bodies and of the whole system.
namespace axode {

/// The generalised momenta p = M v = ∂T/∂v, armature included: p_i = J_iᵀ Π_i^A with the momentum of the
/// subtree of body i. nv entries, O(n).
template <class T>
void momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
             std::type_identity_t<std::span<T>> p);

/// The velocities v = M⁻¹ p for given momenta, O(n). v has nv entries; if M is singular, it is NaN.
template <class T>
Solvability from_momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                         std::type_identity_t<std::span<T>> v);
/// The momentum Σ Π_i^s of the whole system about the inertial origin, O(n). Armatures do not contribute.
template <class T>
Momentum<Spatial, T> spatial_momentum(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                      Numbers<T> v);
/// The momentum of the whole system about the centre of mass, in inertial axes, O(n). Throws
/// std::domain_error for a massless model.
template <class T>
Momentum<Hybrid, T> centroidal_momentum(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                        Numbers<T> v);

}  // namespace axode
