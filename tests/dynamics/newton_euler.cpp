#include "axode/lie/newton_euler.hpp"

#include "tests/laws/law.hpp"
#include "tests/lie/relative_error.hpp"
#include "tests/support/functions.hpp"

/// The Newton-Euler equations of one rigid body in every representation, for any body frame and any frames j
/// and k.
namespace axode::test {
namespace {

class NewtonEuler : public Law {
 protected:
  const double tolerance = GetParam().single ? test::tolerance<float> : test::tolerance<double>;

  static constexpr int samples = 500;
  /// Calls law(representation, random) several times, with random quantities in the scalar type of the case.
  template <class F> static void for_samples(const F& law) {
    with_scalar(GetParam(), [&](auto scalar) {
      Random<decltype(scalar)> random;
      for (int k = 0; k < samples; ++k)
        with_representation(GetParam().representation, [&](auto rep) { law(rep, random); });
    });
  }
};
INSTANTIATE_TEST_SUITE_P(Dynamics, NewtonEuler, testing::ValuesIn(cases()), name_of);
class NewtonEulerInFrames : public NewtonEuler {
 protected:
  template <class F> static void for_samples(const F& law) {
    with_scalar(GetParam(), [&](auto scalar) {
      Random<decltype(scalar)> random;
      for (int k = 0; k < samples; ++k) law(random);
    });
  }
};
INSTANTIATE_TEST_SUITE_P(Dynamics, NewtonEulerInFrames, testing::ValuesIn(scalars()), name_of);

/// The components of a quantity as doubles.
template <template <class, class> class Kind, class Rep, class T> Six in_double(const Kind<Rep, T>& x) {
  const auto& [a, b] = x;
  return {axode::cast<double>(a), axode::cast<double>(b)};
}
void expect_close(const Six& x, const Six& reference, double bound) {
  EXPECT_LE(relative_error(x, reference), bound);
}
template <template <class, class> class Kind, class Rep, class T>
void expect_close(const Kind<Rep, T>& x, const std::type_identity_t<Kind<Rep, T>>& reference, double bound) {
  expect_close(in_double(x), in_double(reference), bound);
}
template <class T> void expect_close(const Vec3<T>& x, const Vec3<T>& reference, double bound) {
  expect_close({axode::cast<double>(x), {}}, {axode::cast<double>(reference), {}}, bound);
}

/// A body of point masses, its pose and its motion. All other quantities follow from Newton's law for the
/// point masses.
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

TEST_P(NewtonEuler, ResultantIsNewtonsForEveryPointOfTheBody) {
  for_samples([&]<class Rep, class T>(Rep, Random<T>& random) {
    const Cloud<T> body(random);
    const Twist<Rep, T> V = change<Rep>(body.C, body.V);
    const TwistRate<Rep, T> dV = change<Rep>(body.C, body.V, body.dV);
    expect_close(change<Spatial>(body.C, wrench(body.C, body.M, V, dV)), body.W, tolerance);
    expect_close(change<Spatial>(body.C, body.M * body.V), body.Pi, tolerance);
  });
}

TEST_P(NewtonEuler, AccelerationInvertsWrench) {
  for_samples([&]<class Rep, class T>(Rep, Random<T>& random) {
    const Cloud<T> body(random);
    const Twist<Rep, T> V = change<Rep>(body.C, body.V);
    const TwistRate<Rep, T> dV = change<Rep>(body.C, body.V, body.dV);
    const Wrench<Rep, T> W = wrench(body.C, body.M, V, dV);
    expect_close(acceleration(body.C, body.M, V, W), dV, 100 * tolerance);
    const Wrench<Rep, T> given = random.template any<Wrench<Rep, T>>();
    expect_close(wrench(body.C, body.M, V, acceleration(body.C, body.M, V, given)), given, 100 * tolerance);
  });
}

TEST_P(NewtonEuler, AtTheCentreOfMassForceAndMomentDecouple) {
  for_samples([&]<class Rep, class T>(Rep, Random<T>& random) {
    const Cloud<T> body(random);
    const SE3<T> to_com{{}, center_of_mass(body.M)};
    const SE3<T> C = body.C * to_com;
    const Inertia<T> M = transform(inverse(to_com), body.M);
    const Twist<BodyFixed, T> V{body.V.w, body.V.v + cross(body.V.w, to_com.r)};
    const TwistRate<BodyFixed, T> dV{body.dV.w, body.dV.v + cross(body.dV.w, to_com.r)};
    const Wrench<Hybrid, T> W = change<Hybrid>(C, wrench(C, M, change<Rep>(C, V), change<Rep>(C, V, dV)));
    const TwistRate<Hybrid, T> dV_h = change<Hybrid>(C, V, dV);
    const Vec3<T> moment = C.R * (M.Theta * V.w);
    expect_close(W.f, M.m * dV_h.v, tolerance);
    expect_close(W.m, C.R * (M.Theta * dV.w) + cross(C.R * V.w, moment), tolerance);
    expect_close(change<Spatial>(C, W), body.W, 10 * tolerance);
  });
}

template <class T> FramePair<T> random_pair(Random<T>& random) {
  return {random.vector(), random.vector(), random.rotation(), random.vector()};
}

TEST_P(NewtonEulerInFrames, ResultantIsThatOfTheSpatialEquation) {
  for_samples([&]<class T>(Random<T>& random) {
    const Cloud<T> body(random);
    const FramePair<T> jk = random_pair(random);
    const Twist<Spatial, T> V_s = change<Spatial>(body.C, body.V);
    const TwistRate<Spatial, T> dV_s = change<Spatial>(body.C, body.V, body.dV);
    const Twist<InFrames, T> V = change(jk, V_s);
    const TwistRate<InFrames, T> dV = change(jk, V_s, dV_s);
    expect_close(change(jk, wrench(body.C, body.M, jk, V, dV)), body.W, 10 * tolerance);
    expect_close(change(jk, inertia_in_frames(jk, body.C, body.M) * V), body.Pi, 10 * tolerance);
  });
}

/// ‖x - y‖ <= bound.
template <class X, class Y> void expect_near(const X& x, const Y& y, double bound) {
  EXPECT_LE(distance(in_double(x), in_double(y)), bound);
}
double norm(const Six& x) { return distance(x, Six{}); }

TEST_P(NewtonEulerInFrames, AccelerationInvertsWrench) {
  for_samples([&]<class T>(Random<T>& random) {
    const Cloud<T> body(random);
    const FramePair<T> jk = random_pair(random);
    const Twist<InFrames, T> V = random.template any<Twist<InFrames, T>>();
    const TwistRate<InFrames, T> dV = random.template any<TwistRate<InFrames, T>>();
    const Wrench<InFrames, T> W = wrench(body.C, body.M, jk, V, dV);
    expect_near(acceleration(body.C, body.M, jk, V, W), dV, 100 * tolerance * (1 + norm(in_double(W))));
  });
}

TEST_P(NewtonEulerInFrames, SpatialBodyFixedAndHybridAreSpecialCases) {
  for_samples([&]<class T>(Random<T>& random) {
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
      expect_near(V_jk, V, 10 * tolerance);
      expect_near(dV_jk, dV, 10 * tolerance);
      const Wrench<Rep, T> W = wrench(C, body.M, V, dV);
      expect_near(wrench(C, body.M, jk, V_jk, dV_jk), W, 10 * tolerance * (1 + norm(in_double(W))));
    };
    agree(FramePair<T>{}, Spatial{});
    agree(FramePair<T>{C.r, V_h.v, C.R, V_h.w}, BodyFixed{});
    agree(FramePair<T>{C.r, V_h.v, {}, {}}, Hybrid{});
  });
}

}  // namespace
}  // namespace axode::test
