#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode::view {

/// A placeholder shape for a body, joint or mount that the description gives no shape.
struct StandIn {
  /// What `shape` stands for, if it is none of the kinds of shapes.
  enum class Form {
    as_described,
    hull,    ///< the convex hull of balls of radius shape.radius about points
    thread,  ///< a rod like the cylinder `shape`, in which a thread is cut
    socket,  ///< the half of a hollow ball where z > 0
  };
  int body = 0;  ///< body to which the shape belongs; 0 is the ground
  ShapeDescription shape;
  Form form = Form::as_described;
  std::vector<Vec3<>> hull = {};  ///< the points of a hull in the frame shape.pose
  double lead = 0;                ///< how far a thread advances in a turn, m; negative if it is left-handed
};

/// Placeholders for bodies without a visible shape, for their joints, and for the mounts of these joints on
/// the ground, with poses in the body frames. `with_shapes` says of the ground and of each body whether it
/// has a visible shape. The massless body inside a cylindrical joint between two bodies with shapes gets no
/// placeholder.
///
/// A body is drawn between the points of its joints, frames, loops, springs and drives: as a bar between two
/// points, and as their rounded convex hull if there are more (of at most 60 corners). Heavier bodies are
/// thicker. A body with one point is a bar from this point through the centre of mass if it has the inertia
/// of a rod. Otherwise it is a bar to the centre of mass and a solid there, with the body's mass and inertia,
/// but made smaller if it is large compared to the mechanism. The solid is a cylinder if just two principal
/// moments are equal, and an ellipsoid if not. A body without points is such a solid. Bodies that are fixed
/// to the ground are drawn between their points too, and joints on the ground itself get a mount.
///
/// Joints are drawn by kind, in the colour of drives unless the joint is passive. The bodies of a planar
/// mechanism are drawn in layers along the normal of its plane. If the description gives only the direction
/// of a prismatic joint and no point, a rail is drawn along which the body slides.
std::vector<StandIn> stand_ins(const Model& model, const std::vector<bool>& with_shapes);

}  // namespace axode::view
