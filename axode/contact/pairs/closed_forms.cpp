#include "axode/contact/pairs/closed_forms.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "axode/contact/convex/support.hpp"

namespace axode {

namespace {

/// The vertices of a hull that are within the margin of a plane: all of them or, if there are many, the
/// deepest one and those that are farthest along eight directions in the plane.
void touch_plane_by_hull(const SE3<>& plane, const Hull& hull, const SE3<>& pose, PointList& out) noexcept {
  constexpr int directions = 8;
  struct Farthest {
    double along = -std::numeric_limits<double>::infinity();
    int vertex = -1;
    void update(double x, int i) noexcept {
      if (x > along) *this = {x, i};
    }
  };
  const SE3<> C = inverse(plane) * pose;
  std::array<Farthest, directions + 1> chosen;
  int near = 0;
  for (int i = 0; i < std::ssize(hull.vertices); ++i) {
    const Vec3<> p = C * hull.vertices[i];
    if (!(p.z < out.margin())) continue;
    ++near;
    const double diagonal = std::numbers::sqrt2 / 2;
    chosen[0].update(-p.z, i);
    int k = 1;
    for (const double x : {p.x, p.y, diagonal * (p.x + p.y), diagonal * (p.x - p.y)})
      for (const double along : {x, -x}) chosen[k++].update(along, i);
  }
  const auto add = [&](int i) {
    const Vec3<> p = pose * hull.vertices[i];
    out.add(p, plane.R.z, dot(plane.R.z, p - plane.r), static_cast<std::uint32_t>(i));
  };
  if (near <= 2 * directions) {
    for (int i = 0; i < std::ssize(hull.vertices); ++i) add(i);
    return;
  }
  std::ranges::sort(chosen, {}, &Farthest::vertex);
  int last = -1;
  for (const Farthest& it : chosen)
    if (it.vertex != std::exchange(last, it.vertex)) add(it.vertex);
}

}  // namespace

void touch_plane(const SE3<>& plane, const ContactShape& shape, const SE3<>& pose, PointList& out) noexcept {
  const Vec3<>&n = plane.R.z, &axis = pose.R.z;
  std::uint32_t feature = 0;
  const auto add = [&](const Vec3<>& p) { out.add(p, n, dot(n, p - plane.r), feature++); };
  switch (shape.kind) {
    case ShapeKind::sphere: add(pose.r - shape.radius * n); break;
    case ShapeKind::capsule:
      for (const double end : {-shape.half_length, shape.half_length})
        add(pose.r + end * axis - shape.radius * n);
      break;
    case ShapeKind::box:
      for (const double x : {-shape.half.x, shape.half.x})
        for (const double y : {-shape.half.y, shape.half.y})
          for (const double z : {-shape.half.z, shape.half.z}) add(pose * Vec3<>{x, y, z});
      break;
    case ShapeKind::cylinder: {
      const Vec3<> d = shape.radius * convex::across(axis, -n, pose.R.x), e = cross(axis, d);
      for (const double end : {-shape.half_length, shape.half_length})
        for (const Vec3<>& rim : {d, e, -d, -e}) add(pose.r + end * axis + rim);
      break;
    }
    case ShapeKind::ellipsoid: add(pose * convex::support_point(shape.convex, transpose(pose.R) * -n)); break;
    case ShapeKind::mesh: touch_plane_by_hull(plane, *shape.convex.hull, pose, out); break;
    case ShapeKind::plane: break;
  }
}

namespace {

/// The axis of a sphere or capsule: centre + t half for t from -1 to 1.
struct Axis {
  Vec3<> center, half;
  double radius;

