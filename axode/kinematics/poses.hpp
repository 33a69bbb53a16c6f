#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

namespace axode {

/// The pose C_i (positions in m) of each of the n_frames frames in the inertial frame (Müller, eqs. POEX,
/// aVbRec2); O(n).
template <class T>
void poses(const Model& model, Workspace<T>& workspace, Numbers<T> q,
           std::type_identity_t<std::span<SE3<T>>> C);
/// The poses of places (frames on bodies) in the inertial frame, in the order of the places. O(n).
template <class T>
void poses(const Model& model, Workspace<T>& workspace, Numbers<T> q,
           std::type_identity_t<std::span<const Place<T>>> places, std::type_identity_t<std::span<SE3<T>>> C);

}  // namespace axode
