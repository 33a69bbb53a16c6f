#pragma once
#include <array>
#include <cstdint>

#include "axode/contact/contact_shapes.hpp"

namespace axode {

/// The flat part of the surface of a convex shape that faces a direction: a polygon, a segment, or nothing.
/// For a capsule it is the axis. Points are in the inertial frame, m.
template <class T = double> struct Feature {
  static constexpr int most_points = 32;

  int count = 0;  ///< number of points: corners of a polygon, 2 for a segment, 0 if there is none
  std::array<Vec3<T>, most_points> point;
  Vec3<T> normal{};      ///< outward unit normal of a polygon; its points are counter-clockwise from outside
  std::uint32_t id = 0;  ///< number of the face, below 64

  void add(const Vec3<T>& p) noexcept { point[count++] = p; }
};

/// Returns the flat part of a shape's surface that faces the unit vector n (in the inertial frame). For a box
/// it is the face whose normal is nearest to n. For a hull it is the face whose normal is nearest to n among
/// the faces at the vertex that is farthest along n; if it has more than 32 corners, only some of them are
/// taken. For a cylinder it is a cap, as a polygon of eight points on its rim, if the axis is within 45° of
/// the line of n, and otherwise a line on the side. For a capsule it is the axis, from which the surface is
/// one radius away. Spheres and ellipsoids have no flat part.
template <class T>
Feature<T> supporting_feature(const ContactShape& shape, const SE3<T>& pose, const Vec3<T>& n) noexcept;

}  // namespace axode
