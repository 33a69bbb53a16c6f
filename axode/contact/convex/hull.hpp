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

/// Makes a hull from vertices that are all extreme points and from its triangles, which are counter-clockwise
/// seen from outside. Neighbouring triangles whose unit normals differ by less than `coplanar` make one face,
/// which is the convex polygon of their vertices. Triangles that are nearly segments make no face of their
/// own. Throws std::invalid_argument if there are fewer than four vertices, if a vertex is not finite or has
/// no triangle, if the triangles are not a closed surface, or if one does not face away from the origin. That
/// the surface is convex is not checked further.
Hull make_hull(std::vector<Vec3<>> vertices, std::span<const std::array<int, 3>> triangles,
               double coplanar = 1e-9);

}  // namespace axode
