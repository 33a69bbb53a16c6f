#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "axode/contact.hpp"
#include "axode/contact/convex/convex_distance.hpp"
#include "axode/contact/convex/support.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/view.hpp"
#include "tests/lie/random_quantities.hpp"
#include "tests/support/run_program.hpp"

/// Convex hulls of meshes for contacts.
namespace axode::test {
namespace {

using testing::HasSubstr;

/// An STL of triangles between points, three for each, as a text of single precision.
std::string stl_of(const std::vector<Vec3<>>& corners) {
  std::ostringstream text;
  text.precision(17);
  text << "solid s\n";
  for (const Vec3<>& p : corners)
    text << "vertex " << static_cast<float>(p.x) << ' ' << static_cast<float>(p.y) << ' '
         << static_cast<float>(p.z) << '\n';
  return text.str();
}

/// The corners of the triangles of a box with half edges h, whose faces are grids of 3 × 3 cells.
std::vector<Vec3<>> gridded_box(const Vec3<>& h, const SE3<>& pose) {
  std::vector<Vec3<>> out;
  constexpr int cells = 3;
  const auto at = [&](int k) { return 2.0 * k / cells - 1; };
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j)
          for (const auto& [k, l] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}) {
            const double u = at(i + k), v = at(j + l);
            const Vec3<> p = axis == 0   ? Vec3<>{side, u, v}
                             : axis == 1 ? Vec3<>{v, side, u}
                                         : Vec3<>{u, v, side};
            out.push_back(pose * Vec3<>{h.x * p.x, h.y * p.y, h.z * p.z});
          }
  return out;
}

ShapeDescription mesh_of(const std::string& file, const Vec3<>& scale = {1, 1, 1}) {
  return {.role = ShapeDescription::Role::collision, .kind = ShapeKind::mesh, .file = file, .scale = scale};
}

TEST(MeshHull, OfABoxInSinglePrecisionIsTheBox) {
  const TemporaryFolder folder;
  const Vec3<> h{0.2, 0.15, 0.1};
  Random<double> random(5);
  for (int k = 0; k < 20; ++k) {
    const SE3<> pose{k == 0 ? SO3<>{} : random.rotation(), random.vector()};
    const MeshHull found = hull_of_mesh(
        mesh_of(folder.write("box.stl", stl_of(gridded_box((1 / 0.001) * h, {pose.R, (1 / 0.001) * pose.r}))),
                {0.001, 0.001, 0.001}),
        {});
    EXPECT_EQ(found.hull.normals.size(), 6U);
    const ConvexShape hull = hull_shape(found.hull), box = box_shape(h);
    for (int i = 0; i < 50; ++i) {
      const SE3<> there{random.rotation(), pose.r + 0.3 * random.direction()};
      const ConvexDistance by_hull =
          convex_distance(hull, {{}, found.origin}, box_shape({0.1, 0.1, 0.1}), there);
      const ConvexDistance by_box = convex_distance(box, pose, box_shape({0.1, 0.1, 0.1}), there);
      EXPECT_NEAR(by_hull.distance, by_box.distance, 1e-6);
      EXPECT_LT(by_hull.residual, 1e-12);
    }
  }
}

TEST(MeshHull, HasTheSupportOfAllPoints) {
  const TemporaryFolder folder;
  Random<double> random(3);
  std::vector<Vec3<>> points;
  for (int k = 0; k < 3000; ++k) points.push_back(random.vector());
  const MeshHull found = hull_of_mesh(mesh_of(folder.write("cloud.stl", stl_of(points)), {1, 2, -0.5}), {});
  const ConvexShape hull = hull_shape(found.hull);
  for (int k = 0; k < 1000; ++k) {
    const Vec3<> n = random.direction();
    double farthest = -1e9;
    for (const Vec3<>& p : points)
      farthest = std::max(farthest, n.x * static_cast<float>(p.x) + 2 * n.y * static_cast<float>(p.y) -
                                        0.5 * n.z * static_cast<float>(p.z));
    EXPECT_NEAR(dot(n, found.origin + convex::support_point(hull, n)), farthest, 1e-12);
  }
}

TEST(MeshHull, MakesAMeshTouchAsABoxDoes) {
  const TemporaryFolder folder;
  const Vec3<> h{0.2, 0.15, 0.1};
  const SE3<> lying{exp_SO3(Vec3<>{0, 0, 0.4}), {0.1, 0.2, 0.1}};
  for (const ShapeKind below : {ShapeKind::plane, ShapeKind::box}) {
    Description d;
    d.bodies = {{.name = "part",
                 .joint = {.kind = JointKind::free},
                 .inertia = MassProperties{.mass = 1, .com = {}, .Theta = {1, 1, 1, 0, 0, 0}},
                 .shapes = {mesh_of(folder.write("part.stl", stl_of(gridded_box(h, {{}, {1, 2, 3}}))))}}};
    d.bodies[0].shapes[0].pose = {{}, {-1, -2, -3}};
    d.shapes = {{.role = ShapeDescription::Role::collision, .kind = below, .size = {4, 4, 1}}};
    if (below == ShapeKind::box) d.shapes[0].pose.r.z = -0.5;
    ContactFinder finder(ContactShapes(ModelBuilder(d).build(), hull_of_mesh));
    const std::array<SE3<>, 2> C{SE3<>{}, lying};
    ASSERT_TRUE(finder.find(C, 0.01));
    std::vector<Vec3<>> corners;
    for (const ContactPoint& p : finder.points()) {
      EXPECT_NEAR(p.gap, 0, 1e-6);
      EXPECT_NEAR(norm(p.normal - Vec3<>{0, 0, 1}), 0, 1e-5);
      corners.push_back(p.point);
    }
    for (const double x : {-h.x, h.x})
      for (const double y : {-h.y, h.y})
        EXPECT_TRUE(std::ranges::any_of(corners, [&](const Vec3<>& p) {
          return norm(p - lying * Vec3<>{x, y, -h.z}) < 1e-6;
        }));
  }
}

TEST(MeshHull, IsRefusedInOneSentence) {
  const TemporaryFolder folder;
  const auto refusal = [](const ShapeDescription& shape) -> std::string {
    try {
      hull_of_mesh(shape, {});
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  const std::vector<Vec3<>> flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  EXPECT_THAT(refusal(mesh_of(folder.file("none.stl"))), HasSubstr("there is no file"));
  EXPECT_THAT(refusal(mesh_of(folder.write("flat.stl", stl_of(flat)))), HasSubstr("lie in a plane"));
  EXPECT_THAT(refusal(mesh_of(folder.write("two.stl", stl_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})))),
              HasSubstr("two.stl\" lie in a plane, or are fewer than four"));
  const std::string scene =
      "<COLLADA><library_geometries><geometry id='g'><mesh><source id='s'><float_array id='f' "
      "count='3'>0 1 2</float_array></source></mesh></geometry></library_geometries></COLLADA>";
  EXPECT_THAT(refusal(mesh_of(folder.write("scene.dae", scene))),
              HasSubstr("meshes that touch are .stl or .obj"));
}

}  // namespace
}  // namespace axode::test
