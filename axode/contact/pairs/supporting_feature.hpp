#pragma once
#include <array>
#include <cstdint>

#include "axode/contact/contact_shapes.hpp"

namespace axode {

/// The flat part of the surface of a core that faces a direction: a polygon, a segment, or nothing. Points
/// are in the inertial frame, m.
template <class T = double> struct Feature {
  static constexpr int most_points = 32;

  int count = 0;  ///< corners of a polygon, counter-clockwise seen from outside; 2 for a segment; 0: none
  std::array<Vec3<T>, most_points> point;
  Vec3<T> normal{};      ///< outward unit normal of a polygon
  std::uint32_t id = 0;  ///< number of the face, below 64

  void add(const Vec3<T>& p) noexcept { point[count++] = p; }
};

/// The feature of a shape that faces the unit vector n in the inertial frame: the face of a box or hull that
/// lies at the support point and is turned the least from n, a cap of a cylinder as a polygon of eight points
/// on its rim, or a line on its side, or the axis of a capsule. Spheres and ellipsoids have none. Of a face
/// with more than 32 corners only some are taken.
template <class T>
Feature<T> supporting_feature(const ContactShape& shape, const SE3<T>& pose, const Vec3<T>& n) noexcept;

}  // namespace axode
