#pragma once
#include <array>

#include <vector>

#include "axode/kinematics/arguments.hpp"
#include "axode/lie/inertia.hpp"

/// The equations of motion are linear in the inertia of the bodies: ten parameters for each moving body, in
/// the frame of that body with everything fixed to it,
///   π = (m, m c_x, m c_y, m c_z, Θ_xx, Θ_yy, Θ_zz, Θ_xy, Θ_xz, Θ_yz), Θ about the origin of the body frame.
/// Columns 10 (i - 1) to 10 (i - 1) + 9 belong to body i. Armatures, damping, friction and loads are not part
/// of it.
namespace axode {

std::array<double, 10> inertial_parameters(const Inertia<double>& M);
Inertia<double> inertia_of(std::span<const double, 10> parameters);
/// Those of all bodies, 10 n_bodies numbers.
std::vector<double> inertial_parameters(const Model& model);

/// Y with Y π = M a + C v + g, nv × 10 n_bodies entries, row by row; O(n d), and the size of Y to clear.
template <class T>
void torque_regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                      std::type_identity_t<std::span<T>> Y);
/// y with y π = kinetic energy of the bodies, J; 10 n_bodies entries, O(n).
template <class T>
void kinetic_energy_regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                              std::type_identity_t<std::span<T>> y);
/// y with y π = potential energy of gravity, J; 10 n_bodies entries, O(n).
template <class T>
void potential_energy_regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                std::type_identity_t<std::span<T>> y);

}  // namespace axode
