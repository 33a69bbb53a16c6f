#include "axode/lie/solids.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "tests/lie/random_quantities.hpp"

/// The inertias of solids equal the integrals over their volume.
namespace axode::test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

void expect_equal(const Inertia<>& M, const Inertia<>& expected, double tolerance) {
  EXPECT_NEAR(M.m, expected.m, tolerance);
  for (const auto& [x, y] :
       {std::pair(M.h.x, expected.h.x), std::pair(M.h.y, expected.h.y), std::pair(M.h.z, expected.h.z),
        std::pair(M.Theta.xx, expected.Theta.xx), std::pair(M.Theta.yy, expected.Theta.yy),
        std::pair(M.Theta.zz, expected.Theta.zz), std::pair(M.Theta.xy, expected.Theta.xy),
        std::pair(M.Theta.xz, expected.Theta.xz), std::pair(M.Theta.yz, expected.Theta.yz)})
    EXPECT_NEAR(x, y, tolerance);
}

/// The inertia of a solid of revolution about z that has this mass, from its squared radius as a function of
/// the height: Simpson's rule over discs.
template <class SquaredRadius>
Inertia<> of_discs(double mass, double top, const std::vector<double>& breaks, SquaredRadius&& squared) {
  double volume = 0, across = 0, along = 0;
  const auto add = [&](double z, double weight) {
    const double R2 = squared(z), area = std::numbers::pi * R2 * weight;
    volume += area, across += area * (R2 / 4 + z * z), along += area * R2 / 2;
  };
  double from = -top;
  for (const double to : breaks) {
    constexpr int n = 2000;
    const double h = (to - from) / n;
    for (int k = 0; k < n; ++k) {
      const double z = from + k * h;
      add(z, h / 6), add(z + h / 2, 4 * h / 6), add(z + h, h / 6);
    }
    from = to;
  }
  const double density = mass / volume;
  return {mass, {}, {density * across, density * across, density * along, 0, 0, 0}};
}

TEST(Solids, OfRevolutionAreStacksOfDiscs) {
  const double m = 3, r = 0.2, l = 0.7;
  expect_equal(sphere_inertia(m, r), of_discs(m, r, {r}, [&](double z) { return r * r - z * z; }), 1e-12);
  expect_equal(cylinder_inertia(m, r, l), of_discs(m, l / 2, {l / 2}, [&](double) { return r * r; }), 1e-12);
  expect_equal(capsule_inertia(m, r, l),
               of_discs(m, l / 2 + r, {-l / 2, l / 2, l / 2 + r},
                        [&](double z) {
                          const double d = std::max(0.0, std::abs(z) - l / 2);
                          return r * r - d * d;
                        }),
               1e-12);
}

struct Mesh {
  std::vector<Vec3<>> vertices;
  std::vector<std::array<int, 3>> faces;
};
/// The mesh of a box around the origin.
Mesh box(const Vec3<>& size) {
  Mesh mesh;
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5})
      for (const double z : {-0.5, 0.5}) mesh.vertices.push_back({x * size.x, y * size.y, z * size.z});
  mesh.faces = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  return mesh;
}

TEST(Solids, AMeshOfABoxIsTheBoxWhereverItIs) {
  Random<double> random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3<> size{random.number(0.1, 2), random.number(0.1, 2), random.number(0.1, 2)};
    Mesh mesh = box(size);
    const SE3<> C = random.pose();
    for (Vec3<>& x : mesh.vertices) x = C * x;
    EXPECT_NEAR(mesh_volume(mesh.vertices, mesh.faces), size.x * size.y * size.z, 1e-12);
    expect_equal(mesh_inertia(2, mesh.vertices, mesh.faces), transform(C, box_inertia(2, size)), 1e-11);
  }
}

TEST(Solids, RefuseWhatEnclosesNothing) {
  const auto refuses = [](const std::string& part) {
    return ThrowsMessage<std::invalid_argument>(HasSubstr(part));
  };
  Mesh open = box({1, 1, 1});
  open.faces.pop_back();
  EXPECT_THAT([&] { mesh_volume(open.vertices, open.faces); }, refuses("a mesh must be closed"));
  Mesh inwards = box({1, 1, 1});
  for (auto& face : inwards.faces) std::swap(face[0], face[1]);
  EXPECT_THAT([&] { mesh_inertia(1, inwards.vertices, inwards.faces); },
              refuses("counterclockwise as seen from outside"));
  Mesh wrong = box({1, 1, 1});
  wrong.faces[2][1] = 8;
  EXPECT_THAT([&] { mesh_volume(wrong.vertices, wrong.faces); },
              refuses("faces: number 2 has vertex 8 of 8"));
  Mesh lost = box({1, 1, 1});
  lost.vertices[3].y = NAN;
  EXPECT_THAT([&] { mesh_volume(lost.vertices, lost.faces); }, refuses("vertices: number 3 is not finite"));
  EXPECT_THAT([&] { mesh_volume({}, {}); }, refuses("encloses 0 m³"));
  EXPECT_THAT([&] { box_inertia(1, {1, 0, 1}); }, refuses("size is 0;"));
  EXPECT_THAT([&] { box_inertia(1, {1, -1e-7, 1}); }, refuses("size is -1e-07;"));
  EXPECT_THAT([&] { sphere_inertia(-1, 1); }, refuses("mass is -1"));
  EXPECT_THAT([&] { capsule_inertia(1, 1, INFINITY); }, refuses("length is inf"));
}

}  // namespace
}  // namespace axode::test
