#include "axode/contact/convex/stationary_normal.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace axode::convex {
namespace {

/// The matrix and the right side of the equations of a Newton step (D10.9). The step searches the unit normal
/// n for which the gap between two convex bodies has a stationary width s. Its unknowns are two tangential
/// components of the change of n, s, and the weights, with the sum 1, of up to three points b - a, where a
/// and b are points of the two bodies. The weighted mean of these points is s n at the solution.
using Equations = std::array<std::array<double, 7>, 6>;

/// Solves linear equations [matrix | right side] by Gauss-Jordan elimination with pivots. The solution
/// replaces the right side, which is column `size`. Returns false if the matrix is singular.
bool solve(Equations& m, int size) noexcept {
  for (int c = 0; c < size; ++c) {
    int pivot = c;
    for (int i = c + 1; i < size; ++i)
      if (std::abs(m[i][c]) > std::abs(m[pivot][c])) pivot = i;
    if (!(std::abs(m[pivot][c]) > 16 * epsilon)) return false;
    if (pivot != c) std::swap(m[pivot], m[c]);
    for (int i = 0; i < size; ++i) {
      if (i == c || m[i][c] == 0) continue;
      const double factor = m[i][c] / m[c][c];
      for (int j = c; j <= size; ++j) m[i][j] -= factor * m[c][j];
    }
  }
  for (int i = 0; i < size; ++i) m[i][size] /= m[i][i];
  return true;
}

/// Newton's method for the normal n along which the gap between two convex bodies has a stationary width s.
/// It starts from a candidate: a normal, and a simplex of up to four weighted points b - a, with points a and
/// b of the two bodies, whose weighted mean is s n at the solution. A body can be `frozen`: it is replaced by
/// the polytope of its points in the simplex, which do not change with the normal.
class Newton {
 public:
  Newton(CorePair& pair, const Candidate& start, bool freeze_a, bool freeze_b)
      : pair_(pair),
        start_(start),
        freeze_a_(freeze_a),
        freeze_b_(freeze_b),
        per_length_(1 / (pair.a.extent + pair.b.extent)) {
    now_.n = start.n;
    for (int i = 0; i < start.simplex.count; ++i) merge(start.simplex.vertex[i], start.simplex.weight[i]);
  }

  /// Returns the best candidate: the start, unless an iterate has a lower residual and no lower bound s.
  Candidate run() noexcept {
    constexpr int most_steps = 8;
    Candidate best = start_;
    if (pair_.curved) best.residual = infinity;
    for (int step = 0;; ++step) {
      const double level = move_vertices();
      const Vertex support = pair_.support(now_.n);
      now_.s = dot(now_.n, support.w);
      now_.residual = norm(now_.simplex.point() - now_.s * now_.n);
      if (now_.residual < best.residual && now_.s >= start_.s - pair_.rounding) best = now_;
      const bool diverges = !(now_.residual < 16 * best.residual);
      if (now_.residual <= pair_.rounding || step == most_steps || diverges) break;
      const bool inactive = step > 0 && now_.s < level - pair_.rounding;
      if (inactive && now_.simplex.count < 3) merge(support, 0);
      if (now_.simplex.count > 3 || !update()) break;
    }
    return best.residual < std::max(start_.residual, 2 * pair_.rounding) ? best : start_;
  }

 private:
  /// Adds a vertex with a weight to the simplex. If neither body is frozen (replaced by the polytope of
  /// its known points), a vertex on the same branches (smooth parts) of the support functions of both
  /// bodies as an older vertex is not added; its weight is added to that of the older vertex.
  void merge(const Vertex& v, double weight) noexcept {
    Simplex& x = now_.simplex;
    if (!freeze_a_ && !freeze_b_)
      for (int i = 0; i < x.count; ++i)
        if (x.vertex[i].branch_a == v.branch_a && x.vertex[i].branch_b == v.branch_b) {
          x.weight[i] += weight;
          return;
        }
    x.add(v, weight);
  }

