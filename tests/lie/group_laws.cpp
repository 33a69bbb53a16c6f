#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <vector>

#include "tests/lie/lines.hpp"
#include "tests/lie/random_quantities.hpp"
#include "tests/lie/relative_error.hpp"

/// The laws of the groups SO(3) and SE(3), of their algebras, of exp, log and dexp.
namespace axode::test {
namespace {

template <class T> class Group : public testing::Test {
 protected:
  static constexpr int samples = 500;
  static constexpr T tolerance = test::tolerance<T>;
  static constexpr T pi = std::numbers::pi_v<T>;
  Random<T> random;
};
TYPED_TEST_SUITE(Group, Scalars, ScalarNames);

TYPED_TEST(Group, PosesFormAGroup) {
  for (int k = 0; k < this->samples; ++k) {
    const auto A = this->random.pose(), B = this->random.pose(), C = this->random.pose();
    EXPECT_LE(relative_error((A * B) * C, A * (B * C)), this->tolerance);
    EXPECT_LE(distance(C * inverse(C), SE3<TypeParam>{}), this->tolerance);
    EXPECT_LE(distance(inverse(C) * C, SE3<TypeParam>{}), this->tolerance);
    const auto p = this->random.vector();
    EXPECT_LE(distance((A * B) * p, A * (B * p)), this->tolerance);
  }
}

TYPED_TEST(Group, ExpSE3OfAnyAngleIsARigidMotion) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const SE3<T> C = exp(Screw<T>{this->random.rotation_vector(T(0), T(20)), this->random.vector()});
    EXPECT_LE(distance(C.R * transpose(C.R), SO3<T>{}), this->tolerance);
    EXPECT_NEAR(dot(C.R.x, cross(C.R.y, C.R.z)), T(1), this->tolerance);
  }
}

TYPED_TEST(Group, LogSE3InvertsExp) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Screw<T> X{this->random.rotation_vector(T(0), T(0.999) * this->pi), this->random.vector(T(5))};
    EXPECT_LE(relative_error(log(exp(X)), X), this->tolerance) << "angle " << norm(X.w);
  }
}

TYPED_TEST(Group, LogSO3KeepsSmallRotationsToFullRelativeAccuracy) {
  using T = TypeParam;
  for (T angle = T(1); angle > T(1e-12); angle = angle * T(0.3)) {
    const Vec3<T> xi = angle * this->random.direction();
    EXPECT_LE(relative_error(log_SO3(exp_SO3(xi)), xi), this->tolerance) << "angle " << angle;
    EXPECT_LE(relative_error(log_quaternion(exp_quaternion(xi)), xi), this->tolerance) << "angle " << angle;
  }
}

TYPED_TEST(Group, ExpInvertsLogUpToHalfATurn) {
  using T = TypeParam;
  for (T gap = T(1); gap > std::numeric_limits<T>::epsilon(); gap = gap * T(0.3)) {
    const Vec3<T> xi = (this->pi - gap) * this->random.direction();
    const SE3<T> C = exp(Screw<T>{xi, this->random.vector()});
    EXPECT_LE(relative_error(exp(log(C)), C), this->tolerance) << "angle pi - " << gap;
    EXPECT_LE(relative_error(log_SO3(C.R), xi), this->tolerance) << "angle pi - " << gap;
  }
}

TYPED_TEST(Group, LogOfHalfATurnRecoversTheAxis) {
  using T = TypeParam;
  for (const Vec3<T>& e : {Vec3<T>{1, 0, 0}, Vec3<T>{0, 1, 0}, Vec3<T>{0, 0, 1}, this->random.direction()}) {
    SO3<T> R{{2 * e.x * e.x - 1, 2 * e.x * e.y, 2 * e.x * e.z},  // 2 e eᵀ - I, exactly half a turn
             {2 * e.y * e.x, 2 * e.y * e.y - 1, 2 * e.y * e.z},
             {2 * e.z * e.x, 2 * e.z * e.y, 2 * e.z * e.z - 1}};
    const Vec3<T> xi = log_SO3(R);
    EXPECT_NEAR(norm(xi), this->pi, this->tolerance);
    EXPECT_LE(std::min(distance(xi, this->pi * e), distance(xi, -this->pi * e)), this->tolerance);
  }
}

