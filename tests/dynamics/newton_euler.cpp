#include "axode/lie/newton_euler.hpp"

#include <gtest/gtest.h>

#include "tests/lie/random_quantities.hpp"
#include "tests/lie/relative_error.hpp"
#include "tests/support/cases.hpp"

/// One rigid body: its Newton-Euler equations in every representation, for any body frame and any frames j
/// and k.
namespace axode::test {
namespace {

constexpr int samples = 500;

template <class C> class NewtonEuler : public testing::Test {};
TYPED_TEST_SUITE(NewtonEuler, Cases, CaseNames);

/// A body of point masses, where it is and how it moves. Everything else follows from Newton.
template <class T> struct Cloud {
  SE3<T> C;
  Twist<BodyFixed, T> V;
  TwistRate<BodyFixed, T> dV;
  Inertia<T> M;               ///< in the body frame
  Wrench<Spatial, T> W{};     ///< Σ (p × m p'', m p'') in the inertial frame
  Momentum<Spatial, T> Pi{};  ///< Σ (p × m p', m p')

  explicit Cloud(Random<T>& random)
      : C{random.rotation(), random.vector()},
        V(random.template any<Twist<BodyFixed, T>>()),
        dV(random.template any<TwistRate<BodyFixed, T>>()) {
    for (int k = 0; k < 6; ++k) {
      const T m = random.number(T(0.2), T(1));
      const Vec3<T> c = random.vector();
      const Vec3<T> v = V.v + cross(V.w, c);                                      // in body axes
      const Vec3<T> a = dV.v + cross(dV.w, c) + cross(V.w, V.v + cross(V.w, c));  // d/dt R v = R (v' + ω × v)
      const Vec3<T> p = C * c, f = m * (C.R * a), momentum = m * (C.R * v);
      M += inertia_from_com(m, c, Sym3<T>{});
      W += {cross(p, f), f};
      Pi += {cross(p, momentum), momentum};
    }
  }
};

TYPED_TEST(NewtonEuler, ResultantIsNewtonsForEveryPointOfTheBody) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Random<T> random;
  for (int k = 0; k < samples; ++k) {
    const Cloud<T> body(random);
    const Twist<Rep, T> V = change<Rep>(body.C, body.V);
    const TwistRate<Rep, T> dV = change<Rep>(body.C, body.V, body.dV);
    EXPECT_LE(relative_error(change<Spatial>(body.C, wrench(body.C, body.M, V, dV)), body.W), tolerance<T>);
    EXPECT_LE(relative_error(change<Spatial>(body.C, body.M * body.V), body.Pi), tolerance<T>);
  }
}

TYPED_TEST(NewtonEuler, AccelerationInvertsWrench) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Random<T> random;
  for (int k = 0; k < samples; ++k) {
    const Cloud<T> body(random);
    const Twist<Rep, T> V = change<Rep>(body.C, body.V);
    const TwistRate<Rep, T> dV = change<Rep>(body.C, body.V, body.dV);
    const Wrench<Rep, T> W = wrench(body.C, body.M, V, dV);
    EXPECT_LE(relative_error(acceleration(body.C, body.M, V, W), dV), 100 * tolerance<T>);
    const Wrench<Rep, T> given = random.template any<Wrench<Rep, T>>();
    EXPECT_LE(relative_error(wrench(body.C, body.M, V, acceleration(body.C, body.M, V, given)), given),
              100 * tolerance<T>);
  }
}

TYPED_TEST(NewtonEuler, AtTheCentreOfMassForceAndMomentDecouple) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Random<T> random;
  for (int k = 0; k < samples; ++k) {
    const Cloud<T> body(random);
    const SE3<T> to_com{{}, center_of_mass(body.M)};
    const SE3<T> C = body.C * to_com;
    const Inertia<T> M = transform(inverse(to_com), body.M);
    const Twist<BodyFixed, T> V{body.V.w, body.V.v + cross(body.V.w, to_com.r)};
    const TwistRate<BodyFixed, T> dV{body.dV.w, body.dV.v + cross(body.dV.w, to_com.r)};
    const Wrench<Hybrid, T> W = change<Hybrid>(C, wrench(C, M, change<Rep>(C, V), change<Rep>(C, V, dV)));
    const TwistRate<Hybrid, T> dV_h = change<Hybrid>(C, V, dV);
    const Vec3<T> moment = C.R * (M.Theta * V.w);
    EXPECT_LE(relative_error(W.f, M.m * dV_h.v), tolerance<T>);
    EXPECT_LE(relative_error(W.m, C.R * (M.Theta * dV.w) + cross(C.R * V.w, moment)), tolerance<T>);
    EXPECT_LE(relative_error(change<Spatial>(C, W), body.W), 10 * tolerance<T>);
  }
}

