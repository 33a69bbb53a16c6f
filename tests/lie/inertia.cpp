#include <gtest/gtest.h>

#include <vector>

#include "tests/lie/random_quantities.hpp"
#include "tests/lie/relative_error.hpp"

/// Inertia about any frame, Binet's tensor, and the inertias that a mass distribution can have.
namespace axode::test {
namespace {

template <class T> class InertiaLaws : public testing::Test {
 protected:
  static constexpr int samples = 200;
  static constexpr T tolerance = test::tolerance<T>;
  Random<T> random;
};
TYPED_TEST_SUITE(InertiaLaws, Scalars, ScalarNames);

TYPED_TEST(InertiaLaws, MomentumAndEnergyOfPointMassesAreThoseOfNewton) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const auto V = this->random.template any<Twist<BodyFixed, T>>();
    Inertia<T> M;
    Momentum<BodyFixed, T> Pi{};
    T twice_energy{};
    for (int i = 0; i < 5; ++i) {
      const T m = this->random.number(T(0.1), T(1));
      const Vec3<T> p = this->random.vector(), v = V.v + cross(V.w, p);
      M += inertia_from_com(m, p, Sym3<T>{});
      Pi += {m * cross(p, v), m * v};
      twice_energy += m * dot(v, v);
    }
    EXPECT_LE(relative_error(M * V, Pi), this->tolerance);
    EXPECT_NEAR((M * V) | V, twice_energy, 10 * this->tolerance);
    EXPECT_LE((to_eigen(M) * to_eigen(V) - to_eigen(Pi)).norm(), this->tolerance * 10);
    const TwistRate<BodyFixed, T> dV{V.w, V.v};
    EXPECT_LE((to_eigen(M * dV) - to_eigen(Pi)).norm(), this->tolerance * 10);
  }
}

TYPED_TEST(InertiaLaws, TransformIsCongruenceByTheInverseAdjoint) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const SE3<T> S = this->random.pose();
    const Inertia<T> M = this->random.inertia();
    const Matrix6<T> A = Ad_matrix(inverse(S)), B = Ad_matrix(transpose(S.R));
    EXPECT_LE((to_eigen(transform(S, M)) - A.transpose() * to_eigen(M) * A).norm(), 100 * this->tolerance);
    EXPECT_LE((to_eigen(transform(S.R, M)) - B.transpose() * to_eigen(M) * B).norm(), 100 * this->tolerance);
  }
}

TYPED_TEST(InertiaLaws, TransformFollowsTheGroup) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const SE3<T> A = this->random.pose(), B = this->random.pose();
    const Inertia<T> M = this->random.inertia();
    EXPECT_LE(relative_error(transform(A * B, M), transform(A, transform(B, M))), this->tolerance);
    EXPECT_LE(relative_error(transform(inverse(A), transform(A, M)), M), 100 * this->tolerance);
    EXPECT_LE(relative_error(transform(SE3<T>{}, M), M), this->tolerance);
  }
}

TYPED_TEST(InertiaLaws, MomentumMovesWithTheFrame) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const SE3<T> C = this->random.pose();
    const Inertia<T> M = this->random.inertia();
    const auto V = this->random.template any<Twist<BodyFixed, T>>();
    const Momentum<BodyFixed, T> Pi = M * V;
    EXPECT_LE(relative_error(transform(C, M) * Ad(C, V), change<Spatial>(C, Pi)), 4 * this->tolerance);
    EXPECT_LE(relative_error(transform(C.R, M) * change<Hybrid>(C, V), change<Hybrid>(C, Pi)),
              this->tolerance);
  }
}

TYPED_TEST(InertiaLaws, ParallelAxesThereAndBack) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const T m = this->random.number(T(0.5), T(2));
    const Vec3<T> c = this->random.vector();
    const Sym3<T> Theta_c = this->random.tensor();
    const SO3<T> R_bc = this->random.rotation();
    const Inertia<T> M = inertia_from_com(m, c, Theta_c, R_bc);
    EXPECT_LE(distance(center_of_mass(M), c), this->tolerance);
    EXPECT_LE(distance(inertia_about_com(M), rotate(R_bc, Theta_c)), this->tolerance);
    const Eigen::Matrix3<T> R = to_eigen(R_bc), d = skew(c);  // eq. Mb: Θ_b = R Θ_c Rᵀ - m d̃ d̃
    const Eigen::Matrix3<T> Theta_b = R * to_eigen(Theta_c) * R.transpose() - m * d * d;
    EXPECT_LE((to_eigen(M.Theta) - Theta_b).norm(), this->tolerance);
    EXPECT_LE(relative_error(M, transform(SE3<T>{R_bc, c}, Inertia<T>{m, {}, Theta_c})), this->tolerance);
  }
}

TYPED_TEST(InertiaLaws, SteinersTermIsLeastAboutTheCentreOfMass) {
  using T = TypeParam;
  const Inertia<T> M = inertia_from_com(T(2), Vec3<T>{0, 0, 3}, Sym3<T>{1, 1, 1, 0, 0, 0});
  EXPECT_NEAR(M.Theta.xx, T(19), this->tolerance);  // 1 + 2·3²
  EXPECT_NEAR(M.Theta.yy, T(19), this->tolerance);
  EXPECT_NEAR(M.Theta.zz, T(1), this->tolerance);
}