TYPED_TEST(Group, LogOfALongRotationIsThePrincipalOne) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Vec3<T> e = this->random.direction();
    const T angle = this->random.number(T(1.001) * this->pi, T(1.999) * this->pi);
    EXPECT_LE(distance(log_SO3(exp_SO3(angle * e)), (angle - 2 * this->pi) * e), this->tolerance);
  }
}

TYPED_TEST(Group, QuaternionsCoverRotationsTwice) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Vec3<T> xi = this->random.rotation_vector(T(0), T(3.1)),
                  eta = this->random.rotation_vector(T(0), T(3.1));
    const Quaternion<T> a = exp_quaternion(xi), b = exp_quaternion(eta), minus_a{-a.x, -a.y, -a.z, -a.w};
    EXPECT_NEAR(norm(a), T(1), this->tolerance);
    EXPECT_LE(distance(rotation(a), exp_SO3(xi)), this->tolerance);
    EXPECT_LE(distance(rotation(minus_a), exp_SO3(xi)), this->tolerance);
    EXPECT_LE(distance(rotation(a * b), exp_SO3(xi) * exp_SO3(eta)), this->tolerance);
    EXPECT_LE(distance(rotation(conjugate(a)), transpose(exp_SO3(xi))), this->tolerance);
    EXPECT_LE(distance(quaternion(rotation(a)), a), this->tolerance);  // both with w >= 0
    EXPECT_LE(distance(log_quaternion(a), xi), this->tolerance);
    EXPECT_LE(distance(log_quaternion(minus_a), xi), this->tolerance);
  }
}

TYPED_TEST(Group, AdIsAHomomorphism) {
  for (int k = 0; k < this->samples; ++k) {
    const auto A = this->random.pose(), B = this->random.pose();
    const auto X = this->random.screw();
    EXPECT_LE(relative_error(Ad(A * B, X), Ad(A, Ad(B, X))), this->tolerance);
    EXPECT_LE(relative_error(Ad(inverse(A), X), Ad_inv(A, X)), this->tolerance);
    EXPECT_LE(relative_error(Ad_inv(A, Ad(A, X)), X), this->tolerance);
    EXPECT_LE(relative_error(Ad(A, X), Ad(A.r, Ad(A.R, X))), this->tolerance);
  }
}

TYPED_TEST(Group, AdIsConjugationOfTheMatrix) {
  for (int k = 0; k < this->samples; ++k) {
    const auto C = this->random.pose();
    const auto X = this->random.screw();
    const auto conjugated = from_hat(to_eigen(C) * hat(X) * to_eigen(inverse(C)));
    EXPECT_LE(relative_error(Ad(C, X), conjugated), this->tolerance);
    EXPECT_LE(distance(exp(Ad(C, X)), C * exp(X) * inverse(C)), this->tolerance * 4);
  }
}

TYPED_TEST(Group, AdPreservesTheBracketAndTheReciprocalProduct) {
  for (int k = 0; k < this->samples; ++k) {
    const auto C = this->random.pose();
    const auto X = this->random.screw(), Z = this->random.screw();
    EXPECT_LE(distance(Ad(C, ad(X, Z)), ad(Ad(C, X), Ad(C, Z))), this->tolerance);
    EXPECT_NEAR(reciprocal_product(Ad(C, X), Ad(C, Z)), reciprocal_product(X, Z), this->tolerance);
  }
}

TYPED_TEST(Group, AdOfExpIsTheSeriesOfAd) {
  using T = TypeParam;
  for (int k = 0; k < 50; ++k) {
    const Screw<T> X = this->random.screw();
    Matrix6<T> power = Matrix6<T>::Identity(), series = power;
    for (int n = 1; n < 40; ++n) {
      power = power * ad_matrix(X) / T(n);
      series += power;
    }
    EXPECT_LE((Ad_matrix(exp(X)) - series).norm() / series.norm(), this->tolerance);
  }
}

