#pragma once
#include <cstdint>

#include "axode/lie/vec3.hpp"

namespace axode {

/// A point at which two collision shapes touch or nearly touch. Coordinates are in the inertial frame.
struct ContactPoint {
  int a = 0, b = 0;       ///< the two shapes as ContactShapes numbers them; a plane is always a
  Vec3<> point;           ///< half-way between the two surfaces, and on the surface of b if a is a plane, m
  Vec3<> normal;          ///< unit vector from a to b
  double gap = 0;         ///< distance of the two surfaces along the normal, negative in overlap, m
  std::uint64_t key = 0;  ///< the shapes and the feature that touches, the same from step to step
};

}  // namespace axode
