#pragma once
#include <cstdint>

#include "axode/lie/vec3.hpp"

namespace axode {

/// A point at which two collision shapes touch or nearly touch. Coordinates are in the inertial frame. T is
/// the scalar of the poses of the shapes.
template <class T> struct ContactPointOf {
  int a = 0, b = 0;       ///< the two shapes as ContactShapes numbers them; a plane is always a
  Vec3<T> point;          ///< half-way between the two surfaces, and on the surface of b if a is a plane, m
  Vec3<T> normal;         ///< unit vector from a to b
  T gap{};                ///< distance of the two surfaces along the normal, negative in overlap, m
  std::uint64_t key = 0;  ///< the shapes and the feature that touches, the same from step to step
};
using ContactPoint = ContactPointOf<double>;

}  // namespace axode
