#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

namespace axode {

/// The pose C_i of every frame in the inertial frame (eqs. POEX, aVbRec2), positions in m. C has n_frames
/// entries. O(n).
template <class T>
void poses(const Model& model, Workspace<T>& workspace, Numbers<T> q,
           std::type_identity_t<std::span<SE3<T>>> C);
/// The poses of the given places (frames or points on bodies) in the inertial frame, one entry for each
/// place, in the order of the places. O(n), and constant time for each place.
template <class T>
void poses(const Model& model, Workspace<T>& workspace, Numbers<T> q,
           std::type_identity_t<std::span<const Place<T>>> places, std::type_identity_t<std::span<SE3<T>>> C);

}  // namespace axode
