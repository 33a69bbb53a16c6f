#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode::view {

/// A placeholder shape for a body, joint or mount that the description gives no shape.
struct StandIn {
  int body = 0;  ///< body to which the shape belongs; 0 is the ground
  ShapeDescription shape;
  /// If not empty, the shape is the convex hull of balls of radius shape.radius about these points, which
  /// are given in the frame shape.pose.
  std::vector<Vec3<>> hull = {};
};

/// Placeholders for bodies without a visible shape, for their joints, and for the mounts of these joints on
/// the ground; `seen` says of the ground and of each body whether it has a visible shape.
///
/// A body is drawn between the points of its joints, frames, loops, springs and drives: as a bar between two
/// points, and as their rounded convex hull if there are more (of at most 60 corners). A body with one point
/// reaches from it through the centre of mass, as a bar if the inertia is that of a rod, otherwise with the
/// solid that has its mass and inertia: a cylinder if two principal moments are equal, an ellipsoid if not. A
/// free body without points is that solid. A hinge is drawn as a pin, a spherical joint as a ball and a
/// planar joint as a pad, in the colour of drives unless the joint is passive. A body that slides on the
/// ground and whose joint has no point is on a rail. Poses are in the body frames.
std::vector<StandIn> stand_ins(const Model& model, const std::vector<bool>& seen);

}  // namespace axode::view
