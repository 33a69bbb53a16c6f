#include "axode/contact/pairs/convex_contacts.hpp"

#include <array>
#include <cmath>

#include "axode/contact/convex/convex_distance.hpp"
#include "axode/contact/pairs/clipping.hpp"

namespace axode {
namespace {

constexpr std::uint32_t witness_feature = 0xffffff;

double radius_of_ball(const ContactShape& shape) {
  return shape.kind == ShapeKind::capsule ? shape.radius : 0;
}

/// Clips the features that face each other along n.
double clip_along(const ContactShape& a, const SE3<>& A, const ContactShape& b, const SE3<>& B,
                  const Vec3<>& n, PointList& out) noexcept {
  const Feature feature_a = supporting_feature(a, A, n), feature_b = supporting_feature(b, B, -n);
  return clip({.a = feature_a,
               .b = feature_b,
               .n = n,
               .radius_a = radius_of_ball(a),
               .radius_b = radius_of_ball(b),
               .roundness = a.radius + b.radius,
               .size = a.convex.extent + b.convex.extent},
              out);
}

/// The separation of two boxes along the best axis.
struct Separation {
  Vec3<> n{};  ///< unit vector from a to b
  double gap = -std::numeric_limits<double>::infinity();
};

std::array<const Vec3<>*, 3> axes(const SE3<>& C) { return {&C.R.x, &C.R.y, &C.R.z}; }

double half_width(const ContactShape& box, const SE3<>& C, const Vec3<>& n) {
  return box.half.x * std::abs(dot(C.R.x, n)) + box.half.y * std::abs(dot(C.R.y, n)) +
         box.half.z * std::abs(dot(C.R.z, n));
}

Separation separate(const ContactShape& a, const SE3<>& A, const ContactShape& b, const SE3<>& B) noexcept {
  const Vec3<> r = B.r - A.r;
  const auto along = [&](const Vec3<>& axis) -> Separation {
    const double way = dot(axis, r);
    return {way < 0 ? -axis : axis, std::abs(way) - half_width(a, A, axis) - half_width(b, B, axis)};
  };
  const double size = a.convex.extent + b.convex.extent;
  Separation best;
  const auto prefer = [&](const Vec3<>& axis, double bias) {
    const Separation s = along(axis);
    if (s.gap > best.gap + bias) best = s;
  };
  const double bias_of_b = 1e-9 * size, bias_of_edges = 1e-6 * size;
  for (const Vec3<>* u : axes(A)) prefer(*u, 0);
  const Separation of_a = best;
  best = {};
  for (const Vec3<>* w : axes(B)) prefer(*w, 0);
  if (!(best.gap > of_a.gap + bias_of_b)) best = of_a;
  const Separation of_faces = best;
  best = {};
  for (const Vec3<>* u : axes(A))
    for (const Vec3<>* w : axes(B)) {
      const Vec3<> axis = cross(*u, *w);
      const double sine = norm(axis);
      if (sine > 1e-6) prefer((1 / sine) * axis, 0);
    }
  return best.gap > of_faces.gap + bias_of_edges ? best : of_faces;
}

}  // namespace

void touch_convex(const ContactShape& a, const SE3<>& A, const ContactShape& b, const SE3<>& B,
                  PointList& out) noexcept {
  const ConvexDistance d = convex_distance(a.convex, A, b.convex, B);
  if (!(d.distance < out.margin())) return;
  const double least = clip_along(a, A, b, B, d.normal, out);
  const double tolerance = 1e-8 * (a.convex.extent + b.convex.extent);
  if (least > d.distance + tolerance)
    out.add(0.5 * (d.point_a + d.point_b), d.normal, d.distance, witness_feature);
}

void touch_boxes(const ContactShape& a, const SE3<>& A, const ContactShape& b, const SE3<>& B,
                 PointList& out) noexcept {
  const Separation s = separate(a, A, b, B);
  if (!(s.gap < out.margin())) return;
  PointList clipped = out;
  const double least = clip_along(a, A, b, B, s.n, clipped);
  const double tolerance = 1e-8 * (a.convex.extent + b.convex.extent);
  if (least > s.gap + tolerance) return touch_convex(a, A, b, B, out);
  out = clipped;
}

}  // namespace axode
