#pragma once
#include "axode/kinematics/arguments.hpp"

/// Regressors: matrices that give forces and energies as linear functions of the inertial parameters of the
/// bodies. Body i has the ten parameters
///   π_i = (m, m c_x, m c_y, m c_z, Θ_xx, Θ_yy, Θ_zz, Θ_xy, Θ_xz, Θ_yz)
/// with the mass m, the centre of mass c, and the rotational inertia Θ about the origin, all in the body
/// frame (kg, kg m, kg m²). Columns 10 (i - 1) to 10 (i - 1) + 9 belong to them. Armatures, damping, friction
/// and loads are not included.
namespace axode {

/// The regressor Y of the drive forces: Y π = M a + C v + g for the inertial parameters π of all bodies; nv ×
/// 10 n_bodies entries, row by row. O(n d) for a tree of depth d, and the time to clear Y.
template <class T>
void regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
               std::type_identity_t<std::span<T>> Y);
/// The row y (10 n_bodies entries) with y π the kinetic energy (J) for the inertial parameters π. O(n).
template <class T>
void kinetic_energy_regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                              std::type_identity_t<std::span<T>> y);
/// The row y (10 n_bodies entries) for which y π is the potential energy (J) under gravity of bodies with the
/// inertial parameters π. O(n).
template <class T>
void potential_energy_regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                std::type_identity_t<std::span<T>> y);

}  // namespace axode
