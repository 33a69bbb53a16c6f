#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/lie/inertia.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// T = vᵀ M v / 2 of bodies and armatures, J; O(n).
template <class T> T kinetic_energy(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v);
/// U = -Σ m g·r_com, J: the potential of gravity, 0 at the inertial origin; O(n).
template <class T> T potential_energy(const Model& model, Workspace<T>& workspace, Numbers<T> q);
/// The power W | V of every applied wrench, W; loads.wrenches.size() entries, O(n).
template <class T>
void load_powers(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                 const std::type_identity_t<Loads<T>>& loads, std::type_identity_t<std::span<T>> power);

/// The inertia of the whole system about its centre of mass, in inertial axes, as if the joints were locked:
/// h = 0. Armatures are not part of it. O(n). Throws std::domain_error for a massless model.
template <class T> Inertia<T> centroidal_inertia(const Model& model, Workspace<T>& workspace, Numbers<T> q);

}  // namespace axode
