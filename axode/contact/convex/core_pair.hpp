#pragma once
#include <array>
#include <limits>

#include "axode/contact/convex/support.hpp"

/// The difference B - A of two convex sets A and B, which is the set of all b - a with points a of A and b of
/// B, and the state of the search for its point of least norm. A and B are the cores of convex bodies, which
/// are the bodies without the balls that round them.
namespace axode::convex {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// A point w = b - a with points a and b of two cores (convex bodies without the balls that round them).
/// CorePair::support(n) finds it for a unit vector n: a is the point of its core that is farthest along n,
/// and b is the point of the other core that is farthest along -n, so that n·w is least. branch_a and
/// branch_b are the numbers of the smooth parts of the cores' surfaces to which a and b belong, such as a
/// vertex of a box or a cap of a cylinder.
struct Vertex {
  Vec3<> w, a;
  int branch_a = 0, branch_b = 0;
};

/// At most four vertices with convex weights, which stand for one point of the difference B - A.
struct Simplex {
  int count = 0;
  std::array<Vertex, 4> vertex;
  std::array<double, 4> weight;

  void add(const Vertex& v, double w) noexcept {
    vertex[count] = v;
    weight[count++] = w;
  }
  void remove(int k) noexcept {
    for (--count; k < count; ++k) {
      vertex[k] = vertex[k + 1];
      weight[k] = weight[k + 1];
    }
  }
  /// The point for which the simplex stands, Σ weight w over its vertices, plus `shift`.
  Vec3<> point(const Vec3<>& shift = {}) const noexcept {
    Vec3<> x = shift;
    for (int i = 0; i < count; ++i) x += weight[i] * vertex[i].w;
    return x;
  }
};

/// A candidate for the least distance of two cores (convex bodies without the balls that round them): a unit
/// normal n, the width s of the gap between the cores along n, which is a lower bound of their distance, and
/// a simplex of points b - a, with points a and b of the two cores, which at the solution contains the point
/// s n (D10.3).
struct Candidate {
  Vec3<> n{};
  double s = -infinity;
  double residual = infinity;  ///< distance of the point of the simplex from s n, m
  Simplex simplex = {};
  bool inside = false;  ///< whether the simplex contains the origin, so that the cores overlap
};

/// Two cores, in the frame of A. In this frame B has the axes R and the origin r.
struct CorePair {
  const ConvexShape &a, &b;
  SO3<> R, R_inverse;
  Vec3<> r;
  int hint_a, hint_b;  ///< hull vertices at which the next search for a support branch starts
  bool curved;         ///< whether a core is a cylinder or an ellipsoid
  double rounding;     ///< rounding error of s(n), m
  double step;         ///< the least shift of a proximal step, m

  Vec3<> to_b(const Vec3<>& n) const noexcept { return R_inverse * n; }
  /// The vertex of B - A with the least n·w, so that s(n) = n·w (D10.1).
  Vertex support(const Vec3<>& n) noexcept {
    const Vec3<> m = to_b(-n);
    hint_a = support_branch(a, n, hint_a);
    hint_b = support_branch(b, m, hint_b);
    const Vec3<> point_a = branch_point(a, hint_a, n);
    return {r + R * branch_point(b, hint_b, m) - point_a, point_a, hint_a, hint_b};
  }
};

}  // namespace axode::convex
