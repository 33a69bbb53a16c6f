#include "axode/contact/pairs/clipping.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace axode {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int most_corners = 2 * Feature::most_points;
constexpr double steepest = 1e-3;  // least cosine between the normal of a face and n

/// A polygon or segment that is clipped. The edge from corner i to the next one has a label: its number, or
/// 32 + k if it lies on side k of the other polygon.
struct Clipped {
  int count = 0;
  std::array<Vec3<>, most_corners> point;
  std::array<std::uint32_t, most_corners> label;

  void add(const Vec3<>& p, std::uint32_t edge) noexcept {
    if (count == most_corners) return;
    point[count] = p;
    label[count++] = edge;
  }
};

/// Keeps the part of `in` whose height over a plane is not positive (Sutherland and Hodgman).
template <class Height>
Clipped keep_below(const Clipped& in, bool segment, const Height& height, std::uint32_t side,
                   double rounding) noexcept {
  Clipped out;
  for (int i = 0; i < in.count; ++i) {
    const int next = (i + 1) % in.count;
    const Vec3<>&p = in.point[i], &o = in.point[next];
    const double x = height(p), y = height(o);
    const bool p_in = x <= rounding, o_in = y <= rounding;
    if (p_in) out.add(p, in.label[i]);
    if (p_in == o_in || (segment && next == 0)) continue;
    // The edge that follows a corner where the polygon leaves is on the side itself.
    const double part = std::clamp(x / (x - y), 0.0, 1.0);  // both heights may be rounding errors
    out.add(p + part * (o - p), p_in ? side : in.label[i]);
  }
  return out;
}

/// Clips a subject by the sides of a polygon. `n` points from the polygon to the subject.
Clipped clip_by_sides(const Feature& subject, const Feature& polygon, const Vec3<>& n,
                      double rounding) noexcept {
  Clipped out;
  for (int i = 0; i < subject.count; ++i) out.add(subject.point[i], static_cast<std::uint32_t>(i));
  for (int k = 0; k < polygon.count && out.count > 0; ++k) {
    const Vec3<>& corner = polygon.point[k];
    const Vec3<> outward = cross(polygon.point[(k + 1) % polygon.count] - corner, n);
    const double length = norm(outward);
    if (!(length > rounding)) continue;
    const Vec3<> side = (1 / length) * outward;
    out = keep_below(
        out, subject.count == 2, [&](const Vec3<>& p) { return dot(side, p - corner); },
        32 + static_cast<std::uint32_t>(k), rounding);
  }
  return out;
}

/// The corners of a subject beside a polygon; `n` points from the polygon to the subject.
double clip_by_polygon(const Feature& polygon, double radius_polygon, const Feature& subject,
                       double radius_subject, const Vec3<>& n, bool flipped, double size,
                       PointList& out) noexcept {
  const double rounding = 1e-10 * size, rise = dot(polygon.normal, n);
  const Clipped corners = clip_by_sides(subject, polygon, n, rounding);
  const std::uint32_t faces = flipped ? subject.id << 6 | polygon.id : polygon.id << 6 | subject.id;
  double least = infinity;
  for (int i = 0; i < corners.count; ++i) {
    const int last = (i + corners.count - 1) % corners.count;
    const Vec3<>& p = corners.point[i];
    const bool repeats = corners.count > 1 && norm(p - corners.point[last]) <= 4 * rounding;
    if (repeats && (i > 0 || corners.count > 2)) continue;
    const double height = dot(polygon.normal, p - polygon.point[0]) / rise;
    const double gap = height - radius_polygon - radius_subject;
    least = std::min(least, gap);
    const std::uint32_t edges = corners.label[last] << 6 | corners.label[i];
    out.add(p - (radius_subject + gap / 2) * n, flipped ? -n : n, gap, faces << 12 | edges);
  }
  return least;
}

/// The ends of the part along which two segments lie side by side, seen along n. The gap grows with the
/// distance e of the lines across n as e² / (2 (radius_a + radius_b)), which the curvatures of their surfaces
/// add to it.
double clip_segments(const Feature& a, const Feature& b, const FacingFeatures& features,
                     PointList& out) noexcept {
  const Vec3<>& n = features.n;
  const Vec3<> edge_a = a.point[1] - a.point[0], u = edge_a - dot(n, edge_a) * n;
  const Vec3<> edge_b = b.point[1] - b.point[0];
  const double length2 = dot(u, u);
  const auto parameter = [&](const Vec3<>& p) { return dot(u, p - a.point[0]) / length2; };
  const double t_0 = parameter(b.point[0]), t_1 = parameter(b.point[1]);
  const double low = std::max(0.0, std::min(t_0, t_1)), high = std::min(1.0, std::max(t_0, t_1));
  const double shorter = std::sqrt(std::min(dot(edge_a, edge_a), dot(edge_b, edge_b)));
  if (!((high - low) * std::sqrt(length2) > 1e-3 * shorter)) return infinity;
  double least = infinity;
  std::uint32_t edges = 0;
  for (const double t : {low, high}) {
    const Vec3<> p = a.point[0] + t * edge_a, o = b.point[0] + ((t - t_0) / (t_1 - t_0)) * edge_b;
    const double height = dot(n, o - p);
    const Vec3<> across = o - p - height * n;
    const double gap =
        height - features.radius_a - features.radius_b + dot(across, across) / (2 * features.roundness);
    least = std::min(least, gap);
    out.add(p + 0.5 * across + (features.radius_a + gap / 2) * n, n, gap, (a.id << 6 | b.id) << 12 | edges++);
  }
  return least;
}

}  // namespace

double clip(const FacingFeatures& features, PointList& out) noexcept {
  const Feature &a = features.a, &b = features.b;
  const Vec3<>& n = features.n;
  const bool a_is_polygon = a.count > 2 && dot(a.normal, n) > steepest;
  const bool b_is_polygon = b.count > 2 && -dot(b.normal, n) > steepest;
  if (a_is_polygon && (b_is_polygon || b.count == 2))
    return clip_by_polygon(a, features.radius_a, b, features.radius_b, n, false, features.size, out);
  if (b_is_polygon && a.count == 2)
    return clip_by_polygon(b, features.radius_b, a, features.radius_a, -n, true, features.size, out);
  if (a.count == 2 && b.count == 2) return clip_segments(a, b, features, out);
  return infinity;
}

}  // namespace axode
