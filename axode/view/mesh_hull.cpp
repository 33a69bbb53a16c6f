#include "axode/view/mesh_hull.hpp"

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include <array>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "axode/view/mesh_file.hpp"
#include "axode/view/mesh_formats.hpp"

namespace axode {
namespace {

std::vector<Vec3<>> vertices_of(const ShapeDescription& shape, const Source& referenced_from) {
  const FoundMesh found = find_mesh(shape.file, referenced_from);
  if (!found.error.empty()) throw std::invalid_argument(found.error);
  const MeshFile mesh = read_mesh(found.file);
  if (!mesh.error.empty()) throw std::invalid_argument(mesh.error);
  if (mesh.format != "stl" && mesh.format != "obj")
    throw std::invalid_argument("its format is " + mesh.format + "; meshes that touch are .stl or .obj");
  std::vector<Vec3<>> vertices =
      mesh.format == "stl" ? view::vertices_of_stl(mesh.bytes) : view::vertices_of_obj(mesh.bytes);
  for (Vec3<>& v : vertices) v = {shape.scale.x * v.x, shape.scale.y * v.y, shape.scale.z * v.z};
  return vertices;
}

/// One run of Qhull for a set of points. Its messages go to a temporary file that is deleted at the end.
class QhullRun {
 public:
  explicit QhullRun(const std::vector<Vec3<>>& points) : messages_(std::tmpfile(), &std::fclose) {
    if (messages_ == nullptr) throw std::runtime_error("hull_of_mesh: there is no temporary file for Qhull");
    for (const Vec3<>& p : points) coordinates_.insert(coordinates_.end(), {p.x, p.y, p.z});
    qh_zero(&qhull_, messages_.get());
    char options[] = "qhull Qt";  // facets are triangles
    failed_ = qh_new_qhull(&qhull_, 3, static_cast<int>(points.size()), coordinates_.data(), False, options,
                           nullptr, messages_.get()) != 0;
  }
  ~QhullRun() {
    qh_freeqhull(&qhull_, !qh_ALL);
    int bytes = 0, blocks = 0;
    qh_memfreeshort(&qhull_, &bytes, &blocks);
  }
  QhullRun(const QhullRun&) = delete;
  QhullRun& operator=(const QhullRun&) = delete;

  bool failed() const { return failed_; }

  /// The triangles of the hull as indices of points, counter-clockwise when seen from outside.
  std::vector<std::array<int, 3>> triangles(const std::vector<Vec3<>>& points) {
    std::vector<std::array<int, 3>> all;
    for (const facetT* facet = qhull_.facet_list; facet != nullptr && facet->next != nullptr;
         facet = facet->next) {
      std::array<int, 3> corners{};
      for (int k = 0; k < 3; ++k) {
        const auto* vertex = static_cast<const vertexT*>(facet->vertices->e[k].p);
        corners[k] = qh_pointid(&qhull_, vertex->point);
      }
      const Vec3<>&a = points[corners[0]], &b = points[corners[1]], &c = points[corners[2]];
      const Vec3<> out{facet->normal[0], facet->normal[1], facet->normal[2]};
      if (dot(cross(b - a, c - a), out) < 0) std::swap(corners[1], corners[2]);
      all.push_back(corners);
    }
    return all;
  }

 private:
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> messages_;
  std::vector<double> coordinates_;
  qhT qhull_{};
  bool failed_ = false;
};

}  // namespace

MeshHull hull_of_mesh(const ShapeDescription& shape, const Source& referenced_from) {
  const std::vector<Vec3<>> points = vertices_of(shape, referenced_from);
  QhullRun run(points);
  if (run.failed())
    throw std::invalid_argument("the vertices of \"" + shape.file +
                                "\" lie in a plane, or are fewer than four");
  std::vector<std::array<int, 3>> triangles = run.triangles(points);

  // The vertices of the hull get new numbers, because most points of a mesh are not on the hull.
  std::vector<int> number(points.size(), -1);
  MeshHull out{};
  std::vector<Vec3<>> vertices;
  for (std::array<int, 3>& triangle : triangles)
    for (int& corner : triangle) {
      int& known = number[corner];
      if (known < 0) {
        known = static_cast<int>(vertices.size());
        vertices.push_back(points[corner]);
        out.origin += points[corner];
      }
      corner = known;
    }
  out.origin = (1 / static_cast<double>(vertices.size())) * out.origin;
  for (Vec3<>& v : vertices) v -= out.origin;
  constexpr double coplanar = 1e-4;  // rad; coordinates in files have about seven digits
  out.hull = make_hull(std::move(vertices), triangles, coplanar);
  return out;
}

}  // namespace axode
