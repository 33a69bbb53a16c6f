#include <gtest/gtest.h>

#include <tuple>

#include "axode/scalar/taylor.hpp"
#include "tests/lie/random_quantities.hpp"
#include "tests/lie/relative_error.hpp"

/// Changes of twists, twist rates, wrenches and momenta between the four representations, and to any pair of
/// frames.
namespace axode::test {
namespace {

/// Calls law for all sixteen pairs of representations.
template <class Law> void for_each_pair(const Law& law) {
  const std::tuple<BodyFixed, Spatial, Hybrid, Mixed> all;
  std::apply(
      [&](auto... from) {
        const auto to_all = [&](auto f) { std::apply([&](auto... to) { (law(f, to), ...); }, all); };
        (to_all(from), ...);
      },
      all);
}

template <class T> class Change : public testing::Test {
 protected:
  static constexpr int samples = 200;
  static constexpr T tolerance = test::tolerance<T>;
  Random<T> random;
};
TYPED_TEST_SUITE(Change, Scalars, ScalarNames);

TYPED_TEST(Change, ThereAndBackIsTheSameInAllPairs) {
  using T = TypeParam;
  for_each_pair([&]<class From, class To>(From, To) {
    for (int k = 0; k < this->samples; ++k) {
      const SE3<T> C = this->random.pose();
      const auto V = this->random.template any<Twist<From, T>>();
      const auto dV = this->random.template any<TwistRate<From, T>>();
      const auto W = this->random.template any<Wrench<From, T>>();
      const auto Pi = this->random.template any<Momentum<From, T>>();
      const Twist<To, T> V_to = change<To>(C, V);
      EXPECT_LE(relative_error(change<From>(C, V_to), V), this->tolerance);
      EXPECT_LE(relative_error(change<From>(C, V_to, change<To>(C, V, dV)), dV), this->tolerance);
      EXPECT_LE(relative_error(change<From>(C, change<To>(C, W)), W), this->tolerance);
      EXPECT_LE(relative_error(change<From>(C, change<To>(C, Pi)), Pi), this->tolerance);
    }
  });
}

TYPED_TEST(Change, PowerAndKineticEnergyAreTheSameInAllPairs) {
  using T = TypeParam;
  for_each_pair([&]<class From, class To>(From, To) {
    for (int k = 0; k < this->samples; ++k) {
      const SE3<T> C = this->random.pose();
      const auto V = this->random.template any<Twist<From, T>>();
      const auto W = this->random.template any<Wrench<From, T>>();
      const auto Pi = this->random.template any<Momentum<From, T>>();
      EXPECT_NEAR(change<To>(C, W) | change<To>(C, V), W | V, 10 * this->tolerance);
      EXPECT_NEAR(change<To>(C, Pi) | change<To>(C, V), Pi | V, 10 * this->tolerance);
    }
  });
}

TYPED_TEST(Change, CoadjointTwinsPreservePower) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const SE3<T> C = this->random.pose();
    const auto V = this->random.template any<Twist<BodyFixed, T>>();
    const auto X = this->random.template any<Twist<BodyFixed, T>>();
    const auto W = this->random.template any<Wrench<BodyFixed, T>>();
    const auto Pi = this->random.template any<Momentum<BodyFixed, T>>();
    EXPECT_NEAR(coAd(C, W) | Ad(C, V), W | V, this->tolerance);
    EXPECT_LE(relative_error(coAd_inv(C, coAd(C, W)), W), this->tolerance);
    EXPECT_LE(relative_error(Ad_inv(C, Ad(C, V)), V), this->tolerance);
    EXPECT_NEAR(coad(X, W) | V, -(W | ad(X, V)), this->tolerance);  // coad_X = -ad_Xᵀ
    EXPECT_NEAR(coad(X, Pi) | V, -(Pi | ad(X, V)), this->tolerance);
  }
}

