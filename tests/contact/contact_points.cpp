#include <gtest/gtest.h>

#include "axode/recursion/forward_kinematics.hpp"
#include "tests/contact/contact_case.hpp"

/// Contact points of mechanisms with reference values.
namespace axode::test {
namespace {

class ContactVectors : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == "none") GTEST_SKIP() << missing(vectors_folder() / "contact", "AXODE_VECTORS");
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, ContactVectors, testing::ValuesIn(vector_files("contact")),
                         [](const auto& file) { return file.param; });

/// Poses of the internal frames of all bodies.
std::vector<SE3<>> body_poses(const Model& model, const std::vector<double>& q) {
  WithScratch<double, BodyPoses<double>> poses(model.topology());
  poses->run(model.tree<double>(), q.data());
  std::vector<SE3<>> out;
  for (int i = 0; i <= model.n_bodies(); ++i) out.push_back((*poses)[i]);
  return out;
}

TEST_P(ContactVectors, PointsNormalsGapsAndFrictionAreThoseOfTheFile) {
  const ContactCase it(GetParam());
  const ContactShapes shapes(it.model);
  EXPECT_EQ(shapes.margin(), number(it.file.at("margin")));
  EXPECT_EQ(shapes.threshold(), number(it.file.at("threshold")));
  ContactFinder finder(shapes);
  constexpr double tolerance = 1e-13;
  for (const Json& state : it.file.at("states")) {
    SCOPED_TRACE(state.at("name").text());
    ASSERT_TRUE(finder.find(body_poses(it.model, numbers(state.at("q"))), shapes.margin()));
    const Json& expected = state.at("contacts");
    ASSERT_EQ(finder.points().size(), expected.size());
    std::vector<char> used(expected.size());
    for (const ContactPoint& found : finder.points()) {
      bool matched = false;
      for (std::size_t k = 0; k < expected.size() && !matched; ++k) {
        const Json& contact = expected.at(k);
        const int a = ContactCase::shape_index(shapes, contact.at("a")),
                  b = ContactCase::shape_index(shapes, contact.at("b"));
        const bool flipped = found.a == b && found.b == a;
        if (used[k] != 0 || (!flipped && (found.a != a || found.b != b))) continue;
        if (norm(found.point - vec3(contact.at("point"))) > tolerance) continue;
        matched = true;
        used[k] = 1;
        const Vec3<> n = flipped ? -found.normal : found.normal;
        EXPECT_LT(norm(n - vec3(contact.at("normal"))), tolerance);
        EXPECT_NEAR(found.gap, number(contact.at("gap")), tolerance);
        const SurfacePair surface = shapes.surface(found.a, found.b);
        const std::vector<double> friction = numbers(contact.at("friction"));
        EXPECT_DOUBLE_EQ(surface.friction, friction[0]);
        if (friction.size() > 2) {
          EXPECT_DOUBLE_EQ(surface.spin_friction, friction[2]);
          EXPECT_DOUBLE_EQ(surface.rolling_friction, friction[3]);
        }
      }
      EXPECT_TRUE(matched) << found.point.x << " " << found.point.y << " " << found.point.z;
    }
  }
}

}  // namespace
}  // namespace axode::test
