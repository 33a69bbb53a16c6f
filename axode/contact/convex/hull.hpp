#pragma once
#include <array>
#include <span>
#include <vector>

#include "axode/lie/vec3.hpp"

namespace axode {

/// A convex polytope. Every vertex is an extreme point, and every face is a polygon; triangles in one plane
/// are one face. Positions are in the frame of the shape, whose origin lies inside, m.
struct Hull {
  std::vector<Vec3<>> vertices;
  std::vector<int> first_neighbour, neighbours;  ///< neighbours of vertex i, from first_neighbour[i] on
  std::vector<Vec3<>> normals;                   ///< outward unit normal of each face
  std::vector<int> first_corner, corners;        ///< vertices of each face, counter-clockwise from outside
  std::vector<int> first_face, faces;            ///< faces around vertex i, from first_face[i] on
  std::array<int, 27> start{};  ///< vertex farthest along the middle of each sector(), see support.hpp
};

/// Makes a hull from its vertices, which must all be extreme points, and from its triangles, which must be
/// counter-clockwise seen from outside. Neighbouring triangles are one face, the convex polygon of their
/// vertices, if the unit normals of all differ from that of the largest one by a vector of a norm below
/// `coplanar`. A triangle that is nearly a segment makes no face of its own. Throws std::invalid_argument if
/// there are fewer than four vertices, if a vertex is not finite or has no triangle, if a triangle has an
/// index without a vertex, if the triangles are not a closed surface, or if the origin is not on the inner
/// side of a triangle that is not nearly a segment. Otherwise it is not checked that the surface is convex.
Hull make_hull(std::vector<Vec3<>> vertices, std::span<const std::array<int, 3>> triangles,
               double coplanar = 1e-9);

}  // namespace axode
