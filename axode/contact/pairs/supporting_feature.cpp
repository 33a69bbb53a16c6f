#include "axode/contact/pairs/supporting_feature.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "axode/contact/convex/support.hpp"
#include "axode/contact/pairs/displaced.hpp"

namespace axode {
namespace {

template <class T>
void box_face(const Vec3<>& h, const SE3<T>& pose, const Vec3<T>& n, Feature<T>& out) noexcept {
  const std::array<const Vec3<T>*, 3> axes{&pose.R.x, &pose.R.y, &pose.R.z};
  const std::array<double, 3> half{h.x, h.y, h.z};
  const Vec3<> along = value(transpose(pose.R) * n);
  const std::array<double, 3> cosine{along.x, along.y, along.z};
  const auto most = std::ranges::max_element(cosine, {}, [](double x) { return std::abs(x); });
  const int i = static_cast<int>(most - cosine.begin()), j = (i + 1) % 3, k = (i + 2) % 3;
  const double sign = cosine[i] < 0 ? -1 : 1;
  out.normal = T(sign) * *axes[i];
  out.id = static_cast<std::uint32_t>(2 * i + (sign > 0));
  const Vec3<T> center = pose.r + T(half[i]) * out.normal, u = T(half[j]) * *axes[j],
                v = T(half[k]) * *axes[k];
  const Vec3<T> w = T(sign) * v;
  out.add(center - u - w);
  out.add(center + u - w);
  out.add(center + u + w);
  out.add(center - u + w);
}

template <class T>
void hull_face(const ConvexShape& shape, const SE3<T>& pose, const Vec3<T>& n, Feature<T>& out) noexcept {
  const Hull& hull = *shape.hull;
  const Vec3<> m = value(transpose(pose.R) * n);
  const int vertex = convex::support_branch(shape, m, 0);
  const int begin = hull.first_face[vertex], end = hull.first_face[vertex + 1];
  if (begin == end) return;
  int best = hull.faces[begin];
  for (int k = begin; k < end; ++k)
    if (dot(hull.normals[hull.faces[k]], m) > dot(hull.normals[best], m)) best = hull.faces[k];
  out.normal = pose.R * cast<T>(hull.normals[best]);
  out.id = static_cast<std::uint32_t>(best % 64);
  const int first = hull.first_corner[best], corners = hull.first_corner[best + 1] - first;
  const int stride = (corners + Feature<>::most_points - 1) / Feature<>::most_points;
  for (int k = 0; k < corners; k += stride) out.add(pose * cast<T>(hull.vertices[hull.corners[first + k]]));
}

template <class T>
void cylinder_face(const ContactShape& shape, const SE3<T>& pose, const Vec3<T>& n,
                   Feature<T>& out) noexcept {
  constexpr int rim_points = 8;
  const Vec3<T>& axis = pose.R.z;
  const double along = value(dot(axis, n)), sign = along < 0 ? -1 : 1;
  const Vec3<T> d = T(shape.radius) * convex::across(axis, n, pose.R.x);
  const Vec3<T> half = T(shape.half_length) * axis;
  if (std::abs(along) < std::numbers::sqrt2 / 2) {
    out.id = 2;
    out.add(pose.r - half + d);
    out.add(pose.r + half + d);
    return;
  }
  out.normal = T(sign) * axis;
  out.id = sign > 0;
  const Vec3<T> e = cross(out.normal, d), center = pose.r + T(sign) * half;
  for (int k = 0; k < rim_points; ++k) {
    const double angle = 2 * std::numbers::pi * k / rim_points;
    out.add(center + T(std::cos(angle)) * d + T(std::sin(angle)) * e);
  }
}

}  // namespace

template <class T>
Feature<T> supporting_feature(const ContactShape& shape, const SE3<T>& pose, const Vec3<T>& n) noexcept {
  Feature<T> out;
  switch (shape.kind) {
    case ShapeKind::box: box_face(shape.half, pose, n, out); break;
    case ShapeKind::mesh: hull_face(shape.convex, pose, n, out); break;
    case ShapeKind::cylinder: cylinder_face(shape, pose, n, out); break;
    case ShapeKind::capsule:
      out.add(pose.r - T(shape.half_length) * pose.R.z);
      out.add(pose.r + T(shape.half_length) * pose.R.z);
      break;
    case ShapeKind::sphere:
    case ShapeKind::ellipsoid:
    case ShapeKind::plane: break;
  }
  return out;
}

template Feature<double> supporting_feature(const ContactShape&, const SE3<>&, const Vec3<>&) noexcept;
template Feature<Displaced> supporting_feature(const ContactShape&, const SE3<Displaced>&,
                                               const Vec3<Displaced>&) noexcept;

}  // namespace axode
