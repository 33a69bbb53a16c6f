#include <gtest/gtest.h>

#include "axode/contact/convex/support.hpp"
#include "tests/contact/two_shapes.hpp"
#include "tests/laws/law.hpp"

/// Laws of signed distances that need no reference values, for bodies whose sizes differ by up to 1000.
namespace axode::test {
namespace {

/// A cube, a tetrahedron or an octahedron that is stretched along the axes.
Hull random_hull(Random<double>& random, const Vec3<>& stretch) {
  std::vector<Vec3<>> vertices;
  std::vector<std::array<int, 3>> triangles;
  if (random.number(0, 1) < 0.5) {
    vertices = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
    triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  } else {
    vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  }
  for (Vec3<>& v : vertices) v = {v.x * stretch.x, v.y * stretch.y, v.z * stretch.z};
  return make_hull(std::move(vertices), triangles);
}

/// Two random bodies, whose lengths have ratios of up to `ratio`, at random poses near each other.
struct RandomPair {
  Hull hull_a, hull_b;
  ConvexShape a, b;
  SE3<> A, B;

  RandomPair(std::uint64_t seed, double ratio) {
    Random<double> random(seed);
    const auto length = [&] { return std::pow(ratio, random.number(-1, 0)); };
    const auto shape = [&](Hull& hull) {
      const Vec3<> sizes{length(), length(), length()};
      hull = random_hull(random, sizes);
      switch (static_cast<int>(random.number(0, 7))) {
        case 0: return sphere_shape(sizes.x);
        case 1: return capsule_shape(sizes.x, sizes.y);
        case 2: return cylinder_shape(sizes.x, sizes.y);
        case 3: return disc_shape(sizes.x);
        case 4: return box_shape(sizes);
        case 5: return ellipsoid_shape(sizes);
        default: return hull_shape(hull);
      }
    };
    a = shape(hull_a);
    b = shape(hull_b);
    A = random.pose();
    B = {random.rotation(), A.r + random.number(0, 1) * (a.extent + b.extent) * random.direction()};
  }
  double size() const { return norm(A.r) + norm(B.r) + a.extent + b.extent; }
  /// s(n) by the definition (D10.1).
  double bound(const Vec3<>& n) const {
    const auto farthest = [](const ConvexShape& shape, const SE3<>& pose, const Vec3<>& m) {
      return dot(m, pose * convex::support_point(shape, transpose(pose.R) * m));
    };
    return -farthest(b, B, -n) - farthest(a, A, n);
  }
};

class Ratios : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Convex, Ratios, testing::Values(3, 30, 1000), [](const auto& ratio) {
  return "to_" + std::to_string(static_cast<int>(ratio.param));
});

TEST_P(Ratios, TheDistanceIsTheGreatestBoundAndTheCertificateHolds) {
  for_seeds(2000, [&](std::uint64_t seed) {
    const RandomPair pair(seed, GetParam());
    const double rounding = 1e-14 * pair.size();
    const ConvexDistance d = convex_distance(pair.a, pair.A, pair.b, pair.B);
    EXPECT_NEAR(pair.bound(d.normal), d.distance, rounding);
    EXPECT_LT(d.residual, 1e-12 * pair.size());
    Random<double> random(seed);
    const bool settled = d.distance > 0 || d.proved();
    for (int k = 0; k < 100; ++k) {
      const Vec3<> direction = random.direction();
      const Vec3<> n = k % 2 == 0 ? direction : convex::unit(d.normal + 0.1 * direction);
      const double most = d.distance + d.residual + rounding + 2e-5 * d.core_overlap;
      EXPECT_TRUE(!settled || pair.bound(n) < most) << pair.bound(n) << " " << most;
    }
  });
}

TEST_P(Ratios, SizesInOtherUnitsGiveTheSameBits) {
  for_seeds(500, [&](std::uint64_t seed) {
    RandomPair pair(seed, GetParam());
    const ConvexDistance d = convex_distance(pair.a, pair.A, pair.b, pair.B);
    constexpr double unit = 1.0 / 1024;
    const auto scale = [&](ConvexShape& shape, Hull& hull, SE3<>& pose) {
      shape.size = unit * shape.size;
      shape.radius *= unit;
      shape.extent *= unit;
      for (Vec3<>& v : hull.vertices) v = unit * v;
      pose.r = unit * pose.r;
    };
    scale(pair.a, pair.hull_a, pair.A);
    scale(pair.b, pair.hull_b, pair.B);
    if (pair.a.hull != nullptr) pair.a.hull = &pair.hull_a;
    if (pair.b.hull != nullptr) pair.b.hull = &pair.hull_b;
    const ConvexDistance small = convex_distance(pair.a, pair.A, pair.b, pair.B);
    EXPECT_EQ(small.distance, unit * d.distance);
    EXPECT_EQ(small.residual, unit * d.residual);
    EXPECT_EQ(norm(small.normal - d.normal), 0);
  });
}

TEST(Convex, APoseThatIsNoNumberEnds) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const ConvexShape& shape :
       {sphere_shape(1), box_shape({1, 2, 3}), cylinder_shape(1, 2), ellipsoid_shape({1, 2, 3})}) {
    const ConvexDistance d = convex_distance(shape, {}, shape, {{}, {nan, 0, 0}});
    EXPECT_FALSE(d.distance >= 0 || d.distance < 0);
  }
}

TEST(Convex, TouchingAndConcentricBodiesHaveAnswers) {
  const ConvexShape box = box_shape({1, 1, 1}), ball = sphere_shape(1);
  EXPECT_EQ(convex_distance(box, {}, box, {{}, {2, 0, 0}}).distance, 0);
  EXPECT_NEAR(convex_distance(box, {}, box, {}).distance, -2, 1e-14);
  EXPECT_EQ(convex_distance(ball, {}, ball, {}).distance, -2);
  EXPECT_NEAR(convex_distance(ball, {}, box, {}).distance, -2, 1e-14);
  const ConvexDistance flat = convex_distance(disc_shape(1), {}, disc_shape(1), {{}, {0.3, 0, 0}});
  EXPECT_NEAR(flat.distance, 0, 1e-15);
  EXPECT_NEAR(std::abs(flat.normal.z), 1, 1e-9);
}

TEST(Hull, IsRefusedUnlessItIsAClosedSurfaceAroundTheOrigin) {
  const std::vector<Vec3<>> vertices{{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
  using Triangles = std::vector<std::array<int, 3>>;
  EXPECT_EQ(make_hull(vertices, Triangles{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}).normals.size(), 4U);
  for (const Triangles& wrong :
       {Triangles{{0, 1, 2}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}, Triangles{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}},
        Triangles{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 4}}, Triangles{}})
    EXPECT_THROW(static_cast<void>(make_hull(vertices, wrong)), std::invalid_argument);
}

}  // namespace
}  // namespace axode::test
