#include "axode/contact/pairs/clipping.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/contact/pairs/displaced.hpp"

namespace axode {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int most_corners = 2 * Feature<>::most_points;
constexpr double steepest = 1e-3;  // least cosine of the angle between n and a face normal

/// A polygon or segment that is being clipped by the sides of another polygon. The edge from corner i to the
/// next one has a label: its number in the original polygon, or 32 + k if it lies on side k of the other
/// polygon.
template <class T> struct Clipped {
  int count = 0;
  std::array<Vec3<T>, most_corners> point;
  std::array<std::uint32_t, most_corners> label;

  void add(const Vec3<T>& p, std::uint32_t edge) noexcept {
    if (count == most_corners) return;
    point[count] = p;
    label[count++] = edge;
  }
};

/// Returns the part of the polygon or segment `in` whose height over a plane is not positive (Sutherland and
/// Hodgman). `side` is the label of a new edge in the plane.
template <class T, class Height>
Clipped<T> keep_below(const Clipped<T>& in, bool segment, const Height& height, std::uint32_t side,
                      double rounding) noexcept {
  Clipped<T> out;
  for (int i = 0; i < in.count; ++i) {
    const int next = (i + 1) % in.count;
    const Vec3<T>&p = in.point[i], &o = in.point[next];
    const T x = height(p), y = height(o);
    const bool p_in = !(x > T(rounding)), o_in = !(y > T(rounding));
    if (p_in) out.add(p, in.label[i]);
    if (p_in == o_in || (segment && next == 0)) continue;
    // At a corner where the polygon leaves the kept part, the next edge lies in the plane and has the label
    // `side`.
    // The quotient is between 0 and 1 but for rounding errors. Beyond an end, the part keeps its derivatives,
    // unless the edge is nearly parallel to the plane, so that both heights may be rounding errors.
    constexpr double steep = 1e-4;
    const T quotient = x / (x - y), limited = std::clamp(quotient, T(0), T(1));
    const Vec3<> edge = value(o - p);
    const double rise = value(x - y);
    const bool is_steep = rise * rise > steep * steep * dot(edge, edge);
    const T part = is_steep ? quotient + T(value(limited) - value(quotient)) : limited;
    out.add(p + part * (o - p), p_in ? side : in.label[i]);
  }
  return out;
}

/// Clips a polygon or segment, the subject, by the sides of a polygon. The planes of the sides are parallel
/// to n, which points from the polygon to the subject.
template <class T>
Clipped<T> clip_by_sides(const Feature<T>& subject, const Feature<T>& polygon, const Vec3<T>& n,
                         double rounding) noexcept {
  Clipped<T> out;
  for (int i = 0; i < subject.count; ++i) out.add(subject.point[i], static_cast<std::uint32_t>(i));
  for (int k = 0; k < polygon.count && out.count > 0; ++k) {
    const Vec3<T>& corner = polygon.point[k];
    const Vec3<T> outward = cross(polygon.point[(k + 1) % polygon.count] - corner, n);
    const T length = norm(outward);
    if (!(length > T(rounding))) continue;
    const Vec3<T> side = (T(1) / length) * outward;
    out = keep_below(
        out, subject.count == 2, [&](const Vec3<T>& p) { return dot(side, p - corner); },
        32 + static_cast<std::uint32_t>(k), rounding);
  }
  return out;
}

/// Clips a polygon or segment, the subject, by a polygon, seen along the unit vector n from the polygon to
/// the subject, and adds the corners of the result as contact points. The gap of a corner (m, negative if the
/// bodies overlap) is its distance from the plane of the polygon along n, minus the radius of a capsule whose
/// axis is the subject. `flipped` is true if the subject belongs to the first shape of the pair. Returns the
/// least gap, or infinity if the result is empty.
template <class T>
double clip_by_polygon(const Feature<T>& polygon, double radius_polygon, const Feature<T>& subject,
                       double radius_subject, const Vec3<T>& n, bool flipped, double size,
                       PointList<T>& out) noexcept {
  const double rounding = 1e-10 * size;
  const T rise = dot(polygon.normal, n);
  const Clipped<T> corners = clip_by_sides(subject, polygon, n, rounding);
  const std::uint32_t faces = flipped ? subject.id << 6 | polygon.id : polygon.id << 6 | subject.id;
  double least = infinity;
  for (int i = 0; i < corners.count; ++i) {
    const int last = (i + corners.count - 1) % corners.count;
    const Vec3<T>& p = corners.point[i];
    const bool repeats = corners.count > 1 && value(norm(p - corners.point[last])) <= 4 * rounding;
    if (repeats && (i > 0 || corners.count > 2)) continue;
    const T height = dot(polygon.normal, p - polygon.point[0]) / rise;
    const T gap = height - T(radius_polygon + radius_subject);
    least = std::min(least, value(gap));
    const std::uint32_t edges = corners.label[last] << 6 | corners.label[i];
    out.add(p - (T(radius_subject) + T(0.5) * gap) * n, flipped ? -n : n, gap, faces << 12 | edges);
  }
  return least;
}

/// Adds two contact points of the segments a and b, which are axes of capsules or lines on the sides of
/// cylinders. n is the unit vector from a to b. Both segments are projected on the direction of the part of a
/// that is perpendicular to n. The contact points are at both ends of the interval that the projections have
/// in common. The gap at such an end (m, negative if the bodies overlap) is h - r_a - r_b + e² / (2 ρ). h is
/// the component along n, and e the length perpendicular to n, of the vector from the point of a to the point
/// of b with this projection. r_a and r_b are the radii of capsules, 0 for cylinders. ρ is the sum of the
/// radii of curvature of both surfaces across the segments. Returns the least gap, or infinity if the common
/// part is shorter than 1e-3 of the shorter segment.
template <class T>
double clip_segments(const Feature<T>& a, const Feature<T>& b, const FacingFeatures<T>& features,
                     PointList<T>& out) noexcept {
  const Vec3<T>& n = features.n;
  const Vec3<T> edge_a = a.point[1] - a.point[0], u = edge_a - dot(n, edge_a) * n;
  const Vec3<T> edge_b = b.point[1] - b.point[0];
  const T length2 = dot(u, u);
  const auto parameter = [&](const Vec3<T>& p) { return dot(u, p - a.point[0]) / length2; };
  const T t_0 = parameter(b.point[0]), t_1 = parameter(b.point[1]);
  const T low = std::max(T(0), std::min(t_0, t_1)), high = std::min(T(1), std::max(t_0, t_1));
  const double shorter = std::sqrt(value(std::min(dot(edge_a, edge_a), dot(edge_b, edge_b))));
  if (!(value(high - low) * std::sqrt(value(length2)) > 1e-3 * shorter)) return infinity;
  double least = infinity;
  std::uint32_t edges = 0;
  for (const T& t : {low, high}) {
    const Vec3<T> p = a.point[0] + t * edge_a, o = b.point[0] + ((t - t_0) / (t_1 - t_0)) * edge_b;
    const T height = dot(n, o - p);
    const Vec3<T> across = o - p - height * n;
    const T gap =
        height - T(features.radius_a + features.radius_b) + dot(across, across) / T(2 * features.roundness);
    least = std::min(least, value(gap));
    out.add(p + T(0.5) * across + (T(features.radius_a) + T(0.5) * gap) * n, n, gap,
            (a.id << 6 | b.id) << 12 | edges++);
  }
  return least;
}

}  // namespace

template <class T> double clip(const FacingFeatures<T>& features, PointList<T>& out) noexcept {
  const Feature<T>&a = features.a, &b = features.b;
  const Vec3<T>& n = features.n;
  const bool a_is_polygon = a.count > 2 && value(dot(a.normal, n)) > steepest;
  const bool b_is_polygon = b.count > 2 && -value(dot(b.normal, n)) > steepest;
  if (a_is_polygon && (b_is_polygon || b.count == 2))
    return clip_by_polygon(a, features.radius_a, b, features.radius_b, n, false, features.size, out);
  if (b_is_polygon && a.count == 2)
    return clip_by_polygon(b, features.radius_b, a, features.radius_a, -n, true, features.size, out);
  if (a.count == 2 && b.count == 2) return clip_segments(a, b, features, out);
  return infinity;
}

template double clip(const FacingFeatures<double>&, PointList<double>&) noexcept;
template double clip(const FacingFeatures<Displaced>&, PointList<Displaced>&) noexcept;

}  // namespace axode