  /// Moves each vertex w = b - a of the simplex to the present normal n: on the branches (smooth parts) of
  /// the bodies' support functions to which the vertex belongs, a becomes the support point for n, and b
  /// that for -n. Points of a frozen body (replaced by the polytope of its known points) do not move.
  /// Returns the least height n·w of a vertex.
  double move_vertices() noexcept {
    double level = infinity;
    const Vec3<> m = pair_.to_b(-now_.n);
    for (int i = 0; i < now_.simplex.count; ++i) {
      Vertex& v = now_.simplex.vertex[i];
      const Vec3<> b = freeze_b_ ? v.w + v.a : pair_.r + pair_.R * branch_point(pair_.b, v.branch_b, m);
      if (!freeze_a_) v.a = branch_point(pair_.a, v.branch_a, now_.n);
      v.w = b - v.a;
      level = std::min(level, dot(now_.n, v.w));
    }
    return level;
  }

  /// Makes one Newton step (D10.9) for the equations Σ λ_i w_i = s n, n·w_i = s and Σ λ_i = 1 (D10.8). The
  /// unknowns are the unit normal n, the width s of the gap along n, and the weights λ_i of the vertices w_i
  /// of the simplex. The vertices are points b - a, with points a and b of two convex bodies, and the step
  /// takes into account that they move with n. Removes vertices whose new weight is not positive. Returns
  /// false if the matrix is singular.
  bool update() noexcept {
    const Simplex& x = now_.simplex;
    const int count = x.count, size = count + 3, s = size - 1;
    const Vec3<> u = perpendicular(now_.n), v = cross(now_.n, u);
    std::array<double, 3> Q_a{}, Q_b{};
    if (!freeze_a_) Q_a = support_hessian(pair_.a, now_.n, u, v);
    if (!freeze_b_) Q_b = support_hessian(pair_.b, pair_.to_b(-now_.n), pair_.to_b(u), pair_.to_b(v));
    Equations m{};
    m[0][0] = per_length_ * (Q_a[0] + Q_b[0] + now_.s);
    m[1][1] = per_length_ * (Q_a[2] + Q_b[2] + now_.s);
    m[0][1] = m[1][0] = per_length_ * (Q_a[1] + Q_b[1]);
    m[s][size] = 1;
    for (int i = 0; i < count; ++i) {
      const Vec3<> w = per_length_ * x.vertex[i].w;
      const int row = 2 + i;
      m[row][0] = dot(u, w);
      m[row][1] = dot(v, w);
      m[0][row] = -m[row][0];
      m[1][row] = -m[row][1];
      m[row][s] = -1;
      m[row][size] = -dot(now_.n, w);
      m[s][row] = 1;
    }
    if (!solve(m, size)) return false;
    Simplex kept;
    for (int i = 0; i < count; ++i)
      if (m[2 + i][size] > 0) kept.add(x.vertex[i], m[2 + i][size]);
    now_.n = unit(now_.n + m[0][size] * u + m[1][size] * v);
    now_.simplex = kept;
    return true;
  }

  CorePair& pair_;
  const Candidate& start_;
  const bool freeze_a_, freeze_b_;
  const double per_length_;
  Candidate now_;
};

bool cap_faces(const ConvexShape& shape, const Vec3<>& n) noexcept {
  return shape.core == ConvexShape::Core::cylinder && std::abs(n.z) > 0.995;
}

}  // namespace

void close_residual(CorePair& pair, Candidate& c) noexcept {
  c.residual = norm(c.simplex.point() - c.s * c.n);
  const auto improve = [&](bool freeze_a, bool freeze_b) {
    if (c.residual > pair.rounding) c = Newton(pair, c, freeze_a, freeze_b).run();
  };
  if (pair.curved || c.residual > pair.rounding) c = Newton(pair, c, false, false).run();
  constexpr int most_rounds = 4;
  for (int round = 0; round < most_rounds && c.residual > pair.rounding; ++round) {
    const bool a = cap_faces(pair.a, c.n), b = cap_faces(pair.b, pair.to_b(c.n));
    if (!a && !b) return;
    const double before = c.residual;
    improve(a, b);
    improve(false, false);
    if (a && b) {  // the point of one cap may lie on the rim of the other
      improve(true, false);
      improve(false, true);
    }
    if (!(c.residual < before / 2)) return;
  }
}

}  // namespace axode::convex
