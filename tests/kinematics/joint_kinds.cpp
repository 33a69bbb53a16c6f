#include "tests/laws/law.hpp"
#include "tests/support/any_scalar.hpp"

/// Every kind of joint by itself: what its coordinates, velocities and accelerations mean.
namespace axode::test {
namespace {

using enum JointKind;
constexpr JointKind moving_kinds[] = {revolute,  prismatic, helical, cylindrical,
                                      universal, spherical, planar,  free};

/// Two joints of one kind in a row, in any place.
Model two_joints(JointKind kind, Random<double>& random) {
  ModelBuilder builder;
  for (const char* name : {"first", "second"}) {
    BodyDescription body{.name = name};
    if (std::string(name) == "second") body.predecessor = "first";
    body.joint = {.kind = kind,
                  .axis = random.vector(),
                  .second_axis = random.vector(),
                  .point = random.vector(),
                  .pitch = kind == helical ? 0.3 : 0};
    body.geometry = InBodyFrame{random.pose()};
    builder.add(body);
  }
  return builder.build();
}

template <class C> class JointKinds : public testing::Test {
 protected:
  using Real = typename C::T;
  /// law(trial, tree, q, v) for every kind of joint, with q and v as time series.
  template <class Law> void for_every_kind(const Law& law) {
    for (const JointKind kind : moving_kinds) {
      SCOPED_TRACE(std::string(to_string(kind)));
      Random<double> random(7);
      for (int k = 0; k < 20; ++k) {
        const Model model = two_joints(kind, random);
        Trial<Real> trial(model, random);
        const auto tree = cast<Taylor<Real, 3>>(model.template tree<Real>());
        law(trial, tree, moving(tree, trial.state.q, trial.state.v, trial.state.a),
            moving<3>(trial.state.v, trial.state.a));
      }
    }
  }
};
TYPED_TEST_SUITE(JointKinds, Cases, CaseNames);

TYPED_TEST(JointKinds, TwistsAreTheRatesOfPoses) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison rate("rate", agreement<T>);
  this->for_every_kind([&](Trial<T>& trial, const auto& tree, const auto& q, const auto&) {
    const std::vector<SE3<T>> C = trial.poses();
    const std::vector<Twist<Rep, T>> V = trial.template twists<Rep>();
    const auto C_t = frame_poses(tree, q);
    for (std::size_t f = 0; f < C.size(); ++f) {
      const Screw<T> V_s = screw(change<Spatial>(C[f], V[f]));
      const auto speed = [](const auto& a) { return Vec3<T>{a.x.c[1], a.y.c[1], a.z.c[1]}; };
      rate.expect_equal(cross(V_s.w, C[f].R.x), speed(C_t[f].R.x), 1);
      rate.expect_equal(cross(V_s.w, C[f].R.y), speed(C_t[f].R.y), 1);
      rate.expect_equal(V_s.v + cross(V_s.w, C[f].r), speed(C_t[f].r), 1);
    }
  });
}

TYPED_TEST(JointKinds, AccelerationsAreTheRatesOfTwists) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison rate("rate", agreement<T>);
  this->for_every_kind([&](Trial<T>& trial, const auto& tree, const auto& q, const auto& v) {
    const std::vector<TwistRate<Rep, T>> dV = trial.template accelerations<Rep>();
    const auto V_t = frame_twists<Rep>(tree, q, v);
    for (std::size_t f = 0; f < dV.size(); ++f) {
      const auto& [w, u] = V_t[f];
      rate.expect_equal(dV[f],
                        TwistRate<Rep, T>{{w.x.c[1], w.y.c[1], w.z.c[1]}, {u.x.c[1], u.y.c[1], u.z.c[1]}}, 1);
    }
  });
}

/// The one body of a mechanism with one joint; its frame is the joint frame.
Trial<double> one_joint(JointKind kind, std::vector<double> q, std::vector<double> v, double pitch = 0) {
  const Model model = ModelBuilder().add({.name = "body", .joint = {.kind = kind, .pitch = pitch}}).build();
  const std::vector<double> a(v.size());
  return {model, {std::move(q), std::move(v), a}};
}
constexpr double c = 0.8, s = 0.6;  // of the angle below
const double angle = std::atan2(s, c);

TEST(JointConventions, OneDegreeOfFreedom) {
  const auto turned = one_joint(revolute, {angle}, {2}).poses()[1];
  EXPECT_NEAR(turned.R.x.x, c, 1e-15);
  EXPECT_NEAR(turned.R.x.y, s, 1e-15);
  EXPECT_EQ(one_joint(prismatic, {0.4}, {2}).poses()[1].r.z, 0.4);
  EXPECT_EQ(one_joint(prismatic, {0.4}, {2}).twists<Hybrid>()[1].v.z, 2);
  auto nut = one_joint(helical, {angle}, {2}, 0.25);
  EXPECT_NEAR(nut.poses()[1].R.x.y, s, 1e-15);
  EXPECT_EQ(nut.poses()[1].r.z, 0.25 * angle);
  EXPECT_EQ(nut.twists<BodyFixed>()[1].v.z, 0.5);
}

TEST(JointConventions, SphericalIsAQuaternionAndAnAngularVelocityInTheChild) {
  auto ball = one_joint(spherical, {0, 0, s, c}, {1, 2, 3});
  const SO3<> R = ball.poses()[1].R;
  EXPECT_NEAR(R.x.x, c * c - s * s, 1e-15);
  EXPECT_NEAR(R.x.y, 2 * s * c, 1e-15);
  EXPECT_EQ(entries(ball.twists<BodyFixed>()[1]), (std::vector<double>{1, 2, 3, 0, 0, 0}));
}

TEST(JointConventions, PlanarIsAngleThenPositionWithVelocitiesInTheChild) {
  auto cart = one_joint(planar, {angle, 2, 3}, {0.5, 1, 0});
  const SE3<> C = cart.poses()[1];
  EXPECT_NEAR(C.R.x.y, s, 1e-15);
  EXPECT_EQ(entries(C.r), (std::vector<double>{2, 3, 0}));
  EXPECT_EQ(entries(cart.twists<BodyFixed>()[1]), (std::vector<double>{0, 0, 0.5, 1, 0, 0}));
  const Vec3<> forward = cart.twists<Hybrid>()[1].v;  // along the child's x-axis
  EXPECT_NEAR(forward.x, c, 1e-15);
  EXPECT_NEAR(forward.y, s, 1e-15);
}

TEST(JointConventions, FreeIsQuaternionThenPositionWithABodyFixedTwist) {
  auto drone = one_joint(free, {0, 0, s, c, 4, 5, 6}, {1, 2, 3, 7, 8, 9});
  EXPECT_EQ(entries(drone.poses()[1].r), (std::vector<double>{4, 5, 6}));
  EXPECT_NEAR(drone.poses()[1].R.x.y, 2 * s * c, 1e-15);
  EXPECT_EQ(entries(drone.twists<BodyFixed>()[1]), (std::vector<double>{1, 2, 3, 7, 8, 9}));
}

}  // namespace
}  // namespace axode::test