TYPED_TEST(Change, MatricesOfThePaperTakeTwistsToEachOther) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const SE3<T> C = this->random.pose();
    const auto V = this->random.template any<Twist<BodyFixed, T>>();
    const Vector6<T> b = to_eigen(V), s = to_eigen(change<Spatial>(C, V)), h = to_eigen(change<Hybrid>(C, V)),
                     m = to_eigen(change<Mixed>(C, V));
    Matrix6<T> m_of_s = Matrix6<T>::Identity();  // eq. Vmbhs
    m_of_s.template topLeftCorner<3, 3>() = to_eigen(transpose(C.R));
    m_of_s.template bottomLeftCorner<3, 3>() = -skew(C.r);
    EXPECT_LE((h - Ad_matrix(C.R) * b).norm(), this->tolerance);  // eq. VhVb
    EXPECT_LE((s - Ad_matrix(C) * b).norm(), this->tolerance);    // eq. VsVb
    EXPECT_LE((s - Ad_matrix(C.r) * h).norm(), this->tolerance);
    EXPECT_LE((m - m_of_s * s).norm(), this->tolerance);
  }
}

/// A smooth motion C(t) = C0 exp(X1 t + X2 t² + X3 t³) as a power series in time, a point and a frame.
using Series = Taylor<double, 4>;
Series series(double c0, double c1, double c2, double c3) { return Series({c0, c1, c2, c3}); }
Vec3<Series> series(const Vec3<>& c0, const Vec3<>& c1, const Vec3<>& c2, const Vec3<>& c3) {
  return {series(c0.x, c1.x, c2.x, c3.x), series(c0.y, c1.y, c2.y, c3.y), series(c0.z, c1.z, c2.z, c3.z)};
}
SE3<Series> constant(const SE3<>& C) {
  const Vec3<> o{};
  return {{series(C.R.x, o, o, o), series(C.R.y, o, o, o), series(C.R.z, o, o, o)}, series(C.r, o, o, o)};
}
SE3<Series> motion(Random<double>& random) {
  const Vec3<> o{};
  const Screw<Series> X{series(o, random.vector(), random.vector(), random.vector()),
                        series(o, random.vector(), random.vector(), random.vector())};
  return constant(random.pose()) * exp(X);
}
Series rate(const Series& a) { return series(a.c[1], 2 * a.c[2], 3 * a.c[3], 0); }
Vec3<Series> rate(const Vec3<Series>& a) { return {rate(a.x), rate(a.y), rate(a.z)}; }
SO3<Series> rate(const SO3<Series>& R) { return {rate(R.x), rate(R.y), rate(R.z)}; }
/// The coefficient of tᵏ in a series.
Vec3<> at(const Vec3<Series>& a, std::size_t k) { return {a.x.c[k], a.y.c[k], a.z.c[k]}; }
SO3<> at(const SO3<Series>& R, std::size_t k) { return {at(R.x, k), at(R.y, k), at(R.z, k)}; }
SE3<> at(const SE3<Series>& C, std::size_t k) { return {at(C.R, k), at(C.r, k)}; }
template <class Rep> Twist<Rep> value(const Twist<Rep, Series>& V) { return {at(V.w, 0), at(V.v, 0)}; }
template <class Rep> TwistRate<Rep> slope(const Twist<Rep, Series>& V) { return {at(V.w, 1), at(V.v, 1)}; }
/// The angular velocity from its definition ω̃^s = Ṙ Rᵀ.
Vec3<Series> angular_velocity(const SO3<Series>& R) {
  const SO3<Series> w = rate(R) * transpose(R);
  return {w.y.z, w.z.x, w.x.y};
}

/// The four twists of a motion from their definitions.
template <class Rep> Twist<Rep, Series> twist_of(const SE3<Series>& C) {
  const Vec3<Series> w = angular_velocity(C.R), dr = rate(C.r);
  const SO3<Series> Rt = transpose(C.R);
  if constexpr (std::same_as<Rep, BodyFixed>) return {Rt * w, Rt * dr};
  if constexpr (std::same_as<Rep, Spatial>) return {w, dr + cross(C.r, w)};
  if constexpr (std::same_as<Rep, Hybrid>) return {w, dr};
  if constexpr (std::same_as<Rep, Mixed>) return {Rt * w, dr};
}

