#include "axode/contact/convex/hull.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "axode/contact/convex/support.hpp"
#include "axode/model/finite.hpp"

namespace axode {
namespace {

using Triangle = std::array<int, 3>;

/// Makes a Hull from vertices and triangles, see make_hull().
class HullBuilder {
 public:
  HullBuilder(std::vector<Vec3<>> vertices, std::span<const Triangle> triangles, double coplanar)
      : triangles_(triangles), coplanar_(coplanar) {
    hull_.vertices = std::move(vertices);
    if (hull_.vertices.size() < 4)
      fail("has " + std::to_string(hull_.vertices.size()) + " vertices, and it needs at least 4");
    if (!std::ranges::all_of(hull_.vertices, [](const Vec3<>& v) { return finite(v); }))
      fail("has a vertex that is not finite");
    for (const Triangle& t : triangles_)
      for (const int i : t)
        if (i < 0 || i >= std::ssize(hull_.vertices))
          fail("has a triangle with vertex " + std::to_string(i) + ", but its vertices are 0 to " +
               std::to_string(hull_.vertices.size() - 1));
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
      const Vec3<> a = vertex(t[1]) - vertex(t[0]), b = vertex(t[2]) - vertex(t[0]), n = cross(a, b);
      const double area = norm(n);
      areas_.push_back(area);
      longest_.push_back(std::max({norm(a), norm(b), norm(b - a)}));
      normals_.push_back((area > 0 ? 1 / area : 0) * n);
      if (!is_sliver(normals_.size() - 1) && !(dot(n, vertex(t[0])) > 0))
        fail("has a triangle that does not face outwards");
    }
  }
  /// Whether a triangle is nearly a segment, so that rounding decides its normal.
  bool is_sliver(std::size_t t) const { return !(areas_[t] > 1e-5 * longest_[t] * longest_[t]); }
  /// Finds, for every directed edge from one vertex to another, the triangle on its left. Throws
  /// std::invalid_argument if an edge occurs twice or has no triangle on the other side.
  void edges() {
    for (int t = 0; t < std::ssize(triangles_); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const Triangle& v = triangles_[t];
        const int a = v[k], b = v[(k + 1) % 3];
        if (!left_.emplace(std::pair(a, b), t).second)
          fail("has two triangles with the edge from vertex " + std::to_string(a) + " to " +
               std::to_string(b) + " in this direction");
      }
    for (const auto& [edge, t] : left_)
      if (!left_.contains({edge.second, edge.first})) fail("is not closed");
  }
  /// Joins neighbouring triangles of one plane to faces, beginning with the largest triangle.
  void faces() {
    std::vector<std::size_t> by_size(triangles_.size());
    std::iota(by_size.begin(), by_size.end(), 0);
    std::ranges::stable_sort(by_size, std::ranges::greater(), [&](std::size_t t) { return areas_[t]; });
    std::vector<char> taken(triangles_.size());
    for (const std::size_t first : by_size) {
      if (taken[first] != 0) continue;
      taken[first] = 1;
      std::vector<std::size_t> members{first};
      for (std::size_t m = 0; m < members.size(); ++m)
        for (std::size_t k = 0; k < 3; ++k) {
          const Triangle& v = triangles_[members[m]];
          const std::size_t other = left_.at({v[(k + 1) % 3], v[k]});
          if (taken[other] != 0 || !(norm(normals_[other] - normals_[first]) < coplanar_)) continue;
          taken[other] = 1;
          members.push_back(other);
        }
      if (is_sliver(first)) continue;
      hull_.normals.push_back(normals_[first]);
      hull_.first_corner.push_back(static_cast<int>(hull_.corners.size()));
      outline(members, normals_[first]);
    }
    hull_.first_corner.push_back(static_cast<int>(hull_.corners.size()));
  }
  /// Adds the face that a set of triangles in one plane forms, as a convex polygon: the corners of the convex
  /// hull of their vertices, projected along the normal n. The method is Andrew's monotone chain.
  void outline(const std::vector<std::size_t>& members, const Vec3<>& n) {
    struct Corner {
      double x, y;
      int vertex;
    };
    const Vec3<> u = convex::perpendicular(n), v = cross(n, u);
    std::set<int> vertices;
    for (const std::size_t m : members) vertices.insert(triangles_[m].begin(), triangles_[m].end());
    std::vector<Corner> all;
    for (const int i : vertices) all.push_back({dot(u, vertex(i)), dot(v, vertex(i)), i});
    std::ranges::sort(
        all, [](const Corner& a, const Corner& b) { return std::pair(a.x, a.y) < std::pair(b.x, b.y); });
    std::vector<Corner> chain;
    const auto extend = [&](const Corner& c, std::size_t start) {
      const auto turns_right = [&] {
        const Corner &a = chain[chain.size() - 2], &b = chain.back();
        return (b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x) <= 0;
      };
      while (chain.size() >= start + 2 && turns_right()) chain.pop_back();
      chain.push_back(c);
    };
    for (const Corner& c : all) extend(c, 0);
    const std::size_t lower = chain.size() - 1;
    for (auto c = all.rbegin() + 1; c != all.rend(); ++c) extend(*c, lower);
    chain.pop_back();
    for (const Corner& c : chain) hull_.corners.push_back(c.vertex);
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

  std::span<const Triangle> triangles_;
  double coplanar_;  ///< largest difference of unit normals of triangles in one face
  std::vector<Vec3<>> normals_;
  std::vector<double> areas_, longest_;  ///< twice the area and the longest edge of each triangle
  std::map<std::pair<int, int>, int> left_;
  Hull hull_;
};

}  // namespace

Hull make_hull(std::vector<Vec3<>> vertices, std::span<const Triangle> triangles, double coplanar) {
  return HullBuilder(std::move(vertices), triangles, coplanar).build();
}

}  // namespace axode
