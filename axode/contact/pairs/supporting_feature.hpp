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

/// The flat part of a shape's surface that faces the unit vector n (in the inertial frame). For a box it is
/// the face whose normal is nearest to n. For a hull it is, of the faces at the support point, the one whose
/// normal is nearest to n. For a cylinder it is a cap, as a polygon of eight points on its rim, or a line on
/// its side. For a capsule it is the axis, which is not on the surface; the caller takes the radius of the
/// capsule into account. Spheres and ellipsoids have no flat part. If a face of a hull has more than 32
/// corners, only some of them are taken.
template <class T>
Feature<T> supporting_feature(const ContactShape& shape, const SE3<T>& pose, const Vec3<T>& n) noexcept;

}  // namespace axode