TEST(ChangeAlongAMotion, TwistsAgreeWithTheirDefinitions) {
  Random<double> random;
  for_each_pair([&]<class From, class To>(From, To) {
    for (int k = 0; k < 50; ++k) {
      const SE3<Series> C = motion(random);
      const Twist<To> V = change<To>(at(C, 0), value(twist_of<From>(C)));
      EXPECT_LE(relative_error(V, value(twist_of<To>(C))), tolerance<double>);
    }
  });
}

TEST(ChangeAlongAMotion, TheRateOfAChangedTwistIsItsTimeDerivative) {
  Random<double> random;
  for_each_pair([&]<class From, class To>(From, To) {
    for (int k = 0; k < 50; ++k) {
      const SE3<Series> C = motion(random);
      const Twist<From, Series> V = twist_of<From>(C);
      const TwistRate<To> dV = change<To>(at(C, 0), value(V), slope(V));
      EXPECT_LE(relative_error(dV, slope(change<To>(C, V))), tolerance<double>);
      EXPECT_LE(relative_error(dV, slope(twist_of<To>(C))), tolerance<double>);
    }
  });
}

/// Frames F_j and F_k that move independently of the body.
struct MovingFrames {
  SE3<Series> C_j, C_k;
  FramePair<Series> series() const { return {C_j.r, rate(C_j.r), C_k.R, angular_velocity(C_k.R)}; }
  FramePair<> now() const {
    const FramePair<Series> jk = series();
    return {at(jk.r_j, 0), at(jk.dr_j, 0), at(jk.R_k, 0), at(jk.w_k, 0)};
  }
};

TEST(FramePair, MeasuresAtTheOriginOfJAndResolvesInK) {
  Random<double> random;
  for (int k = 0; k < 200; ++k) {
    const MovingFrames frames{motion(random), motion(random)};
    const FramePair<> jk = frames.now();
    const auto V = random.any<Twist<Spatial>>();
    const Twist<InFrames> V_jk = change(jk, V);
    const Vec3<> velocity_at_j = V.v + cross(V.w, jk.r_j);  // of the body's point at the origin of F_j
    EXPECT_LE(relative_error(jk.R_k * V_jk.w, V.w), tolerance<double>);
    EXPECT_LE(relative_error(jk.R_k * V_jk.v, velocity_at_j), tolerance<double>);
    const auto W = random.any<Wrench<Spatial>>();
    const Wrench<InFrames> W_jk = change(jk, W);
    EXPECT_LE(relative_error(jk.R_k * W_jk.f, W.f), tolerance<double>);
    EXPECT_LE(relative_error(jk.R_k * W_jk.m, W.m - cross(jk.r_j, W.f)), tolerance<double>);
  }
}

TEST(FramePair, ThereAndBackIsTheSameAndKeepsPowerAndEnergy) {
  Random<double> random;
  for (int k = 0; k < 200; ++k) {
    const MovingFrames frames{motion(random), motion(random)};
    const FramePair<> jk = frames.now();
    const auto V = random.any<Twist<Spatial>>();
    const auto dV = random.any<TwistRate<Spatial>>();
    const auto W = random.any<Wrench<Spatial>>();
    const auto Pi = random.any<Momentum<Spatial>>();
    EXPECT_LE(relative_error(change(jk, change(jk, V)), V), tolerance<double>);
    EXPECT_LE(relative_error(change(jk, change(jk, V), change(jk, V, dV)), dV), tolerance<double>);
    EXPECT_LE(relative_error(change(jk, change(jk, W)), W), tolerance<double>);
    EXPECT_LE(relative_error(change(jk, change(jk, Pi)), Pi), tolerance<double>);
    EXPECT_NEAR(change(jk, W) | change(jk, V), W | V, 10 * tolerance<double>);
    EXPECT_NEAR(change(jk, Pi) | change(jk, V), Pi | V, 10 * tolerance<double>);
  }
}

