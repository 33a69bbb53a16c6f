#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/lie/inertia.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// The kinetic energy T = vᵀ M v / 2 of bodies and armatures, J; O(n).
template <class T> T kinetic_energy(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v);
/// The potential energy of gravity U = -Σ m g·r_com, J, which is 0 for masses at the inertial origin; O(n).
template <class T> T potential_energy(const Model& model, Workspace<T>& workspace, Numbers<T> q);
/// Writes the power (in watts) of every applied wrench on the twist of the frame on which it acts. `power`
/// has loads.wrenches.size() entries. O(n).
template <class T>
void load_powers(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                 const std::type_identity_t<Loads<T>>& loads, std::type_identity_t<std::span<T>> power);

/// Computes the inertia of the whole system about its centre of mass, in inertial axes, with locked joints
/// and without armatures. O(n). Throws std::domain_error for a massless model.
template <class T> Inertia<T> centroidal_inertia(const Model& model, Workspace<T>& workspace, Numbers<T> q);

}  // namespace axode
