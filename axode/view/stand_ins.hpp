#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode::view {

/// A placeholder shape for a body, a joint or a mount on the ground, to which the description gives no shape.
struct StandIn {
  int body = 0;  ///< body to which the shape belongs; 0 is the ground
  ShapeDescription shape;
  /// If `hull` is not empty, the shape is the convex hull of balls of radius shape.radius about these points,
  /// which are given in the frame with the pose shape.pose.
  std::vector<Vec3<>> hull = {};
};

/// Placeholder shapes for bodies without a visible shape, for their joints, and for the mounts of these
/// joints on the ground. seen[i] says whether body i has a visible shape; body 0 is the ground. Poses are in
/// the body frames.
///
/// A body is drawn between its points, those of its joints, frames, loops, springs and drives: two points as
/// a bar, more as their rounded convex hull (of at most 60). A body with one point is drawn as a bar from
/// this point through the centre of mass if it has the inertia of a rod. Otherwise it is drawn as a bar from
/// the point to the centre of mass, with a solid that has its mass and inertia: a cylinder if exactly two
/// principal moments are equal, else an ellipsoid. A body without points is drawn as this solid alone. A
/// hinge is drawn as a pin, a spherical joint as a ball and a planar joint as a pad, in the colour of drives
/// unless the joint is passive. A body that slides on the ground is drawn on a rail if its joint has no
/// point.
std::vector<StandIn> stand_ins(const Model& model, const std::vector<bool>& seen);

}  // namespace axode::view
