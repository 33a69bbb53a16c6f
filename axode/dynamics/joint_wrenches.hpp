#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// The point on a body about which the moment of the wrench of its joint is taken.
enum class WrenchPoint {
  body,   ///< origin of the body's frame
  joint,  ///< origin of the joint frame on the body, Body::S_self: the point of the joint in the drawing
};

/// Computes the wrench that each joint transmits from the predecessor to the body: all six components, the
/// drive force and the reactions. W has n_bodies entries; W[i - 1] belongs to joint i, in the representation
/// Rep of the frame of body i, moved without turning to the point `at` (origin of the body frame or of the
/// joint frame). Spatial wrenches are about the inertial origin and do not depend on `at`. O(n). Throws
/// std::invalid_argument for wrong sizes, a quaternion that is not of unit norm and a load on a frame that
/// does not exist.
template <RecursionRepresentation Rep = BodyFixed, class T>
void joint_wrenches(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                    std::type_identity_t<std::span<Wrench<Rep, T>>> W,
                    const std::type_identity_t<Loads<T>>& loads = {}, WrenchPoint at = WrenchPoint::body);

}  // namespace axode
