#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "axode/kinematics.hpp"
#include "axode/model/configuration.hpp"
#include "tests/contact/two_shapes.hpp"
#include "tests/laws/law.hpp"
#include "tests/model/random_mechanism.hpp"

/// Distances between the shapes of a mechanism, and their Jacobian.
namespace axode::test {
namespace {

using ::testing::HasSubstr;

/// A random tree with a smooth shape on each body, some of them on fixed bodies, and a plane and a ball on
/// the ground.
Model random_shapes(std::uint64_t seed, int n) {
  Random<double> random(seed);
  Description d = random_tree(random, n, all_kinds);
  constexpr std::array smooth{ShapeKind::sphere, ShapeKind::ellipsoid, ShapeKind::capsule};
  for (std::size_t k = 0; k < d.bodies.size(); ++k) {
    d.bodies[k].shapes = {random_collision_shape(random, smooth[k % 3])};
    d.bodies[k].shapes[0].pose = random.pose();
  }
  d.shapes = {collision_shape(ShapeKind::plane, {}, 0, 0), random_collision_shape(random, ShapeKind::sphere)};
  d.shapes[0].pose = random.pose();
  return ModelBuilder(std::move(d)).build();
}

TEST(Distances, AreThoseOfTheShapesAtTheirFrames) {
  for_seeds(20, [](std::uint64_t seed) {
    const Model model = random_shapes(seed, 6);
    Distances distances(model);
    const ContactShapes& shapes = distances.shapes();
    const std::vector<double> q = random_configurations(model, seed, 1);
    Workspace<> workspace(model, cut_tree);
    std::vector<SE3<>> C(model.n_frames());
    poses<double>(model, workspace, q, C);
    const auto described = [&](int i) {
      const Description& d = model.description();
      return i < 2 ? d.shapes[i].pose : C[shapes[i].frame] * d.bodies[i - 2].shapes[0].pose;
    };
    const auto found = distances.evaluate(q);
    EXPECT_EQ(found.size(), shapes.pairs().size());
    for (const ShapeDistance& d : found) {
      EXPECT_NEAR(norm(d.point_b - d.point_a - d.distance * d.normal), 0, 1e-12);
      if (d.a == 0) {
        const SE3<> plane = described(0);
        EXPECT_NEAR(dot(plane.R.z, d.point_b - plane.r), d.distance, 1e-12);
        continue;
      }
      const ConvexDistance expected =
          convex_distance(shapes[d.a].convex, described(d.a), shapes[d.b].convex, described(d.b));
      EXPECT_NEAR(d.distance, expected.distance, 1e-11);
    }
    std::size_t near = 0;
    for (const ShapeDistance& d : found) near += d.distance < 1;
    EXPECT_EQ(distances.evaluate(q, 1).size(), near);
  });
}

TEST(Distances, HaveTheJacobianOfTheirDifferences) {
  std::size_t compared = 0;
  for_seeds(20, [&](std::uint64_t seed) {
    const Model model = random_shapes(seed, 6);
    Distances distances(model);
    const std::vector<double> q = random_configurations(model, seed, 1);
    const auto found = distances.evaluate(q);
    const std::vector<ShapeDistance> here(found.begin(), found.end());
    const std::size_t nv = model.nv();
    std::vector<double> J(nv * here.size());
    distances.jacobian(J);
    constexpr double h = 1e-5;
    for (std::size_t c = 0; c < nv; ++c) {
      std::vector<double> step(nv), back(nv);
      step[c] = h;
      back[c] = -h;
      const auto ahead = distances.evaluate(integrate(model, q, step));
      const std::vector<ShapeDistance> there(ahead.begin(), ahead.end());
      const auto behind = distances.evaluate(integrate(model, q, back));
      for (std::size_t k = 0; k < here.size(); ++k) {
        const bool smooth = norm(there[k].normal - behind[k].normal) < 1e-3 &&
                            norm(there[k].point_a - behind[k].point_a) < 1e-2;
        if (!smooth) continue;
        ++compared;
        EXPECT_NEAR(J[k * nv + c], (there[k].distance - behind[k].distance) / (2 * h), 1e-6)
            << "distance " << k << ", velocity " << c;
      }
    }
  });
  EXPECT_GT(compared, 3000U);
}

TEST(Distances, RefuseWrongPairsAndArguments) {
  const Model model = free_bodies(
      {collision_shape(ShapeKind::plane, {}, 0, 0), collision_shape(ShapeKind::sphere, {}, 1, 0)});
  const ContactShapes shapes(model);
  const auto refusal = [](const auto& f) -> std::string {
    try {
      f();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  using Pairs = std::vector<std::array<int, 2>>;
  EXPECT_THAT(refusal([&] { Distances(model, shapes, Pairs{{0, 2}}); }), HasSubstr("there is no shape 2"));
  EXPECT_THAT(refusal([&] { Distances(model, shapes, Pairs{{1, 1}}); }), HasSubstr("paired with itself"));
  Distances distances(model, shapes, {{1, 0}});
  std::vector<double> q = neutral(model), J(1);
  EXPECT_EQ(distances.evaluate(q)[0].distance, -1);
  EXPECT_EQ(distances.evaluate(q)[0].normal.z, -1);
  EXPECT_THAT(refusal([&] { distances.jacobian(J); }), HasSubstr("J"));
  EXPECT_THAT(refusal([&] { distances.evaluate(q, std::nan("")); }), HasSubstr("margin is not a number"));
  q[0] = std::nan("");
  EXPECT_NE(refusal([&] { distances.evaluate(q); }), "");
}

}  // namespace
}  // namespace axode::test
