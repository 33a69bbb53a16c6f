#pragma once
#include "axode/kinematics/arguments.hpp"

/// Regressors, matrices that give forces and energies as linear functions of the inertial parameters of the
/// bodies (axode/model/inertial_parameters.hpp). Columns 10 (i - 1) to 10 (i - 1) + 9 of each regressor
/// belong to the ten parameters of body i. Armatures, damping, friction and loads are not included.
namespace axode {

/// The regressor Y of the drive forces: Y π = M a + C v + g for the inertial parameters π of all bodies. Y
/// has nv × 10 n_bodies entries, row by row. O(n d) for a tree of depth d, and the time to clear Y.
template <class T>
void regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
               std::type_identity_t<std::span<T>> Y);
/// The row y for which y π is the kinetic energy (J) of the bodies with the inertial parameters π. y has 10
/// n_bodies entries, O(n).
template <class T>
void kinetic_energy_regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                              std::type_identity_t<std::span<T>> y);
/// The row y for which y π is the potential energy (J) of the bodies with the inertial parameters π under
/// gravity. y has 10 n_bodies entries, O(n).
template <class T>
void potential_energy_regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                std::type_identity_t<std::span<T>> y);

}  // namespace axode