  Axis(const ContactShape& shape, const SE3<>& pose)
      : center(pose.r),
        half(shape.kind == ShapeKind::capsule ? shape.half_length * pose.R.z : Vec3<>{}),
        radius(shape.radius) {}
  Vec3<> at(double t) const { return center + t * half; }
  /// Parameter of the point that is nearest to p.
  double nearest(const Vec3<>& p) const {
    const double length2 = dot(half, half);
    return length2 > 0 ? std::clamp(dot(half, p - center) / length2, -1.0, 1.0) : 0;
  }
};

/// Parameter on a of the nearest points of two axes (Ericson, Real-Time Collision Detection, section 5.1.9).
double nearest_parameter(const Axis& a, const Axis& b) {
  const Vec3<> r = a.center - b.center;
  const double aa = dot(a.half, a.half), ab = dot(a.half, b.half), bb = dot(b.half, b.half);
  const double determinant = aa * bb - ab * ab;
  if (!(determinant > 1e-14 * aa * bb)) return a.nearest(b.center);
  const double s = std::clamp((ab * dot(b.half, r) - bb * dot(a.half, r)) / determinant, -1.0, 1.0);
  return a.nearest(b.at(b.nearest(a.at(s))));
}

}  // namespace

void touch_round(const ContactShape& shape_a, const SE3<>& A, const ContactShape& shape_b, const SE3<>& B,
                 PointList& out) noexcept {
  const Axis a(shape_a, A), b(shape_b, B);
  struct Candidate {
    Vec3<> p, n;
    double gap;
  };
  const auto between = [&](const Vec3<>& p, const Vec3<>& o) -> Candidate {
    const double distance = norm(o - p), gap = distance - a.radius - b.radius;
    Vec3<> n = cross(a.half, b.half);  // the direction in which axes that cross part soonest
    if (distance > 0)
      n = (1 / distance) * (o - p);
    else
      n = norm(n) > 0 ? convex::unit(n) : convex::perpendicular(norm(a.half) > 0 ? A.R.z : B.R.z);
    return {p + (a.radius + gap / 2) * n, n, gap};
  };
  const auto add = [&](const Candidate& c, std::uint32_t feature) { out.add(c.p, c.n, c.gap, feature); };

  const double s = nearest_parameter(a, b);
  const Candidate nearest = between(a.at(s), b.at(b.nearest(a.at(s))));
  if (!(nearest.gap < out.margin())) return;
  if (!(dot(a.half, a.half) > 0 && dot(b.half, b.half) > 0)) return add(nearest, 0);

  // The part of a that lies beside b ends at an end of a or beside an end of b.
  const double first = dot(a.half, b.half) < 0 ? 1 : -1;  // the end of b on the side of t = -1
  const auto end = [&](double of_a, double of_b) {
    const double t = dot(a.half, b.at(of_b) - a.center) / dot(a.half, a.half);
    const bool at_a = of_a < 0 ? t <= -1 : t >= 1;
    return at_a ? between(a.at(of_a), b.at(b.nearest(a.at(of_a))))
                : between(a.at(a.nearest(b.at(of_b))), b.at(of_b));
  };
  const Candidate low = end(-1, first), high = end(1, -first);
  const double size = norm(a.half) + norm(b.half) + a.radius + b.radius;
  const bool side_by_side = norm(high.p - low.p) > 1e-3 * std::min(norm(a.half), norm(b.half));
  const double rounding = 1e-12 * size;
  if (!side_by_side || nearest.gap < std::min(low.gap, high.gap) - rounding) add(nearest, 0);
  if (!side_by_side) return;
  add(low, 1);
  add(high, 2);
}

void touch_box_and_sphere(const ContactShape& box, const SE3<>& A, const ContactShape& sphere, const SE3<>& B,
                          PointList& out) noexcept {
  const Vec3<> c = transpose(A.R) * (B.r - A.r);
  const Vec3<>& h = box.half;
  Vec3<> p{std::clamp(c.x, -h.x, h.x), std::clamp(c.y, -h.y, h.y), std::clamp(c.z, -h.z, h.z)};
  Vec3<> n{};
  double distance = norm(c - p);
  if (distance > 0) {
    n = (1 / distance) * (c - p);
  } else {  // the centre is inside, and leaves through the nearest face
    const std::array<double, 3> depth{h.x - std::abs(c.x), h.y - std::abs(c.y), h.z - std::abs(c.z)};
    const auto nearest = std::ranges::min_element(depth) - depth.begin();
    const auto move = [](double& to, double& direction, double half, double at) {
      direction = std::copysign(1.0, at);
      to = direction * half;
    };
    if (nearest == 0) move(p.x, n.x, h.x, c.x);
    if (nearest == 1) move(p.y, n.y, h.y, c.y);
    if (nearest == 2) move(p.z, n.z, h.z, c.z);
    distance = -depth[nearest];
  }
  const double gap = distance - sphere.radius;
  out.add(A * (p + (gap / 2) * n), A.R * n, gap, 0);
}

}  // namespace axode
