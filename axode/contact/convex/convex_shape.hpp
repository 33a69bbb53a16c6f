#pragma once
#include "axode/contact/convex/hull.hpp"
#include "axode/lie/se3.hpp"

namespace axode {

/// A convex body: the Minkowski sum of a core and a ball (D10.4). The core is a box, a cylinder, a polytope
/// (hull) or the inner part of an ellipsoid. A sphere has a point as its core and a capsule a segment; both
/// are stored as boxes. The core of an ellipsoid is the set of all its points that are at least `radius` away
/// from its surface, where `radius` is the least radius of curvature of the surface. The sum of this core and
/// the ball is the whole ellipsoid.
struct ConvexShape {
  enum class Core { box, cylinder, ellipsoid, hull } core = Core::box;
  Vec3<> size{};       ///< half sizes of the core, or semi-axes of the whole ellipsoid, along the axes, m
  double radius = 0;   ///< radius of the ball that is added to the core, m
  double extent = 0;   ///< radius of a ball about the origin that contains the body, m
  const Hull* hull{};  ///< the vertices of a core that is a hull; they must outlive the shape
};

/// These functions make convex bodies from their sizes, m. `half_length` is half the length of the axis of a
/// cylinder, or of a capsule without its half balls; `half` are half edges; a disc is a cylinder without
/// thickness. Sizes must be positive.
ConvexShape sphere_shape(double radius);
ConvexShape capsule_shape(double radius, double half_length);
ConvexShape cylinder_shape(double radius, double half_length);
ConvexShape disc_shape(double radius);
ConvexShape box_shape(const Vec3<>& half);
ConvexShape ellipsoid_shape(const Vec3<>& semi_axes);
ConvexShape hull_shape(const Hull& hull);

}  // namespace axode
