#include "axode/contact/convex/convex_shape.hpp"

#include <algorithm>
#include <cmath>

namespace axode {

ConvexShape sphere_shape(double radius) {
  return {.core = ConvexShape::Core::box, .radius = radius, .extent = radius};
}
ConvexShape capsule_shape(double radius, double half_length) {
  return {.core = ConvexShape::Core::box,
          .size = {0, 0, half_length},
          .radius = radius,
          .extent = half_length + radius};
}
ConvexShape cylinder_shape(double radius, double half_length) {
  return {.core = ConvexShape::Core::cylinder,
          .size = {radius, radius, half_length},
          .extent = std::hypot(radius, half_length)};
}
ConvexShape disc_shape(double radius) { return cylinder_shape(radius, 0); }
ConvexShape box_shape(const Vec3<>& half) {
  return {.core = ConvexShape::Core::box, .size = half, .extent = norm(half)};
}
ConvexShape ellipsoid_shape(const Vec3<>& semi_axes) {
  const auto [least, largest] = std::minmax({semi_axes.x, semi_axes.y, semi_axes.z});
  return {.core = ConvexShape::Core::ellipsoid,
          .size = semi_axes,
          .radius = least * least / largest,
          .extent = largest};
}
ConvexShape hull_shape(const Hull& hull) {
  double extent = 0;
  for (const Vec3<>& v : hull.vertices) extent = std::max(extent, norm(v));
  return {.core = ConvexShape::Core::hull, .extent = extent, .hull = &hull};
}

}  // namespace axode