TYPED_TEST(InertiaLaws, BinetsTensorThereAndBackAndItsMeaning) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Sym3<T> Theta = this->random.tensor();
    EXPECT_LE(distance(rotational_inertia(binet_tensor(Theta)), Theta), this->tolerance);
    Sym3<T> second_moments;
    Inertia<T> M;
    for (int i = 0; i < 4; ++i) {
      const T m = this->random.number(T(0.1), T(1));
      const Vec3<T> p = this->random.vector();
      M += inertia_from_com(m, p, Sym3<T>{});
      second_moments = second_moments + (T(0.5) * m) * symmetric_product(p, p);
    }
    EXPECT_LE(distance(binet_tensor(M.Theta), second_moments), this->tolerance);
  }
}

struct Body {
  const char* name;
  Sym3<> Theta_c;
};
Sym3<> principal(double a, double b, double c) { return {a, b, c, 0, 0, 0}; }

/// The realisability of a body of mass 2 in a random pose.
double realisability_in(Random<double>& random, const Sym3<>& Theta_c) {
  return realisability(transform(random.pose(), Inertia<>{2.0, {}, Theta_c}));
}

TEST(Realisability, SolidBodiesHaveADensity) {
  Random<double> random;
  const double m = 2, r = 0.3, l = 0.7, a = 0.2, b = 0.5, c = 0.9;
  const std::vector<Body> bodies{
      {"ball", identity_tensor(0.4 * m * r * r)},
      {"hollow ball", identity_tensor(2.0 / 3 * m * r * r)},
      {"box", (m / 12) * principal(b * b + c * c, a * a + c * c, a * a + b * b)},
      {"cylinder", m * principal((3 * r * r + l * l) / 12, (3 * r * r + l * l) / 12, r * r / 2)},
      {"cone",
       m * principal(3 * r * r / 20 + 3 * l * l / 80, 3 * r * r / 20 + 3 * l * l / 80, 3 * r * r / 10)}};
  for (const Body& body : bodies) {
    for (int k = 0; k < 50; ++k) EXPECT_GT(realisability_in(random, body.Theta_c), 0.01) << body.name;
  }
  for (int k = 0; k < 200; ++k) EXPECT_GT(realisability(random.inertia()), 0.0) << "point masses";
}

TEST(Realisability, RodsPlatesAndPointsAreAtItsLimit) {
  Random<double> random;
  for (int k = 0; k < 100; ++k) {
    EXPECT_NEAR(realisability_in(random, principal(0.3, 0.3, 0)), 0.0, 1e-12) << "rod";
    EXPECT_NEAR(realisability_in(random, principal(0.1, 0.3, 0.4)), 0.0, 1e-12) << "plate";
  }
  EXPECT_EQ(realisability({1.5, {}, {}}), 0.0) << "point mass at the origin";
}

TEST(Realisability, APointMassAnywhereHasADensity) {
  Random<double> random;
  for (int k = 0; k < 200; ++k) {
    EXPECT_GE(realisability(inertia_from_com(1.5, random.vector(10), Sym3<>{})), 0.0);
    EXPECT_GE(realisability_in(random, principal(0, 0, 0)), 0.0);
  }
}

TEST(Realisability, BrokenTriangleInequalityIsMeasured) {
  Random<double> random;
  for (int k = 0; k < 100; ++k) {  // (a + b - c)/2 over c
    EXPECT_NEAR(realisability_in(random, principal(0.1, 0.2, 0.4)), -0.125, 1e-11);
    EXPECT_NEAR(realisability_in(random, principal(0.4, 0.1, 0.2)), -0.125, 1e-11);
    EXPECT_NEAR(realisability_in(random, principal(0.01, 0.01, 1)), -0.49, 1e-11);
  }
  EXPECT_LT(realisability({1.0, {}, identity_tensor(-1.0)}), 0.0) << "negative tensor";
  EXPECT_LT(realisability({1.0, {1.0, 0, 0}, identity_tensor(0.5)}), 0.0) << "too small for its first moment";
}

TEST(Realisability, PositiveDefinitenessAloneIsNotEnough) {
  const Inertia<> M{1.0, {}, principal(1, 1, 3)};
  EXPECT_GT(eigenvalue_range(M.Theta).smallest, 0.0);
  EXPECT_LT(realisability(M), 0.0);
}

TEST(Realisability, EigenvalueRangeIsThatOfTheMatrix) {
  Random<double> random;
  for (int k = 0; k < 100; ++k) {
    const EigenvalueRange range = eigenvalue_range(rotate(random.rotation(), principal(0.7, -0.2, 0.3)));
    EXPECT_NEAR(range.smallest, -0.2, 1e-14);
    EXPECT_NEAR(range.largest, 0.7, 1e-14);
  }
}

}  // namespace
}  // namespace axode::test
