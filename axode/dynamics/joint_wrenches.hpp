#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// The point on a body about which the moment of the wrench of its joint is taken.
enum class WrenchPoint {
  body,   ///< origin of the body's frame
  joint,  ///< origin of the joint frame on the body, Body::S_self: the point of the joint in the drawing
};

/// The wrench that each joint transmits from the predecessor to the body, all six components: drive and
/// reaction. W has n_bodies entries; W[i - 1] belongs to joint i, in the representation Rep of body i's
/// frame, with that frame moved to the point `at` without turning it. Spatial wrenches are about the inertial
/// origin and do not depend on `at`. Arguments, cost and errors are those of inverse_dynamics().
template <RecursionRepresentation Rep = BodyFixed, class T>
void joint_wrenches(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                    std::type_identity_t<std::span<Wrench<Rep, T>>> W,
                    const std::type_identity_t<Loads<T>>& loads = {}, WrenchPoint at = WrenchPoint::body);

}  // namespace axode