template <class T> class NewtonEulerInFrames : public testing::Test {};
TYPED_TEST_SUITE(NewtonEulerInFrames, Scalars, ScalarNames);

template <class T> FramePair<T> random_pair(Random<T>& random) {
  return {random.vector(), random.vector(), random.rotation(), random.vector()};
}

TYPED_TEST(NewtonEulerInFrames, ResultantIsThatOfTheSpatialEquation) {
  using T = TypeParam;
  Random<T> random;
  for (int k = 0; k < samples; ++k) {
    const Cloud<T> body(random);
    const FramePair<T> jk = random_pair(random);
    const Twist<Spatial, T> V_s = change<Spatial>(body.C, body.V);
    const TwistRate<Spatial, T> dV_s = change<Spatial>(body.C, body.V, body.dV);
    const Twist<InFrames, T> V = change(jk, V_s);
    const TwistRate<InFrames, T> dV = change(jk, V_s, dV_s);
    EXPECT_LE(relative_error(change(jk, wrench(body.C, body.M, jk, V, dV)), body.W), 10 * tolerance<T>);
    EXPECT_LE(relative_error(change(jk, inertia_in_frames(jk, body.C, body.M) * V), body.Pi),
              10 * tolerance<T>);
  }
}

TYPED_TEST(NewtonEulerInFrames, AccelerationInvertsWrench) {
  using T = TypeParam;
  Random<T> random;
  for (int k = 0; k < samples; ++k) {
    const Cloud<T> body(random);
    const FramePair<T> jk = random_pair(random);
    const Twist<InFrames, T> V = random.template any<Twist<InFrames, T>>();
    const TwistRate<InFrames, T> dV = random.template any<TwistRate<InFrames, T>>();
    const Wrench<InFrames, T> W = wrench(body.C, body.M, jk, V, dV);
    EXPECT_LE(distance(acceleration(body.C, body.M, jk, V, W), dV),
              100 * tolerance<T> * (T(1) + to_eigen(W).norm()));
  }
}

TYPED_TEST(NewtonEulerInFrames, SpatialBodyFixedAndHybridAreSpecialCases) {
  using T = TypeParam;
  Random<T> random;
  for (int k = 0; k < samples; ++k) {
    const Cloud<T> body(random);
    const SE3<T>& C = body.C;
    const Twist<Spatial, T> V_s = change<Spatial>(C, body.V);
    const TwistRate<Spatial, T> dV_s = change<Spatial>(C, body.V, body.dV);
    const Twist<Hybrid, T> V_h = change<Hybrid>(C, body.V);
    const auto agree = [&](const FramePair<T>& jk, auto rep) {
      using Rep = decltype(rep);
      const Twist<Rep, T> V = change<Rep>(C, body.V);
      const TwistRate<Rep, T> dV = change<Rep>(C, body.V, body.dV);
      const Twist<InFrames, T> V_jk = change(jk, V_s);
      const TwistRate<InFrames, T> dV_jk = change(jk, V_s, dV_s);
      EXPECT_LE((to_eigen(V_jk) - to_eigen(V)).norm(), tolerance<T> * 10);
      EXPECT_LE((to_eigen(dV_jk) - to_eigen(dV)).norm(), tolerance<T> * 10);
      const auto W = to_eigen(wrench(C, body.M, V, dV));
      EXPECT_LE((to_eigen(wrench(C, body.M, jk, V_jk, dV_jk)) - W).norm(),
                10 * tolerance<T> * (T(1) + W.norm()));
    };
    agree(FramePair<T>{}, Spatial{});
    agree(FramePair<T>{C.r, V_h.v, C.R, V_h.w}, BodyFixed{});
    agree(FramePair<T>{C.r, V_h.v, {}, {}}, Hybrid{});
  }
}

}  // namespace
}  // namespace axode::test
