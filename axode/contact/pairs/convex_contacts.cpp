#include "axode/contact/pairs/convex_contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "axode/contact/convex/convex_distance.hpp"
#include "axode/contact/pairs/clipping.hpp"
#include "axode/contact/pairs/displaced.hpp"

namespace axode {
namespace {

constexpr std::uint32_t witness_feature = 0xffffff;

double radius_of_ball(const ContactShape& shape) {
  return shape.kind == ShapeKind::capsule ? shape.radius : 0;
}

/// Adds the contact points of two faces or segments that face each other along n, and returns the least gap.
template <class T>
double clip_along(const ContactShape& a, const SE3<T>& A, const ContactShape& b, const SE3<T>& B,
                  const Vec3<T>& n, PointList<T>& out) noexcept {
  const Feature<T> feature_a = supporting_feature(a, A, n), feature_b = supporting_feature(b, B, -n);
  return clip(FacingFeatures<T>{.a = feature_a,
                                .b = feature_b,
                                .n = n,
                                .radius_a = radius_of_ball(a),
                                .radius_b = radius_of_ball(b),
                                .roundness = a.radius + b.radius,
                                .size = a.convex.extent + b.convex.extent},
              out);
}

/// Adds these points if one of them is as near as the bodies, whose distance is at least `distance`, and
/// says whether it is.
template <class T>
bool clip_at(double distance, const ContactShape& a, const SE3<T>& A, const ContactShape& b, const SE3<T>& B,
             const Vec3<T>& n, PointList<T>& out) noexcept {
  const double tolerance = 1e-8 * (a.convex.extent + b.convex.extent);
  PointList<T> clipped = out;
  if (clip_along(a, A, b, B, n, clipped) > distance + tolerance) return false;
  out = clipped;
  return true;
}

/// The separation of two boxes along one axis.
template <class T> struct Separation {
  Vec3<T> n{};  ///< unit vector from box a to box b
  double gap = -std::numeric_limits<double>::infinity();
};
/// The separation of two boxes along the axis of the normal, and the greatest of all axes. These differ
/// where a face and a pair of edges separate the boxes nearly as well, and the face is preferred.
template <class T> struct Separations {
  Separation<T> normal;
  double greatest;
};

template <class T> std::array<const Vec3<T>*, 3> axes(const SE3<T>& C) { return {&C.R.x, &C.R.y, &C.R.z}; }

double half_width(const ContactShape& box, const SO3<>& R, const Vec3<>& n) {
  return box.half.x * std::abs(dot(R.x, n)) + box.half.y * std::abs(dot(R.y, n)) +
         box.half.z * std::abs(dot(R.z, n));
}

template <class T>
Separations<T> separate(const ContactShape& a, const SE3<T>& A, const ContactShape& b,
                        const SE3<T>& B) noexcept {
  const Vec3<T> r = B.r - A.r;
  const SO3<> R_a = value(A.R), R_b = value(B.R);
  const auto along = [&](const Vec3<T>& axis) -> Separation<T> {
    const Vec3<> n = value(axis);
    const double way = value(dot(axis, r));
    return {way < 0 ? -axis : axis, std::abs(way) - half_width(a, R_a, n) - half_width(b, R_b, n)};
  };
  const double size = a.convex.extent + b.convex.extent;
  Separation<T> best;
  const auto prefer = [&](const Vec3<T>& axis, double bias) {
    const Separation<T> s = along(axis);
    if (s.gap > best.gap + bias) best = s;
  };
  const double bias_of_b = 1e-9 * size, bias_of_edges = 1e-6 * size;
  for (const Vec3<T>* u : axes(A)) prefer(*u, 0);
  const Separation<T> of_a = best;
  best = {};
  for (const Vec3<T>* w : axes(B)) prefer(*w, 0);
  if (!(best.gap > of_a.gap + bias_of_b)) best = of_a;
  const Separation<T> of_faces = best;
  best = {};
  for (const Vec3<T>* u : axes(A))
    for (const Vec3<T>* w : axes(B)) {
      const Vec3<T> axis = cross(*u, *w);
      const T sine = norm(axis);
      if (sine > T(1e-6)) prefer((T(1) / sine) * axis, 0);
    }
  return {best.gap > of_faces.gap + bias_of_edges ? best : of_faces, std::max(best.gap, of_faces.gap)};
}

/// The edge of a polygon whose two corners are farthest along n, as a vector; the vector 0 if only one corner
/// is, within the tolerance.
template <class T>
Vec3<T> supporting_edge(const Feature<T>& polygon, const Vec3<>& n, double tolerance) noexcept {
  double farthest = -std::numeric_limits<double>::infinity();
  for (int k = 0; k < polygon.count; ++k) farthest = std::max(farthest, dot(n, value(polygon.point[k])));
  const auto is_far = [&](int k) { return dot(n, value(polygon.point[k])) > farthest - tolerance; };
  for (int k = 0; k < polygon.count; ++k)
    if (const int next = (k + 1) % polygon.count; is_far(k) && is_far(next))
      return polygon.point[next] - polygon.point[k];
  return {};
}

bool has_plane_faces(const ContactShape& shape) {
  return shape.kind == ShapeKind::box || shape.kind == ShapeKind::mesh;
}

}  // namespace

bool touch_polytopes(const ContactShape& a, const SE3<Displaced>& A, const ContactShape& b,
                     const SE3<Displaced>& B, PointList<Displaced>& out) noexcept {
  if (!has_plane_faces(a) || !has_plane_faces(b)) return false;
  const ConvexDistance d = convex_distance(a.convex, value(A), b.convex, value(B));
  if (!(d.distance < out.margin())) return true;
  constexpr double parallel = 1e-6;
  const double tolerance = 1e-8 * (a.convex.extent + b.convex.extent);
  const Vec3<Displaced> along = cast<Displaced>(d.normal);
  const Feature<Displaced> of_a = supporting_feature(a, A, along), of_b = supporting_feature(b, B, -along);
  Vec3<Displaced> n;
  if (norm(value(of_a.normal) - d.normal) < parallel) {
    n = of_a.normal;
  } else if (norm(value(of_b.normal) + d.normal) < parallel) {
    n = -of_b.normal;
  } else {
    n = cross(supporting_edge(of_a, d.normal, tolerance), supporting_edge(of_b, -d.normal, tolerance));
    if (!(dot(n, n) > Displaced(0))) return false;
    n = (Displaced(dot(value(n), d.normal) < 0 ? -1 : 1) / norm(n)) * n;
    if (!(norm(value(n) - d.normal) < parallel)) return false;
  }
  return clip_at(d.distance, a, A, b, B, n, out);
}

void touch_convex(const ContactShape& a, const SE3<>& A, const ContactShape& b, const SE3<>& B,
                  PointList<>& out) noexcept {
  const ConvexDistance d = convex_distance(a.convex, A, b.convex, B);
  if (!(d.distance < out.margin())) return;
  const double least = clip_along(a, A, b, B, d.normal, out);
  const double tolerance = 1e-8 * (a.convex.extent + b.convex.extent);
  if (least > d.distance + tolerance)
    out.add(0.5 * (d.point_a + d.point_b), d.normal, d.distance, witness_feature);
}

template <class T>
bool touch_boxes(const ContactShape& a, const SE3<T>& A, const ContactShape& b, const SE3<T>& B,
                 PointList<T>& out) noexcept {
  const auto [normal, greatest] = separate(a, A, b, B);
  if (!(normal.gap < out.margin())) return true;
  return clip_at(greatest, a, A, b, B, normal.n, out);
}

template bool touch_boxes(const ContactShape&, const SE3<>&, const ContactShape&, const SE3<>&,
                          PointList<>&) noexcept;
template bool touch_boxes(const ContactShape&, const SE3<Displaced>&, const ContactShape&,
                          const SE3<Displaced>&, PointList<Displaced>&) noexcept;

}  // namespace axode
