#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "axode/contact/convex/convex_distance.hpp"
#include "tests/contact/contact_case.hpp"

/// Signed distances of convex pairs with reference values, from the folder `collision` of the vectors.
namespace axode::test {
namespace {

/// The shapes and pairs of one file.
struct ConvexPairs {
  std::vector<Hull> hulls;
  std::vector<ConvexShape> shapes;
  Json file;

  explicit ConvexPairs(const std::string& name)
      : file(read_json(vectors_folder() / "collision" / (name + ".json"))) {
    hulls.reserve(file.at("shapes").size());
    for (const Json& json : file.at("shapes")) shapes.push_back(shape(json));
  }

 private:
  ConvexShape shape(const Json& json) {
    const std::string kind = json.at("kind");
    const auto value = [&](const char* key) { return number(json.at(key)); };
    if (kind == "sphere") return sphere_shape(value("radius"));
    if (kind == "capsule") return capsule_shape(value("radius"), value("half_length"));
    if (kind == "cylinder") return cylinder_shape(value("radius"), value("half_length"));
    if (kind == "disc") return disc_shape(value("radius"));
    if (kind == "box") return box_shape(vec3(json.at("half")));
    if (kind == "ellipsoid") return ellipsoid_shape(vec3(json.at("semi_axes")));
    std::vector<Vec3<>> vertices;
    for (const Json& v : json.at("vertices")) vertices.push_back(vec3(v));
    std::vector<std::array<int, 3>> triangles;
    for (const Json& t : json.at("triangles")) triangles.push_back({t.at(0), t.at(1), t.at(2)});
    hulls.push_back(make_hull(std::move(vertices), triangles));
    return hull_shape(hulls.back());
  }
};

/// A pair of a file and its reference values.
struct ReferencePair {
  const ConvexShape &a, &b;
  SE3<> A, B;
  double distance, size;
  Vec3<> normal;

  ReferencePair(const ConvexPairs& from, const Json& pair)
      : a(from.shapes[static_cast<int>(pair.at("a"))]),
        b(from.shapes[static_cast<int>(pair.at("b"))]),
        A{so3(pair.at("R_a")), vec3(pair.at("r_a"))},
        B{so3(pair.at("R_b")), vec3(pair.at("r_b"))},
        distance(number(pair.at("distance"))),
        size(std::max({norm(A.r), norm(B.r), a.extent + b.extent})),
        normal(vec3(pair.at("normal"))) {}
};

class ConvexVectors : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == "none") GTEST_SKIP() << missing(vectors_folder() / "collision", "AXODE_VECTORS");
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, ConvexVectors, testing::ValuesIn(vector_files("collision")),
                         [](const auto& file) { return file.param; });

TEST_P(ConvexVectors, DistanceNormalAndWitnessPointsAreThoseOfTheFile) {
  const ConvexPairs pairs(GetParam());
  double worst_distance = 0, worst_normal = 0, worst_residual = 0, worst_point = 0;
  std::size_t index = 0;
  for (const Json& json : pairs.file.at("pairs")) {
    SCOPED_TRACE(json.at("family").text() + ", pair " + std::to_string(index++));
    const ReferencePair pair(pairs, json);
    const ConvexDistance d = convex_distance(pair.a, pair.A, pair.b, pair.B);
    const double error = std::abs(d.distance - pair.distance) / pair.size;
    worst_distance = std::max(worst_distance, error);
    worst_residual = std::max(worst_residual, d.residual / pair.size);
    EXPECT_LT(error, 1e-13);
    EXPECT_LT(error, d.residual / pair.size + 1e-14);
    EXPECT_LT(d.residual, 1e-12 * pair.size);
    EXPECT_TRUE(d.proved()) << d.core_overlap << " " << d.overlap_bound;
    EXPECT_NEAR(norm(d.normal), 1, 4e-15);
    EXPECT_LT(norm(d.point_b - d.point_a - d.distance * d.normal), d.residual + 1e-14 * pair.size);
    if (std::abs(pair.distance) > 1e-4 * pair.size) {
      worst_normal = std::max(worst_normal, norm(d.normal - pair.normal));
      EXPECT_LT(norm(d.normal - pair.normal), 1e-9);
    }
    if (!json.at("point_a").is_array() || std::abs(pair.distance) < 1e-9 * pair.size) continue;
    const Vec3<> off_a = d.point_a - vec3(json.at("point_a")), off_b = d.point_b - vec3(json.at("point_b"));
    const bool unique = json.at("points_unique").text() == "true";
    const double off = unique ? norm(off_a) + norm(off_b)
                              : std::abs(dot(off_a, pair.normal)) + std::abs(dot(off_b, pair.normal));
    worst_point = std::max(worst_point, off / pair.size);
    EXPECT_LT(off, 1e-7 * pair.size);
  }
  const auto record = [](const char* what, double x) {
    std::ostringstream text;
    text << x;
    RecordProperty(what, text.str());
  };
  record("worst_distance_by_size", worst_distance);
  record("worst_normal", worst_normal);
  record("worst_residual_by_size", worst_residual);
  record("worst_point_by_size", worst_point);
}

TEST_P(ConvexVectors, LawsHold) {
  const ConvexPairs pairs(GetParam());
  WarmStart other_contact;
  for (const Json& json : pairs.file.at("pairs")) {
    SCOPED_TRACE(json.at("family").text());
    const ReferencePair pair(pairs, json);
    const double tolerance = 1e-13 * pair.size;
    const ConvexDistance cold = convex_distance(pair.a, pair.A, pair.b, pair.B);
    const ConvexDistance exchanged = convex_distance(pair.b, pair.B, pair.a, pair.A);
    EXPECT_NEAR(exchanged.distance, cold.distance, tolerance);
    const ConvexDistance warm = convex_distance(pair.a, pair.A, pair.b, pair.B, other_contact);
    EXPECT_NEAR(warm.distance, cold.distance, tolerance);
    const SE3<> motion{exp_SO3(Vec3<>{0.3, -1.1, 0.7}), pair.size * Vec3<>{0.4, -0.2, 0.9}};
    const ConvexDistance moved = convex_distance(pair.a, motion * pair.A, pair.b, motion * pair.B);
    EXPECT_NEAR(moved.distance, cold.distance, 4 * tolerance);
    const bool clear = std::abs(pair.distance) > 1e-4 * pair.size;
    if (!clear) continue;
    EXPECT_LT(norm(exchanged.normal + cold.normal), 1e-9);
    EXPECT_LT(norm(warm.normal - cold.normal), 1e-9);
    EXPECT_LT(norm(moved.normal - motion.R * cold.normal), 1e-9);
  }
}

}  // namespace
}  // namespace axode::test
