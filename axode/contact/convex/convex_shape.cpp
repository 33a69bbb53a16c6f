#include "axode/contact/convex/convex_shape.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

namespace axode {

ConvexShape sphere_shape(double radius) {
  return {.core = ConvexShape::Core::box, .radius = radius, .extent = radius};
}
ConvexShape capsule_shape(double radius, double half_length) {
  return {.core = ConvexShape::Core::box,
          .size = {0, 0, half_length},
          .radius = radius,
          .extent = half_length + radius};
}
ConvexShape cylinder_shape(double radius, double half_length) {
  return {.core = ConvexShape::Core::cylinder,
          .size = {radius, radius, half_length},
          .extent = std::hypot(radius, half_length)};
}
ConvexShape disc_shape(double radius) { return cylinder_shape(radius, 0); }
ConvexShape box_shape(const Vec3<>& half) {
  return {.core = ConvexShape::Core::box, .size = half, .extent = norm(half)};
}
ConvexShape ellipsoid_shape(const Vec3<>& semi_axes) {
  const auto [least, largest] = std::minmax({semi_axes.x, semi_axes.y, semi_axes.z});
  return {.core = ConvexShape::Core::ellipsoid,
          .size = semi_axes,
          .radius = least * least / largest,
          .extent = largest};
}
ConvexShape hull_shape(const Hull& hull) {
  double extent = 0;
  for (const Vec3<>& v : hull.vertices) extent = std::max(extent, norm(v));
  return {.core = ConvexShape::Core::hull, .extent = extent, .hull = &hull};
}

namespace {

using Triangle = std::array<int, 3>;

/// Makes a hull from its triangles.
class HullBuilder {
 public:
  HullBuilder(std::vector<Vec3<>> vertices, std::span<const Triangle> triangles) : triangles_(triangles) {
    hull_.vertices = std::move(vertices);
    if (hull_.vertices.size() < 4) fail("has " + std::to_string(hull_.vertices.size()) + " vertices, not 4");
    for (const Triangle& t : triangles_)
      for (const int i : t)
        if (i < 0 || i >= std::ssize(hull_.vertices))
          fail("has a triangle with vertex " + std::to_string(i) + ", which it does not have");
  }
  Hull build() {
    normals_of_triangles();
    edges();
    faces();
    neighbours();
    starts();
    return std::move(hull_);
  }

 private:
  [[noreturn]] static void fail(const std::string& what) {
    throw std::invalid_argument("a hull " + what +
                                "; its triangles must be a closed convex surface around "
                                "the origin of its frame, counter-clockwise seen from outside");
  }
  const Vec3<>& vertex(int i) const { return hull_.vertices[i]; }

  void normals_of_triangles() {
    for (const Triangle& t : triangles_) {
      const Vec3<> n = cross(vertex(t[1]) - vertex(t[0]), vertex(t[2]) - vertex(t[0]));
      const double area = norm(n);
      if (!(area > 0) || !(dot(n, vertex(t[0])) > 0)) fail("has a triangle that does not face outwards");
      normals_.push_back((1 / area) * n);
    }
  }
  /// The triangle on the left of every edge, from its first to its second vertex.
  void edges() {
    for (int t = 0; t < std::ssize(triangles_); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const Triangle& v = triangles_[t];
        if (!left_.emplace(std::pair(v[k], v[(k + 1) % 3]), t).second) fail("has an edge twice");
      }
    for (const auto& [edge, t] : left_)
      if (!left_.contains({edge.second, edge.first})) fail("is not closed");
  }
  /// Triangles of one plane that share edges become one face.
  void faces() {
    const std::size_t n = triangles_.size();
    std::vector<int> face(n, -1);
    for (std::size_t first = 0; first < n; ++first) {
      if (face[first] >= 0) continue;
      const int f = static_cast<int>(hull_.normals.size());
      hull_.normals.push_back(normals_[first]);
      face[first] = f;
      std::vector<std::size_t> members{first};
      for (std::size_t m = 0; m < members.size(); ++m)
        for (std::size_t k = 0; k < 3; ++k) {
          const Triangle& v = triangles_[members[m]];
          const std::size_t other = static_cast<std::size_t>(left_.at({v[(k + 1) % 3], v[k]}));
          if (face[other] >= 0 || !(norm(normals_[other] - normals_[first]) < coplanar)) continue;
          face[other] = f;
          members.push_back(other);
        }
      hull_.first_corner.push_back(static_cast<int>(hull_.corners.size()));
      outline(members, face, f);
    }
    hull_.first_corner.push_back(static_cast<int>(hull_.corners.size()));
  }
  /// The corners of a face, along the edges that its triangles do not share.
  void outline(const std::vector<std::size_t>& members, const std::vector<int>& face, int f) {
    std::map<int, int> next;
    for (const std::size_t m : members)
      for (std::size_t k = 0; k < 3; ++k) {
        const int from = triangles_[m][k], to = triangles_[m][(k + 1) % 3];
        if (face[static_cast<std::size_t>(left_.at({to, from}))] != f) next[from] = to;
      }
    const int start = next.begin()->first;
    int i = start;
    do {
      hull_.corners.push_back(i);
      i = next.at(i);
    } while (i != start);
  }
  void neighbours() {
    const std::size_t n = hull_.vertices.size();
    std::vector<std::vector<int>> near(n), around(n);
    for (const auto& [edge, t] : left_) near[static_cast<std::size_t>(edge.first)].push_back(edge.second);
    for (int f = 0; f < std::ssize(hull_.normals); ++f)
      for (int k = hull_.first_corner[f]; k < hull_.first_corner[f + 1]; ++k)
        around[static_cast<std::size_t>(hull_.corners[k])].push_back(f);
    for (std::size_t i = 0; i < n; ++i) {
      if (near[i].empty()) fail("has a vertex without a triangle");
      hull_.first_neighbour.push_back(static_cast<int>(hull_.neighbours.size()));
      hull_.neighbours.insert(hull_.neighbours.end(), near[i].begin(), near[i].end());
      hull_.first_face.push_back(static_cast<int>(hull_.faces.size()));
      hull_.faces.insert(hull_.faces.end(), around[i].begin(), around[i].end());
    }
    hull_.first_neighbour.push_back(static_cast<int>(hull_.neighbours.size()));
    hull_.first_face.push_back(static_cast<int>(hull_.faces.size()));
  }
  void starts() {
    for (int k = 0; k < 27; ++k) {
      const Vec3<> middle{double(k % 3 - 1), double(k / 3 % 3 - 1), double(k / 9 - 1)};
      const auto farthest =
          std::ranges::max_element(hull_.vertices, {}, [&](const Vec3<>& v) { return dot(middle, v); });
      hull_.start[k] = static_cast<int>(farthest - hull_.vertices.begin());
    }
  }

  static constexpr double coplanar = 1e-9;  // difference of unit normals of triangles in one face
  std::span<const Triangle> triangles_;
  std::vector<Vec3<>> normals_;
  std::map<std::pair<int, int>, int> left_;
  Hull hull_;
};

}  // namespace

Hull make_hull(std::vector<Vec3<>> vertices, std::span<const Triangle> triangles) {
  return HullBuilder(std::move(vertices), triangles).build();
}

}  // namespace axode
