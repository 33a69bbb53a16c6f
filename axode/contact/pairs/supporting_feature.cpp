#include "axode/contact/pairs/supporting_feature.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "axode/contact/convex/support.hpp"

namespace axode {
namespace {

void box_face(const Vec3<>& h, const SE3<>& pose, const Vec3<>& n, Feature& out) noexcept {
  const std::array<const Vec3<>*, 3> axes{&pose.R.x, &pose.R.y, &pose.R.z};
  const std::array<double, 3> half{h.x, h.y, h.z};
  const std::array<double, 3> along{dot(*axes[0], n), dot(*axes[1], n), dot(*axes[2], n)};
  const auto most = std::ranges::max_element(along, {}, [](double x) { return std::abs(x); });
  const int i = static_cast<int>(most - along.begin()), j = (i + 1) % 3, k = (i + 2) % 3;
  const double sign = along[i] < 0 ? -1 : 1;
  out.normal = sign * *axes[i];
  out.id = static_cast<std::uint32_t>(2 * i + (sign > 0));
  const Vec3<> center = pose.r + half[i] * out.normal, u = half[j] * *axes[j], v = half[k] * *axes[k];
  const Vec3<> w = sign * v;
  out.add(center - u - w);
  out.add(center + u - w);
  out.add(center + u + w);
  out.add(center - u + w);
}

void hull_face(const ConvexShape& shape, const SE3<>& pose, const Vec3<>& n, Feature& out) noexcept {
  const Hull& hull = *shape.hull;
  const Vec3<> m = transpose(pose.R) * n;
  const int vertex = convex::support_branch(shape, m, 0);
  const int begin = hull.first_face[vertex], end = hull.first_face[vertex + 1];
  if (begin == end) return;
  int best = hull.faces[begin];
  for (int k = begin; k < end; ++k)
    if (dot(hull.normals[hull.faces[k]], m) > dot(hull.normals[best], m)) best = hull.faces[k];
  out.normal = pose.R * hull.normals[best];
  out.id = static_cast<std::uint32_t>(best % 64);
  const int first = hull.first_corner[best], corners = hull.first_corner[best + 1] - first;
  const int stride = (corners + Feature::most_points - 1) / Feature::most_points;
  for (int k = 0; k < corners; k += stride) out.add(pose * hull.vertices[hull.corners[first + k]]);
}

void cylinder_face(const ContactShape& shape, const SE3<>& pose, const Vec3<>& n, Feature& out) noexcept {
  constexpr int rim_points = 8;
  const Vec3<>& axis = pose.R.z;
  const double along = dot(axis, n), sign = along < 0 ? -1 : 1;
  const Vec3<> d = shape.radius * convex::across(axis, n, pose.R.x);
  const Vec3<> half = shape.half_length * axis;
  if (std::abs(along) < std::numbers::sqrt2 / 2) {
    out.id = 2;
    out.add(pose.r - half + d);
    out.add(pose.r + half + d);
    return;
  }
  out.normal = sign * axis;
  out.id = sign > 0;
  const Vec3<> e = cross(out.normal, d), center = pose.r + sign * half;
  for (int k = 0; k < rim_points; ++k) {
    const double angle = 2 * std::numbers::pi * k / rim_points;
    out.add(center + std::cos(angle) * d + std::sin(angle) * e);
  }
}

}  // namespace

Feature supporting_feature(const ContactShape& shape, const SE3<>& pose, const Vec3<>& n) noexcept {
  Feature out;
  switch (shape.kind) {
    case ShapeKind::box: box_face(shape.half, pose, n, out); break;
    case ShapeKind::mesh: hull_face(shape.convex, pose, n, out); break;
    case ShapeKind::cylinder: cylinder_face(shape, pose, n, out); break;
    case ShapeKind::capsule:
      out.add(pose.r - shape.half_length * pose.R.z);
      out.add(pose.r + shape.half_length * pose.R.z);
      break;
    case ShapeKind::sphere:
    case ShapeKind::ellipsoid:
    case ShapeKind::plane: break;
  }
  return out;
}

}  // namespace axode
