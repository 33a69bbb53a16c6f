#include <gtest/gtest.h>

#include <cmath>

#include "tests/lie/random_quantities.hpp"
#include "tests/lie/relative_error.hpp"

/// Axes, pitches and magnitudes of screws, twists and wrenches, and the reciprocal product.
namespace axode::test {
namespace {

template <class T> class ScrewGeometry : public testing::Test {
 protected:
  static constexpr int samples = 300;
  static constexpr T tolerance = test::tolerance<T>;
  static constexpr T infinity = std::numeric_limits<T>::infinity();
  Random<T> random;
  ScrewAxis<T> axis() {
    return {random.direction(), random.vector(T(2)), random.number(T(-1), T(1)), random.number(T(0.1), T(3))};
  }
};
TYPED_TEST_SUITE(ScrewGeometry, Scalars, ScalarNames);

TYPED_TEST(ScrewGeometry, AxisPointPitchAndMagnitudeComeBack) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const ScrewAxis<T> given = this->axis(), found = screw_axis(screw(given));
    EXPECT_LE(distance(found.e, given.e), this->tolerance);
    EXPECT_NEAR(found.h, given.h, this->tolerance);
    EXPECT_NEAR(found.magnitude, given.magnitude, this->tolerance);
    EXPECT_NEAR(dot(found.p, given.e), T(0), this->tolerance);  // the point nearest to the origin ...
    EXPECT_LE(norm(cross(found.p - given.p, given.e)), this->tolerance);  // ... on the same line
    EXPECT_LE(distance(pluecker(found).moment, pluecker(given).moment), this->tolerance);
  }
}

TYPED_TEST(ScrewGeometry, ScrewOfItsAxisIsTheScrew) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Screw<T> X = this->random.screw();
    EXPECT_LE(distance(screw(screw_axis(X)), X), this->tolerance * (T(1) + T(1) / norm(X.w)));
  }
}

TYPED_TEST(ScrewGeometry, InfinitePitchIsATranslation) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Vec3<T> e = this->random.direction();
    const ScrewAxis<T> found = screw_axis(Screw<T>{{}, T(2.5) * e});
    EXPECT_EQ(found.h, this->infinity);
    EXPECT_NEAR(found.magnitude, T(2.5), this->tolerance);
    EXPECT_LE(distance(found.e, e), this->tolerance);
    const Screw<T> X = screw(ScrewAxis<T>{e, this->random.vector(), this->infinity, T(2.5)});
    EXPECT_EQ(norm(X.w), T(0));
    EXPECT_LE(distance(X.v, T(2.5) * e), this->tolerance);
  }
}

TYPED_TEST(ScrewGeometry, TheZeroScrewHasNoMagnitude) {
  using T = TypeParam;
  const ScrewAxis<T> nothing = screw_axis(Screw<T>{});
  EXPECT_EQ(nothing.magnitude, T(0));
  EXPECT_EQ(norm(nothing.e), T(0));
  EXPECT_EQ(to_eigen(screw(nothing)).norm(), T(0));
}

TYPED_TEST(ScrewGeometry, PointsOnTheAxisMoveAlongIt) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const ScrewAxis<T> a = this->axis();
    const Screw<T> V = screw(a);
    const Vec3<T> point = a.p + this->random.number(T(-2), T(2)) * a.e;
    EXPECT_LE(distance(V.v + cross(V.w, point), (a.magnitude * a.h) * a.e), 4 * this->tolerance);
    const SE3<T> C = exp(screw(a.e, a.p, a.h));  // one radian about the axis advances by the pitch
    EXPECT_LE(distance(C * point, point + a.h * a.e), 4 * this->tolerance);
  }
}

TYPED_TEST(ScrewGeometry, TwistsAndWrenchesHaveAxesInTheirFrame) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const SE3<T> C = this->random.pose();
    const ScrewAxis<T> a = this->axis();
    const Screw<T> X = screw(a);
    const Twist<BodyFixed, T> V{X.w, X.v};
    const Wrench<BodyFixed, T> W{X.v, X.w};  // force along the axis, moment by Plücker's rule
    const ScrewAxis<T> of_twist = screw_axis(Ad(C, V)), of_wrench = screw_axis(coAd(C, W));
    for (const ScrewAxis<T>& moved : {of_twist, of_wrench}) {
      EXPECT_LE(distance(moved.e, C.R * a.e), this->tolerance);
      EXPECT_NEAR(moved.h, a.h, 10 * this->tolerance);
      EXPECT_NEAR(moved.magnitude, a.magnitude, this->tolerance);
      EXPECT_LE(norm(cross(C * a.p - moved.p, moved.e)), 10 * this->tolerance);
    }
  }
}

TYPED_TEST(ScrewGeometry, PitchOfAWrenchIsMomentAlongTheForcePerForce) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const auto W = this->random.template any<Wrench<Spatial, T>>();
    const ScrewAxis<T> axis = screw_axis(W);
    EXPECT_NEAR(axis.h * dot(W.f, W.f), dot(W.m, W.f), this->tolerance);
    EXPECT_NEAR(axis.magnitude, norm(W.f), this->tolerance);
    const Vec3<T> moment_on_axis = W.m - cross(axis.p, W.f);  // Poinsot: it is parallel to the force
    EXPECT_LE(distance(moment_on_axis, axis.h * W.f), this->tolerance);
  }
  const ScrewAxis<T> couple = screw_axis(Wrench<Spatial, T>{{0, 0, 3}, {}});
  EXPECT_EQ(couple.h, this->infinity);
  EXPECT_EQ(couple.magnitude, T(3));
}

TYPED_TEST(ScrewGeometry, ZeroPitchScrewsAreReciprocalWhenTheirAxesMeetOrAreParallel) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Vec3<T> e1 = this->random.direction(), e2 = this->random.direction(), p = this->random.vector();
    const Vec3<T> p1 = p + this->random.number(T(-1), T(1)) * e1,
                  p2 = p + this->random.number(T(-1), T(1)) * e2;
    EXPECT_NEAR(reciprocal_product(screw(e1, p1), screw(e2, p2)), T(0), this->tolerance);
    EXPECT_NEAR(reciprocal_product(screw(e1, p1), screw(e1, this->random.vector())), T(0), this->tolerance);
  }
}

TYPED_TEST(ScrewGeometry, ReciprocalProductIsPitchTimesCosineLessDistanceTimesSine) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Vec3<T> e = this->random.direction(), normal = cross(e, this->random.direction());
    if (norm(normal) < T(0.1)) continue;
    const Vec3<T> n = (T(1) / norm(normal)) * normal, p = this->random.vector();
    const T angle = this->random.number(T(-3), T(3)), d = this->random.number(T(-2), T(2));
    const T h1 = this->random.number(T(-1), T(1)), h2 = this->random.number(T(-1), T(1));
    const Screw<T> X = screw(e, p, h1), Z = screw(exp_SO3(angle * n) * e, p + d * n, h2);
    EXPECT_NEAR(reciprocal_product(X, Z), (h1 + h2) * cos(angle) - d * sin(angle), this->tolerance);
  }
}

TYPED_TEST(ScrewGeometry, ReciprocalProductIsThePowerOfAWrenchOnATwist) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const auto V = this->random.template any<Twist<Spatial, T>>();
    const auto W = this->random.template any<Wrench<Spatial, T>>();
    EXPECT_NEAR(reciprocal_product(screw(V), Screw<T>{W.f, W.m}), W | V, this->tolerance);
  }
}

}  // namespace
}  // namespace axode::test
