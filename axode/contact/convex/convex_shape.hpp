#pragma once
#include <array>
#include <span>
#include <vector>

#include "axode/lie/se3.hpp"

namespace axode {

/// A convex polytope. Every vertex is an extreme point, and every face is a polygon; triangles in one plane
/// are one face. Positions are in the frame of the shape, whose origin lies inside, m.
struct Hull {
  std::vector<Vec3<>> vertices;
  std::vector<int> first_neighbour, neighbours;  ///< neighbours of vertex i, from first_neighbour[i] on
  std::vector<Vec3<>> normals;                   ///< outward unit normal of each face
  std::vector<int> first_corner, corners;        ///< vertices of face f, counter-clockwise seen from outside
  std::vector<int> first_face, faces;            ///< faces around vertex i, from first_face[i] on
  std::array<int, 27> start{};  ///< the vertex that is farthest along the middle of each sector
};

/// A convex body: the core, which is the convex hull of a box, a cylinder, an ellipsoid or a hull, plus a
/// ball (D10.4). The core of a sphere is a point, that of a capsule a segment. The core of an ellipsoid is the
/// ellipsoid less the ball of its least radius of curvature.
struct ConvexShape {
  enum class Core { box, cylinder, ellipsoid, hull } core = Core::box;
  Vec3<> size{};       ///< half sizes of the core, or semi-axes of an ellipsoid, along the axes, m
  double radius = 0;   ///< radius of the ball that is added to the core, m
  double extent = 0;   ///< radius of a ball about the origin that contains the body, m
  const Hull* hull{};  ///< the vertices of a core that is a hull; they must outlive the shape
};

/// The bodies by their sizes, m: `half_length` is half the length of the axis of a cylinder, or of a capsule
/// without its half balls; `half` are half edges; a disc has no thickness. Sizes must be positive.
ConvexShape sphere_shape(double radius);
ConvexShape capsule_shape(double radius, double half_length);
ConvexShape cylinder_shape(double radius, double half_length);
ConvexShape disc_shape(double radius);
ConvexShape box_shape(const Vec3<>& half);
ConvexShape ellipsoid_shape(const Vec3<>& semi_axes);
ConvexShape hull_shape(const Hull& hull);

/// The hull of vertices that are all extreme points, from its triangles, which are counter-clockwise seen from
/// outside. Throws std::invalid_argument if fewer than four vertices are given, or if the triangles are not a
/// closed convex surface around the origin.
Hull make_hull(std::vector<Vec3<>> vertices, std::span<const std::array<int, 3>> triangles);

}  // namespace axode
