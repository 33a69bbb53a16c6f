#pragma once
#include "axode/kinematics/arguments.hpp"

namespace axode {

/// The instantaneous joint screws J_i^s of all joints (Müller, eqs. JsX, bVsRec), in spatial representation.
/// J has n_screws entries; the screws of joint i begin at the index Model::first_screw(i). O(n).
template <class T>
void joint_screws(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                  std::type_identity_t<std::span<Twist<Spatial, T>>> J);

}  // namespace axode
