#pragma once
#include <stdexcept>

#include "axode/kinematics/arguments.hpp"

/// The centre of mass of all moving bodies, and the momentum about it. All functions throw std::domain_error
/// if the moving bodies have no mass.
namespace axode {

/// The position of the centre of mass in the inertial frame, m; O(n).
template <class T> Vec3<T> center_of_mass(const Model& model, Workspace<T>& workspace, Numbers<T> q);

/// The Jacobian of the centre of mass: nv columns, each the velocity (m/s) of the centre of mass in inertial
/// axes for a unit of one velocity; O(n).
template <class T>
void center_of_mass_jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             std::type_identity_t<std::span<Vec3<T>>> J);

/// The centroidal momentum matrix: nv columns, each the momentum of all bodies about the centre of mass, in
/// inertial axes, for a unit of one velocity; O(n).
template <class T>
void centroidal_momentum_matrix(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                std::type_identity_t<std::span<Momentum<Hybrid, T>>> A);

/// The time derivative of the centroidal momentum matrix, nv columns, at (q, v); O(n).
template <class T>
void centroidal_momentum_matrix_rate(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                     std::type_identity_t<std::span<Wrench<Hybrid, T>>> dA);

/// The error to be thrown for a model whose moving bodies have no mass, and thus no centre of mass.
inline std::domain_error no_mass(const Model& model) {
  return std::domain_error("model \"" + model.name() + "\" has no mass that moves, so no centre of mass");
}

}  // namespace axode
