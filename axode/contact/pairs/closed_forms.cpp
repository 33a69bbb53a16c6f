#include "axode/contact/pairs/closed_forms.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <utility>

#include "axode/contact/convex/support.hpp"
#include "axode/contact/pairs/displaced.hpp"

namespace axode {

namespace {

/// Adds the points of contact of a plane and a convex hull to the list `out`. They are the vertices of the
/// hull whose distance from the plane (m, negative behind it) is less than out.margin(). If there are more
/// than 16, only the deepest one and those that are farthest along eight directions in the plane are added.
template <class T>
void touch_plane_by_hull(const SE3<T>& plane, const Hull& hull, const SE3<T>& pose,
                         PointList<T>& out) noexcept {
  constexpr int directions = 8;
  struct Farthest {
    double along = -std::numeric_limits<double>::infinity();
    int vertex = -1;
    void update(double x, int i) noexcept {
      if (x > along) *this = {x, i};
    }
  };
  const SE3<> C = value(inverse(plane) * pose);
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
    const Vec3<T> p = pose * cast<T>(hull.vertices[i]);
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

template <class T>
void touch_plane(const SE3<T>& plane, const ContactShape& shape, const SE3<T>& pose,
                 PointList<T>& out) noexcept {
  const Vec3<T>&n = plane.R.z, &axis = pose.R.z;
  std::uint32_t feature = 0;
  const auto add = [&](const Vec3<T>& p) { out.add(p, n, dot(n, p - plane.r), feature++); };
  switch (shape.kind) {
    case ShapeKind::sphere: add(pose.r - T(shape.radius) * n); break;
    case ShapeKind::capsule:
      for (const double end : {-shape.half_length, shape.half_length})
        add(pose.r + T(end) * axis - T(shape.radius) * n);
      break;
    case ShapeKind::box:
      for (const double x : {-shape.half.x, shape.half.x})
        for (const double y : {-shape.half.y, shape.half.y})
          for (const double z : {-shape.half.z, shape.half.z}) add(pose * Vec3<T>{T(x), T(y), T(z)});
      break;
    case ShapeKind::cylinder: {
      const Vec3<T> d = T(shape.radius) * convex::across(axis, -n, pose.R.x), e = cross(axis, d);
      for (const double end : {-shape.half_length, shape.half_length})
        for (const Vec3<T>& rim : {d, e, -d, -e}) add(pose.r + T(end) * axis + rim);
      break;
    }
    case ShapeKind::ellipsoid: {
      const Vec3<T> m = transpose(pose.R) * -n, h = cast<T>(shape.half);
      const Vec3<T> s = convex::unit(Vec3<T>{h.x * m.x, h.y * m.y, h.z * m.z});
      add(pose * Vec3<T>{h.x * s.x, h.y * s.y, h.z * s.z});
      break;
    }
    case ShapeKind::mesh: touch_plane_by_hull(plane, *shape.convex.hull, pose, out); break;
    case ShapeKind::plane: break;
  }
}

/// The axes of shapes with rounded ends.
namespace round_shapes {

/// The axis of a sphere or capsule: the points center + t half for t from -1 to 1; `half` is 0 for a sphere.
template <class T> struct Axis {
  Vec3<T> center, half;
  T radius;

  Axis(const ContactShape& shape, const SE3<T>& pose)
      : center(pose.r),
        half(shape.kind == ShapeKind::capsule ? T(shape.half_length) * pose.R.z : Vec3<T>{}),
        radius(shape.radius) {}
  Vec3<T> at(const T& t) const { return center + t * half; }
  /// The parameter t of the point of the axis that is nearest to p.
  T nearest(const Vec3<T>& p) const {
    const T length2 = dot(half, half);
    return length2 > T(0) ? std::clamp(dot(half, p - center) / length2, T(-1), T(1)) : T(0);
  }
};

/// The parameter t, from -1 to 1, of that point of axis a which is nearest to axis b (Ericson, Real-Time
/// Collision Detection, section 5.1.9). The points of axis a are a.center + t a.half.
template <class T> T nearest_parameter(const Axis<T>& a, const Axis<T>& b) {
  const Vec3<T> r = a.center - b.center;
  const T aa = dot(a.half, a.half), ab = dot(a.half, b.half), bb = dot(b.half, b.half);
  const T determinant = aa * bb - ab * ab;
  if (!(determinant > T(1e-14) * aa * bb)) return a.nearest(b.center);
  const T s = std::clamp((ab * dot(b.half, r) - bb * dot(a.half, r)) / determinant, T(-1), T(1));
  return a.nearest(b.at(b.nearest(a.at(s))));
}

}  // namespace round_shapes

template <class T>
void touch_round(const ContactShape& shape_a, const SE3<T>& A, const ContactShape& shape_b, const SE3<T>& B,
                 PointList<T>& out) noexcept {
  const round_shapes::Axis<T> a(shape_a, A), b(shape_b, B);
  struct Candidate {
    Vec3<T> p, n;
    T gap;
  };
  const auto between = [&](const Vec3<T>& p, const Vec3<T>& o) -> Candidate {
    const T distance = length(o - p), gap = distance - a.radius - b.radius;
    Vec3<T> n = cross(a.half, b.half);  // the direction in which axes that cross part soonest
    if (distance > T(0))
      n = (T(1) / distance) * (o - p);
    else
      n = dot(n, n) > T(0) ? convex::unit(n)
                           : convex::perpendicular(dot(a.half, a.half) > T(0) ? A.R.z : B.R.z);
    return {p + (a.radius + T(0.5) * gap) * n, n, gap};
  };
  const auto add = [&](const Candidate& c, std::uint32_t feature) { out.add(c.p, c.n, c.gap, feature); };

  const T s = nearest_parameter(a, b);
  const Candidate nearest = between(a.at(s), b.at(b.nearest(a.at(s))));
  if (!(nearest.gap < T(out.margin()))) return;
  if (!(dot(a.half, a.half) > T(0) && dot(b.half, b.half) > T(0))) return add(nearest, 0);

  // The part of a that lies beside b ends at an end of a or beside an end of b.
  const double first = dot(a.half, b.half) < T(0) ? 1 : -1;  // the end of b on the side of t = -1
  const auto end = [&](double of_a, double of_b) {
    const T t = dot(a.half, b.at(T(of_b)) - a.center) / dot(a.half, a.half);
    const bool at_a = of_a < 0 ? !(t > T(-1)) : !(t < T(1));
    return at_a ? between(a.at(T(of_a)), b.at(b.nearest(a.at(T(of_a)))))
                : between(a.at(a.nearest(b.at(T(of_b)))), b.at(T(of_b)));
  };
  const Candidate low = end(-1, first), high = end(1, -first);
  const double length_a = value(norm(a.half)), length_b = value(norm(b.half));
  const double size = length_a + length_b + value(a.radius + b.radius);
  const bool side_by_side = norm(value(high.p - low.p)) > 1e-3 * std::min(length_a, length_b);
  const double rounding = 1e-12 * size;
  if (!side_by_side || value(nearest.gap) < value(std::min(low.gap, high.gap)) - rounding) add(nearest, 0);
  if (!side_by_side) return;
  add(low, 1);
  add(high, 2);
}

template <class T>
void touch_box_and_sphere(const ContactShape& box, const SE3<T>& A, const ContactShape& sphere,
                          const SE3<T>& B, PointList<T>& out) noexcept {
  const Vec3<T> c = transpose(A.R) * (B.r - A.r), h = cast<T>(box.half);
  Vec3<T> p{std::clamp(c.x, -h.x, h.x), std::clamp(c.y, -h.y, h.y), std::clamp(c.z, -h.z, h.z)};
  Vec3<T> n{};
  T distance = length(c - p);
  if (distance > T(0)) {
    n = (T(1) / distance) * (c - p);
  } else {  // the centre is inside, and leaves through the nearest face
    const auto inside = [](const T& half, const T& at) { return at < T(0) ? half + at : half - at; };
    const std::array<T, 3> depth{inside(h.x, c.x), inside(h.y, c.y), inside(h.z, c.z)};
    const auto nearest = std::min_element(depth.begin(), depth.end()) - depth.begin();
    const auto move = [](T& to, T& direction, const T& half, const T& at) {
      direction = at < T(0) ? T(-1) : T(1);
      to = direction * half;
    };
    if (nearest == 0) move(p.x, n.x, h.x, c.x);
    if (nearest == 1) move(p.y, n.y, h.y, c.y);
    if (nearest == 2) move(p.z, n.z, h.z, c.z);
    distance = -depth[nearest];
  }
  const T gap = distance - T(sphere.radius);
  out.add(A * (p + (T(0.5) * gap) * n), A.R * n, gap, 0);
}

template void touch_plane(const SE3<>&, const ContactShape&, const SE3<>&, PointList<>&) noexcept;
template void touch_plane(const SE3<Displaced>&, const ContactShape&, const SE3<Displaced>&,
                          PointList<Displaced>&) noexcept;
template void touch_round(const ContactShape&, const SE3<>&, const ContactShape&, const SE3<>&,
                          PointList<>&) noexcept;
template void touch_round(const ContactShape&, const SE3<Displaced>&, const ContactShape&,
                          const SE3<Displaced>&, PointList<Displaced>&) noexcept;
template void touch_box_and_sphere(const ContactShape&, const SE3<>&, const ContactShape&, const SE3<>&,
                                   PointList<>&) noexcept;
template void touch_box_and_sphere(const ContactShape&, const SE3<Displaced>&, const ContactShape&,
                                   const SE3<Displaced>&, PointList<Displaced>&) noexcept;

}  // namespace axode