TYPED_TEST(Group, BracketIsTheCommutator) {
  for (int k = 0; k < this->samples; ++k) {
    const auto X = this->random.screw(), Z = this->random.screw();
    EXPECT_LE(distance(ad(X, Z), from_hat(hat(X) * hat(Z) - hat(Z) * hat(X))), this->tolerance);
    EXPECT_LE(distance(ad(X, Z), -ad(Z, X)), this->tolerance);
  }
}

TYPED_TEST(Group, JacobiIdentity) {
  for (int k = 0; k < this->samples; ++k) {
    const auto X = this->random.screw(), Y = this->random.screw(), Z = this->random.screw();
    const auto sum = ad(X, ad(Y, Z)) + ad(Y, ad(Z, X)) + ad(Z, ad(X, Y));
    EXPECT_LE(to_eigen(sum).norm(), this->tolerance);
  }
}

TYPED_TEST(Group, DexpIsTheRightTrivialisedDerivativeOfExp) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Screw<T> X{this->random.rotation_vector(T(0), T(6)), this->random.vector()},
        U = this->random.screw();
    const Screw<T> tangent = right_trivialised(slope(exp(line(X, U))), exp(X));
    EXPECT_LE(relative_error(dexp(X, U), tangent), this->tolerance);
    EXPECT_LE(relative_error(dexp(X.w, U.w), tangent.w), this->tolerance);
  }
}

TYPED_TEST(Group, DexpInverseInvertsDexp) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Screw<T> X{this->random.rotation_vector(T(0), T(4)), this->random.vector()},
        Z = this->random.screw();
    EXPECT_LE(relative_error(dexp_inv(X, dexp(X, Z)), Z), this->tolerance);
    EXPECT_LE(relative_error(dexp(X, dexp_inv(X, Z)), Z), this->tolerance);
    EXPECT_LE(relative_error(dexp_inv(X.w, dexp(X.w, Z.w)), Z.w), this->tolerance);
  }
}

TYPED_TEST(Group, AdOfExpTakesLeftToRightTrivialisedDerivatives) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Screw<T> X{this->random.rotation_vector(T(0), T(6)), this->random.vector()},
        Z = this->random.screw();
    EXPECT_LE(relative_error(Ad(exp(X), dexp(-X, Z)), dexp(X, Z)), this->tolerance);
  }
}

TYPED_TEST(Group, DirectionalDerivativesOfDexpAreThoseOfItsTaylorSeries) {
  using T = TypeParam;
  for (int k = 0; k < this->samples; ++k) {
    const Screw<T> X{this->random.rotation_vector(T(0), T(4)), this->random.vector()};
    const Screw<T> U = this->random.screw(), Z = this->random.screw(), zero{};
    const T d = distance(ddexp(X, U, Z), slope(dexp(line(X, U), line(Z, zero))));
    const T di = distance(ddexp_inv(X, U, Z), slope(dexp_inv(line(X, U), line(Z, zero))));
    EXPECT_LE(d, this->tolerance);
    EXPECT_LE(di, this->tolerance);
    EXPECT_LE(distance(ddexp(X.w, U.w, Z.w), ddexp(X, U, Z).w), this->tolerance);
    EXPECT_LE(distance(ddexp_inv(X.w, U.w, Z.w), ddexp_inv(X, U, Z).w), this->tolerance);
  }
}

TYPED_TEST(Group, RotationToCarriesTheZAxisByTheShortestWay) {
  using T = TypeParam;
  std::vector<Vec3<T>> directions{{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}};
  for (int k = 0; k < this->samples; ++k) directions.push_back(this->random.direction());
  for (T tilt = T(0.1); tilt > T(1e-15); tilt = tilt * T(0.1)) {
    directions.push_back({sin(tilt), T(0), -cos(tilt)});
    directions.push_back({T(0), -sin(tilt), cos(tilt)});
  }
  for (const Vec3<T>& n : directions) {
    const SO3<T> R = rotation_to(n);
    EXPECT_LE(distance(R.z, n), this->tolerance);
    EXPECT_LE(distance(R * transpose(R), SO3<T>{}), this->tolerance);
    EXPECT_GT(dot(R.x, cross(R.y, R.z)), T(0));
    EXPECT_NEAR(R.x.y, R.y.x, this->tolerance);  // the axis lies in the x-y plane: no turn about z
  }
}

}  // namespace
}  // namespace axode::test
