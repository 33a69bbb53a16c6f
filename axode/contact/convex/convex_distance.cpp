#include "axode/contact/convex/convex_distance.hpp"

#include <algorithm>

#include "axode/contact/convex/core_pair.hpp"
#include "axode/contact/convex/expanding_polytope.hpp"
#include "axode/contact/convex/least_norm.hpp"
#include "axode/contact/convex/stationary_normal.hpp"

namespace axode {
namespace convex {
namespace {

bool is_curved(const ConvexShape& shape) {
  return shape.core == ConvexShape::Core::cylinder || shape.core == ConvexShape::Core::ellipsoid;
}

/// A hull vertex at which the search for a support branch may start: `last` if it exists, otherwise 0.
int start_vertex(const ConvexShape& shape, int last) {
  const bool exists = shape.hull != nullptr && last >= 0 && last < std::ssize(shape.hull->vertices);
  return exists ? last : 0;
}

/// Compares two candidates c and t for the least distance of two cores (convex bodies without the balls that
/// round them), and keeps the better one in c. A candidate is a unit normal n, the width s of the gap between
/// the cores along n, and a point x of their difference (the set of all b - a with points a and b of the two
/// cores); its residual is |x - s n|. t is better if its width is larger, or equal to rounding with a smaller
/// residual. If t is not better, but its point has a smaller residual with the n and s of c, only this point
/// is stored in c. Returns whether c has changed.
bool improve(const CorePair& pair, Candidate& c, const Candidate& t) noexcept {
  const bool higher = t.s > c.s + pair.rounding;
  const bool as_high = t.s >= c.s - pair.rounding;
  if (higher || (as_high && t.residual < c.residual)) {
    c = t;
    return true;
  }
  const double residual = norm(t.simplex.point() - c.s * c.n);
  if (t.simplex.count == 0 || !(residual < c.residual)) return false;
  c.simplex = t.simplex;
  c.residual = residual;
  return true;
}

/// Improves a candidate c for the distance of two cores (convex bodies without the balls that round them) by
/// at most `rounds` proximal steps (D10.7). A candidate is a unit normal n, the width s of the gap between
/// the cores along n, and weighted points of the difference of the cores, which is the set of all b - a with
/// points a and b of the two cores. The residual of c is the distance of the weighted mean of its points from
/// s n. A step shifts the difference along n by pair.step, 0.5 % of the radius of a ball around the smaller
/// body, or by pair.step - s if s is negative, so that it does not contain the origin. The new normal is the
/// direction of the point of least norm of the shifted difference. For cylinders and ellipsoids, the first
/// steps compute this point only roughly. The function ends early if the residual is a rounding error, or if
/// a step with a point that is exact to rounding does not improve c.
void ascend(CorePair& pair, Candidate& c, int rounds) noexcept {
  double gap = pair.curved ? pair.step / 16 : pair.rounding;
  for (int k = 0; k < rounds && c.residual > pair.rounding; ++k) {
    Candidate t;
    t.n = c.n;
    least_norm(pair, t, (std::max(0.0, -c.s) + pair.step) * c.n, gap);
    close_residual(pair, t);
    if (!improve(pair, c, t) && gap <= pair.rounding) return;
    gap = std::max(gap / 256, pair.rounding);
  }
}

/// Computes the least distance of two cores (convex bodies without the balls that round them) that are apart:
/// the least norm of b - a for points a and b of the two cores. The result is a candidate: the unit normal n
/// along b - a, the width s of the gap between the cores along n, the points, and the residual |b - a - s n|.
/// The result replaces the candidate c if its width is larger than that of c, or equal to rounding with a
/// smaller residual. Otherwise c keeps its normal and width, and takes only the points of the result if they
/// make the residual of c smaller. If the cores overlap, c does not change.
void approach(CorePair& pair, Candidate& c) noexcept {
  Candidate direct;
  direct.n = c.n;
  double gap = pair.curved ? std::max(pair.step / 4, pair.rounding) : pair.rounding;
  for (;;) {
    least_norm(pair, direct, {}, gap);
    if (direct.inside) return;
    close_residual(pair, direct);
    if (direct.residual <= pair.rounding || gap <= pair.rounding) break;
    gap = std::max(gap / 256, pair.rounding);
  }
  improve(pair, c, direct);
}

}  // namespace
}  // namespace convex

bool ConvexDistance::proved() const noexcept {
  const double rounding = 1024 * convex::epsilon * (norm(point_a) + norm(point_b) + core_overlap);
  return overlap_bound >= (1 - 2e-5) * core_overlap - rounding;
}

ConvexDistance convex_distance(const ConvexShape& a, const SE3<>& A, const ConvexShape& b, const SE3<>& B,
                               WarmStart& warm) noexcept {
  using namespace convex;
  const SO3<> to_a = transpose(A.R);
  const Vec3<> r = to_a * (B.r - A.r);
  const SO3<> R = to_a * B.R;
  CorePair pair{.a = a,
                .b = b,
                .R = R,
                .R_inverse = transpose(R),
                .r = r,
                .hint_a = start_vertex(a, warm.vertex_a),
                .hint_b = start_vertex(b, warm.vertex_b),
                .curved = is_curved(a) || is_curved(b),
                .rounding = 16 * epsilon * (norm(r) + a.extent + b.extent),
                .step = 0.005 * std::min(a.extent, b.extent)};
  constexpr int few_rounds = 2, some_rounds = 3, all_rounds = 64;
  Candidate c;
  if (dot(warm.normal, warm.normal) > 0)
    c.n = warm.normal;
  else
    c.n = dot(r, r) > 0 ? unit(r) : Vec3<>{0, 0, 1};
  c.s = dot(c.n, pair.support(c.n).w);
  if (c.s < 0) ascend(pair, c, few_rounds);
  if (c.residual > pair.rounding) {
    approach(pair, c);
    ascend(pair, c, c.s < -pair.rounding ? some_rounds : all_rounds);
  }
  double bound = 0;
  if (c.s < -pair.rounding) {
    Candidate other = c;
    bound = expand(pair, other);
    ascend(pair, other, all_rounds);
    improve(pair, c, other);
  }
  warm = {c.n, pair.hint_a, pair.hint_b};

  Vec3<> point_a = a.radius * c.n;
  for (int i = 0; i < c.simplex.count; ++i) point_a += c.simplex.weight[i] * c.simplex.vertex[i].a;
  const Vec3<> point_b = c.simplex.point(point_a - (a.radius + b.radius) * c.n);
  const double overlap = std::max(0.0, -c.s);
  return {.distance = c.s - a.radius - b.radius,
          .normal = A.R * c.n,
          .point_a = A * point_a,
          .point_b = A * point_b,
          .residual = c.residual,
          .core_overlap = overlap,
          .overlap_bound = std::min(bound, overlap)};
}

ConvexDistance convex_distance(const ConvexShape& a, const SE3<>& A, const ConvexShape& b,
                               const SE3<>& B) noexcept {
  WarmStart cold;
  return convex_distance(a, A, b, B, cold);
}

}  // namespace axode
