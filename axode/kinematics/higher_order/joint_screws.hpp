#pragma once
#include "axode/kinematics/arguments.hpp"

namespace axode {

/// The instantaneous joint screws J_i^s of all joints (eqs. JsX, bVsRec), in spatial representation, which is
/// the same for every body: Model::first_screw(i) is the first of joint i, n_screws in all. O(n).
template <class T>
void joint_screws(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                  std::type_identity_t<std::span<Twist<Spatial, T>>> J);

}  // namespace axode
