#include "tests/laws/law.hpp"
#include "tests/support/kinds.hpp"
#include "tests/support/series.hpp"

/// Every kind of joint alone: the meaning of its coordinates, velocities and accelerations.
namespace axode::test {
namespace {

using enum JointKind;

/// Two joints of one kind in a row, at random places.
Model two_joints(JointKind kind, Random<double>& random) {
  ModelBuilder builder;
  for (const char* name : {"first", "second"}) {
    BodyDescription body{.name = name};
    if (std::string(name) == "second") body.predecessor = "first";
    body.joint = {.kind = kind,
                  .axis = random.vector(),
                  .second_axis = random.vector(),
                  .point = random.vector(),
                  .pitch = traits(kind).has("pitch") ? 0.3 : 0};
    body.geometry = InBodyFrame{random.pose()};
    builder.add(body);
  }
  return builder.build();
}

class JointKinds : public Law {
 protected:
  /// Calls law(trial) for every kind of joint.
  template <class F> static void for_every_kind(const F& law) {
    for (const JointKind kind : moving_kinds) {
      SCOPED_TRACE(std::string(to_string(kind)));
      Random<double> random(7);
      for (int k = 0; k < 20; ++k) {
        const Model model = two_joints(kind, random);
        Trial trial(GetParam(), model, random);
        law(trial);
      }
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Kinematics, JointKinds, testing::ValuesIn(cases()), name_of);

TEST_P(JointKinds, TwistsAreTheRatesOfPoses) {
  Comparison rate("rate", GetParam().agreement());
  for_every_kind([&](Trial& trial) {
    const std::vector<SE3<>> C = trial.poses();
    const std::vector<Six> V = trial.twists();
    const std::vector<Vec3<>> dC = rates_of_poses(trial.model, trial.state);  // four columns for each frame
    for (std::size_t f = 0; f < C.size(); ++f) {
      const auto [w, v] = changed_twist(Representation::spatial, GetParam().representation, C[f], V[f]);
      rate.expect_equal(cross(w, C[f].R.x), dC[4 * f], 1);
      rate.expect_equal(cross(w, C[f].R.y), dC[4 * f + 1], 1);
      rate.expect_equal(v + cross(w, C[f].r), dC[4 * f + 3], 1);
    }
  });
}

TEST_P(JointKinds, AccelerationsAreTheRatesOfTwists) {
  Comparison rate("rate", GetParam().agreement());
  for_every_kind([&](Trial& trial) {
    const std::vector<Six> dV = trial.accelerations(),
                           rates = rates_of_twists(GetParam().representation, trial.model, trial.state);
    for (std::size_t f = 0; f < dV.size(); ++f) rate.expect_equal(dV[f], rates[f], 1);
  });
}

/// A mechanism of one body with one joint, whose frame is the joint frame.
Trial one_joint(JointKind kind, std::vector<double> q, std::vector<double> v, double pitch = 0) {
  const Model model = ModelBuilder().add({.name = "body", .joint = {.kind = kind, .pitch = pitch}}).build();
  std::vector<double> a(v.size());
  return {scalars()[0], model, State<double>{std::move(q), std::move(v), std::move(a)}};
}
constexpr double c = 0.8, s = 0.6;  // of the angle below
const double angle = std::atan2(s, c);

TEST(JointConventions, OneDegreeOfFreedom) {
  const auto turned = one_joint(revolute, {angle}, {2}).poses()[1];
  EXPECT_NEAR(turned.R.x.x, c, 1e-15);
  EXPECT_NEAR(turned.R.x.y, s, 1e-15);
  EXPECT_EQ(one_joint(prismatic, {0.4}, {2}).poses()[1].r.z, 0.4);
  EXPECT_EQ(one_joint(prismatic, {0.4}, {2}).twists()[1].b.z, 2);
  auto nut = one_joint(helical, {angle}, {2}, 0.25);
  EXPECT_NEAR(nut.poses()[1].R.x.y, s, 1e-15);
  EXPECT_EQ(nut.poses()[1].r.z, 0.25 * angle);
  EXPECT_EQ(nut.by(Representation::body).twists()[1].b.z, 0.5);
}

TEST(JointConventions, SphericalIsAQuaternionAndAnAngularVelocityInTheChild) {
  auto ball = one_joint(spherical, {0, 0, s, c}, {1, 2, 3});
  const SO3<> R = ball.poses()[1].R;
  EXPECT_NEAR(R.x.x, c * c - s * s, 1e-15);
  EXPECT_NEAR(R.x.y, 2 * s * c, 1e-15);
  EXPECT_EQ(entries(ball.by(Representation::body).twists()[1]), (std::vector<double>{1, 2, 3, 0, 0, 0}));
}

TEST(JointConventions, PlanarIsAngleThenPositionWithVelocitiesInTheChild) {
  auto cart = one_joint(planar, {angle, 2, 3}, {0.5, 1, 0});
  const SE3<> C = cart.poses()[1];
  EXPECT_NEAR(C.R.x.y, s, 1e-15);
  EXPECT_EQ(entries(C.r), (std::vector<double>{2, 3, 0}));
  EXPECT_EQ(entries(cart.by(Representation::body).twists()[1]), (std::vector<double>{0, 0, 0.5, 1, 0, 0}));
  const Vec3<> forward = cart.twists()[1].b;  // along the child's x-axis
  EXPECT_NEAR(forward.x, c, 1e-15);
  EXPECT_NEAR(forward.y, s, 1e-15);
}

TEST(JointConventions, FreeIsQuaternionThenPositionWithABodyFixedTwist) {
  auto drone = one_joint(free, {0, 0, s, c, 4, 5, 6}, {1, 2, 3, 7, 8, 9});
  EXPECT_EQ(entries(drone.poses()[1].r), (std::vector<double>{4, 5, 6}));
  EXPECT_NEAR(drone.poses()[1].R.x.y, 2 * s * c, 1e-15);
  EXPECT_EQ(entries(drone.by(Representation::body).twists()[1]), (std::vector<double>{1, 2, 3, 7, 8, 9}));
}

}  // namespace
}  // namespace axode::test
