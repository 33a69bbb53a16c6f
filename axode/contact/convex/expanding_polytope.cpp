#include "axode/contact/convex/expanding_polytope.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>

namespace axode::convex {
namespace {

constexpr int most_points = 96, most_faces = 192;

/// A polytope of triangles in fixed memory. A triangle without area has the normal NaN and is never expanded.
class Polytope {
 public:
  using Triple = std::array<std::uint8_t, 3>;
  struct Face {
    Vec3<> m;       ///< outward unit normal
    double offset;  ///< height of its plane over the origin, m
    Triple v;       ///< points, counter-clockwise seen from outside
  };

  explicit Polytope(double rounding) : rounding_(rounding) {}

  /// Makes the tetrahedron of four points. Point 3 is on the outer side of the triangle 0, j, k.
  void start(const std::array<Vec3<>, 4>& points, int j, int k) noexcept {
    std::ranges::copy(points, point_.begin());
    points_ = 4;
    add_face(0, j, k);
    add_face(0, k, 3);
    add_face(k, j, 3);
    add_face(j, 0, 3);
  }

  int faces() const noexcept { return faces_; }
  const Face& face(int f) const noexcept { return face_[f]; }

  /// Adds to the polytope a point that is above the plane of its face `start`. The connected faces around
  /// `start` whose planes are below the point are replaced by a cone from their rim to the point. Returns
  /// false if the memory is full.
  bool insert(const Vec3<>& w, int start) noexcept {
    std::array<int, most_faces> seen{start}, edge;  // faces; edges as from + 256 to
    int seeing = 1, connected = 1, edges = 0;
    for (int f = 0; f < faces_; ++f)
      if (f != start && !(dot(face_[f].m, w) <= face_[f].offset + rounding_)) seen[seeing++] = f;
    for (int i = 0; i < connected; ++i)
      for (int k = 0; k < 3; ++k) {
        const int from = face_[seen[i]].v[k], to = face_[seen[i]].v[(k + 1) % 3];
        const auto end = edge.begin() + edges;
        const auto twin = std::find(edge.begin(), end, to + 256 * from);
        if (twin != end)
          *twin = edge[--edges];
        else if (edges < most_faces)
          edge[edges++] = from + 256 * to;
        else
          return false;
        for (int j = connected; j < seeing; ++j)
          if (has_edge(face_[seen[j]].v, to, from)) std::swap(seen[connected++], seen[j]);
      }
    if (points_ == most_points || faces_ - connected + edges > most_faces) return false;
    std::sort(seen.begin(), seen.begin() + connected, std::greater<>());
    for (int i = 0; i < connected; ++i) face_[seen[i]] = face_[--faces_];
    point_[points_++] = w;
    for (int e = 0; e < edges; ++e) add_face(edge[e] % 256, edge[e] / 256, points_ - 1);
    return true;
  }

 private:
  static bool has_edge(const Triple& t, int from, int to) noexcept {
    return (t[0] == from && t[1] == to) || (t[1] == from && t[2] == to) || (t[2] == from && t[0] == to);
  }
  void add_face(int i, int j, int k) noexcept {
    const Vec3<> a = point_[j] - point_[i], b = point_[k] - point_[i], c = cross(a, b);
    const double area = norm(c);
    const bool flat = !(area > rounding_ * (norm(a) + norm(b)));
    const Vec3<> m = (flat ? std::numeric_limits<double>::quiet_NaN() : 1 / area) * c;
    face_[faces_++] = {m, dot(m, point_[i]), {std::uint8_t(i), std::uint8_t(j), std::uint8_t(k)}};
  }

  double rounding_;
  int points_ = 0, faces_ = 0;
  std::array<Vec3<>, most_points> point_;
  std::array<Face, most_faces> face_;
};

/// The search of expand() for a normal with less overlap.
class Expansion {
 public:
  Expansion(CorePair& pair, Candidate& c) : pair_(pair), c_(c), polytope_(pair.rounding) {}

  double run() noexcept {
    if (!start()) return 0;  // the difference is flat, and both of its normals were tried
    for (;;) {
      int nearest = -1;
      double least = infinity;
      for (int f = 0; f < polytope_.faces(); ++f) {
        const Polytope::Face& face = polytope_.face(f);
        const bool in_cap = pair_.curved && dot(face.m, c_.n) < cap_cosine;
        if (!(face.offset < least) || in_cap) continue;
        least = face.offset;
        nearest = f;
      }
      const double tolerance = pair_.curved ? -curved_precision * c_.s : 4 * pair_.rounding;
      if (nearest < 0 || least >= -c_.s - tolerance) return least;
      const Vec3<> out = polytope_.face(nearest).m, w = reach(out);
      if (dot(out, w) <= least + pair_.rounding || !polytope_.insert(w, nearest)) return least;
    }
  }

 private:
  static constexpr double cap_cosine = -0.99999, curved_precision = 1e-5;

  /// Returns the point farthest in the direction `out` among all b - a with points a and b of two cores
  /// (convex bodies without the balls that round them). Its coordinate along `out` is the overlap of the
  /// cores for the normal -out. If this overlap is the least so far, -out becomes the best normal.
  Vec3<> reach(const Vec3<>& out) noexcept {
    const Vec3<> w = pair_.support(-out).w;
    const double overlap = dot(out, w);
    if (overlap < -c_.s - 4 * pair_.rounding) {
      c_ = {};
      c_.n = -out;
      c_.s = -overlap;
    }
    return w;
  }
  /// Finds the points that are farthest in the directions `out` and -out in the difference of two cores
  /// (convex bodies without the balls that round them), and returns the one that is farther from the plane
  /// through p with the normal `out`.
  Vec3<> reach_either(const Vec3<>& out, const Vec3<>& p) noexcept {
    const Vec3<> one = reach(out), other = reach(-out);
    return std::abs(dot(out, one - p)) < std::abs(dot(out, other - p)) ? other : one;
  }
  /// Makes the first tetrahedron, whose vertices are points b - a with points a and b of two cores (convex
  /// bodies without the balls that round them). The first vertex is the farthest point in the direction -n,
  /// where n is the unit normal with the least overlap of the cores that was known before the search. Returns
  /// false if the tetrahedron is flat.
  bool start() noexcept {
    const double flat = 64 * pair_.rounding;
    const Vec3<> n = c_.n;
    std::array<Vec3<>, 4> p;
    const auto height = [&](const Vec3<>& out, int k) { return std::abs(dot(out, p[k] - p[0])); };
    p[0] = reach(-n);
    p[1] = reach_either(n, p[0]);
    const Vec3<> axis = height(n, 1) > flat ? unit(p[1] - p[0]) : n;
    Vec3<> u = perpendicular(axis);
    p[2] = reach_either(u, p[0]);
    if (height(u, 2) < flat) {
      u = cross(axis, u);
      p[2] = reach_either(u, p[0]);
    }
    const Vec3<> across = p[2] - p[0] - dot(axis, p[2] - p[0]) * axis;
    const Vec3<> m = cross(axis, unit(across));
    p[3] = reach_either(m, p[0]);
    if (!(height(u, 2) > flat && height(m, 3) > flat)) return false;
    const int j = dot(m, p[3] - p[0]) > 0 ? 2 : 1;
    polytope_.start(p, j, 3 - j);
    return true;
  }

  CorePair& pair_;
  Candidate& c_;
  Polytope polytope_;
};

}  // namespace

double expand(CorePair& pair, Candidate& c) noexcept { return Expansion(pair, c).run(); }

}  // namespace axode::convex