TEST(FramePair, TheRateIsTheTimeDerivativeThoughBothFramesMove) {
  Random<double> random;
  for (int k = 0; k < 200; ++k) {
    const MovingFrames frames{motion(random), motion(random)};
    const Twist<Spatial, Series> V = twist_of<Spatial>(motion(random));
    const Twist<InFrames, Series> V_jk = change(frames.series(), V);
    EXPECT_LE(relative_error(change(frames.now(), value(V), slope(V)), slope(V_jk)), tolerance<double>);
    EXPECT_LE(relative_error(change(frames.now(), value(V_jk), slope(V_jk)), slope(V)), tolerance<double>);
  }
}

TEST(FramePair, SpatialBodyFixedAndHybridAreSpecialPairs) {
  Random<double> random;
  const auto agree = [](const FramePair<>& jk, const Twist<Spatial>& V, const TwistRate<Spatial>& dV,
                        auto V_rep, auto dV_rep) {
    const Twist<InFrames> V_jk = change(jk, V);
    const TwistRate<InFrames> dV_jk = change(jk, V, dV);
    EXPECT_LE((to_eigen(V_jk) - to_eigen(V_rep)).norm(), tolerance<double>);
    EXPECT_LE((to_eigen(dV_jk) - to_eigen(dV_rep)).norm(), tolerance<double>);
  };
  for (int k = 0; k < 200; ++k) {
    const SE3<> C = random.pose();
    const auto V = random.any<Twist<Spatial>>();
    const auto dV = random.any<TwistRate<Spatial>>();
    const Vec3<> dr = change<Hybrid>(C, V).v;
    agree({}, V, dV, V, dV);
    agree({C.r, dr, C.R, V.w}, V, dV, change<BodyFixed>(C, V), change<BodyFixed>(C, V, dV));
    agree({C.r, dr, {}, {}}, V, dV, change<Hybrid>(C, V), change<Hybrid>(C, V, dV));
  }
}

/// The statements of the table "Which acceleration is this?" in docs/notation.md.
TEST(TwistRates, WhichAccelerationTheyHold) {
  Random<double> random;
  for (int k = 0; k < 50; ++k) {
    const SE3<Series> C = motion(random);
    const SO3<> Rt = transpose(at(C.R, 0));
    const Vec3<> r = at(C.r, 0), dr = at(C.r, 1), ddr = 2.0 * at(C.r, 2);
    const Vec3<> w = at(angular_velocity(C.R), 0), dw = at(angular_velocity(C.R), 1);
    const Twist<BodyFixed> V = value(twist_of<BodyFixed>(C));
    const TwistRate<BodyFixed> dV = slope(twist_of<BodyFixed>(C));
    const SE3<> C0 = at(C, 0);
    EXPECT_LE(relative_error(dV, {Rt * dw, Rt * ddr - cross(V.w, V.v)}), tolerance<double>);
    EXPECT_LE(relative_error(change<Spatial>(C0, V, dV), {dw, ddr + cross(r, dw) + cross(dr, w)}),
              tolerance<double>);
    EXPECT_LE(relative_error(change<Hybrid>(C0, V, dV), {dw, ddr}), tolerance<double>);
    EXPECT_LE(relative_error(change<Mixed>(C0, V, dV), {Rt * dw, ddr}), tolerance<double>);
    const Screw<> carried =
        Ad(C0, Screw<>{dV.w, dV.v});  // body-fixed and spatial rates are one geometric object
    EXPECT_LE(distance(change<Spatial>(C0, V, dV), {carried.w, carried.v}), tolerance<double>);
  }
}

}  // namespace
}  // namespace axode::test
