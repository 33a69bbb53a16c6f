#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/solvability.hpp"

/// Momenta of joints, of bodies and of the whole.
namespace axode {

/// p = M v, the generalised momenta ∂T/∂v, armature included: p_i = J_iᵀ Π_i^A with the momentum of all that
/// joint i moves. nv entries, O(n).
template <class T>
void momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
             std::type_identity_t<std::span<T>> p);

/// v = M⁻¹ p, the velocities that have given momenta, O(n). v has nv entries; where M is singular it is NaN.
template <class T>
Solvability from_momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                         std::type_identity_t<std::span<T>> v);
/// Σ Π_i^s, the momentum of the whole system about the inertial origin, O(n). Armatures are not part of it.
template <class T>
Momentum<Spatial, T> spatial_momentum(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                      Numbers<T> v);
/// The same about the centre of mass, in inertial axes. Throws std::domain_error for a massless model.
template <class T>
Momentum<Hybrid, T> centroidal_momentum(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                        Numbers<T> v);

}  // namespace axode
