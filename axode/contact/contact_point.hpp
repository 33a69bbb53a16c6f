#pragma once
#include <array>
#include <cstdint>

#include "axode/lie/vec3.hpp"

namespace axode {

/// A point at which two collision shapes touch or nearly touch, in coordinates of the inertial frame.
template <class T> struct ContactPointOf {
  int a = 0, b = 0;       ///< the two shapes, numbered as in ContactShapes; a plane is always a
  Vec3<T> point;          ///< half-way between the two surfaces, and on the surface of b if a is a plane, m
  Vec3<T> normal;         ///< unit vector from shape a to shape b
  T gap{};                ///< distance of the two surfaces along the normal, negative in overlap, m
  std::uint64_t key = 0;  ///< number for the shapes and the features that touch, constant from step to step
};
using ContactPoint = ContactPointOf<double>;

/// The number (key) that identifies a contact point of two shapes. It is made of the numbers a and b of the
/// shapes (below 2^20) and a number (below 2^24) for the features, such as faces and edges, that touch.
/// shapes_of_key() returns the shapes {a, b} of a key.
constexpr std::uint64_t contact_key(int a, int b, std::uint32_t feature) {
  return std::uint64_t(a) << 44 | std::uint64_t(b) << 24 | feature;
}
constexpr std::array<int, 2> shapes_of_key(std::uint64_t key) {
  return {static_cast<int>(key >> 44), static_cast<int>(key >> 24 & 0xfffff)};
}
/// Whether two keys are those of contact points of the same two shapes.
constexpr bool of_one_pair(std::uint64_t key, std::uint64_t other) { return key >> 24 == other >> 24; }

}  // namespace axode
