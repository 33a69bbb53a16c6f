#include "axode/eigen.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <span>
#include <stdexcept>

#include "tests/lie/random_quantities.hpp"
#include "tests/lie/relative_error.hpp"

/// Conversions between the quantities and Eigen's types: both ways, structure, and order of components.
namespace axode::test {
namespace {

template <class Quantity> void expect_round_trip(const Quantity& x) {
  const auto matrix = to_eigen(x);
  EXPECT_EQ(matrix, to_eigen(from_eigen<Quantity>(matrix)));
  const Eigen::MatrixXd dynamic = matrix;
  EXPECT_EQ(matrix, to_eigen(from_eigen<Quantity>(dynamic)));
}

TEST(EigenAdaptors, ThereAndBackChangesNoBit) {
  Random<double> random;
  expect_round_trip(random.vector());
  expect_round_trip(random.tensor());
  expect_round_trip(random.rotation());
  expect_round_trip(random.pose());
  expect_round_trip(exp_quaternion(random.vector()));
  expect_round_trip(random.screw());
  expect_round_trip(random.any<Twist<Hybrid>>());
  expect_round_trip(random.any<TwistRate<Mixed>>());
  expect_round_trip(random.any<Wrench<Spatial>>());
  expect_round_trip(random.any<Momentum<BodyFixed>>());
  expect_round_trip(random.inertia());
}

TEST(EigenAdaptors, ProductsAreMatrixProducts) {
  Random<double> random;
  for (int k = 0; k < 100; ++k) {
    const SE3<> A = random.pose(), B = random.pose();
    const Vec3<> a = random.vector(), b = random.vector();
    const Sym3<> S = random.tensor();
    EXPECT_LE((to_eigen(A * B) - to_eigen(A) * to_eigen(B)).norm(), 1e-14);
    EXPECT_LE((to_eigen(inverse(A)) * to_eigen(A) - Eigen::Matrix4d::Identity()).norm(), 1e-14);
    EXPECT_LE((to_eigen(A.R * a) - to_eigen(A.R) * to_eigen(a)).norm(), 1e-15);
    EXPECT_LE((to_eigen(A * a) - (to_eigen(A) * to_eigen(a).homogeneous()).head<3>()).norm(), 1e-15);
    EXPECT_LE((to_eigen(S * a) - to_eigen(S) * to_eigen(a)).norm(), 1e-15);
    EXPECT_LE((to_eigen(cross(a, b)) - skew(a) * to_eigen(b)).norm(), 1e-15);
    EXPECT_LE((to_eigen(rotate(A.R, S)) - to_eigen(A.R) * to_eigen(S) * to_eigen(A.R).transpose()).norm(),
              1e-14);
    const Eigen::Matrix3d parallel = -skew(a) * skew(b) - skew(b) * skew(a);
    EXPECT_LE((to_eigen(parallel_axis_tensor(a, b)) - parallel).norm(), 1e-15);
  }
}

TEST(EigenAdaptors, QuaternionsAreThoseOfEigen) {
  Random<double> random;
  for (int k = 0; k < 100; ++k) {
    const Quaternion<> a = exp_quaternion(random.vector()), b = exp_quaternion(random.vector());
    const Eigen::Quaterniond A(to_eigen(a)), B(to_eigen(b));
    EXPECT_LE((to_eigen(a * b) - (A * B).coeffs()).norm(), 1e-15);
    EXPECT_LE((to_eigen(rotation(a)) - A.toRotationMatrix()).norm(), 1e-15);
  }
}

TEST(EigenAdaptors, InertiaMatrixHasTheBlocksOfThePaper) {
  const Inertia<> M{2, {3, 4, 5}, {10, 11, 12, 0.1, 0.2, 0.3}};
  const Matrix6<double> matrix = to_eigen(M);
  EXPECT_EQ(matrix, matrix.transpose());
  EXPECT_EQ((matrix.topLeftCorner<3, 3>()), to_eigen(M.Theta));
  EXPECT_EQ((matrix.topRightCorner<3, 3>()), skew(M.h));
  EXPECT_EQ((matrix.bottomRightCorner<3, 3>()), 2 * Eigen::Matrix3d::Identity());
}

TEST(EigenAdaptors, SkewAndHatComeBack) {
  Random<double> random;
  const Screw<> X = random.screw();
  EXPECT_EQ(to_eigen(from_skew(skew(X.w))), to_eigen(X.w));
  EXPECT_EQ(to_eigen(from_hat(hat(X))), to_eigen(X));
  EXPECT_EQ(skew(X.w), -skew(X.w).transpose());
  EXPECT_EQ((hat(X).row(3)), (Eigen::RowVector4d::Zero()));
}

TEST(EigenAdaptors, MatricesOfMapsActLikeTheMaps) {
  Random<double> random;
  for (int k = 0; k < 50; ++k) {
    const SE3<> C = random.pose();
    const Screw<> X = random.screw(), U = random.screw(), Z = random.screw();
    const auto z = to_eigen(Z);
    EXPECT_LE((Ad_matrix(C) * z - to_eigen(Ad(C, Z))).norm(), 1e-14);
    EXPECT_LE((Ad_matrix(C) - Ad_matrix(C.r) * Ad_matrix(C.R)).norm(), 1e-14);  // eq. AdRr
    EXPECT_LE((ad_matrix(X) * z - to_eigen(ad(X, Z))).norm(), 1e-14);
    EXPECT_LE((dexp_matrix(X) * z - to_eigen(dexp(X, Z))).norm(), 1e-14);
    EXPECT_LE((dexp_inv_matrix(X) * dexp_matrix(X) - Matrix6<double>::Identity()).norm(), 1e-13);
    EXPECT_LE((ddexp_matrix(X, U) * z - to_eigen(ddexp(X, U, Z))).norm(), 1e-14);
    const Matrix6<double> from_inverse = -dexp_inv_matrix(X) * ddexp_matrix(X, U) * dexp_inv_matrix(X);
    EXPECT_LE((ddexp_inv_matrix(X, U) - from_inverse).norm(), 1e-13);
    EXPECT_LE((dexp_inv_matrix(X.w) * dexp_matrix(X.w) - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    const Eigen::Matrix3d from_inverse3 =
        -dexp_inv_matrix(X.w) * ddexp_matrix(X.w, U.w) * dexp_inv_matrix(X.w);
    EXPECT_LE((ddexp_inv_matrix(X.w, U.w) - from_inverse3).norm(), 1e-14);
    EXPECT_LE((ad_matrix(X).topLeftCorner<3, 3>() - skew(X.w)).norm(), 0.0);  // eq. adse3
    EXPECT_LE((ad_matrix(X).bottomLeftCorner<3, 3>() - skew(X.v)).norm(), 0.0);
    EXPECT_LE((ad_matrix(X).topRightCorner<3, 3>()).norm(), 0.0);
  }
}

TEST(EigenAdaptors, LinearFirstIsTheOrderOfOtherLibraries) {
  const Twist<BodyFixed> V{{1, 2, 3}, {4, 5, 6}};
  const Vector6<double> other{4, 5, 6, 1, 2, 3};
  EXPECT_EQ(linear_first(V), other);
  EXPECT_EQ(to_eigen(from_linear_first<Twist<BodyFixed>>(other)), to_eigen(V));
  EXPECT_EQ(linear_first(Screw<>{V.w, V.v}), other);
  EXPECT_EQ(linear_first(Wrench<Hybrid>{V.w, V.v}), other);
  EXPECT_EQ(exchange_halves(exchange_halves(other)), other);
  const Eigen::MatrixXd jacobian = Eigen::MatrixXd::Random(6, 9);
  EXPECT_EQ(exchange_halves(jacobian).topRows(3), jacobian.bottomRows(3));
  EXPECT_EQ(exchange_halves(jacobian).bottomRows(3), jacobian.topRows(3));
  Random<double> random;
  const Inertia<> M = random.inertia();
  EXPECT_LE((linear_first(M) * linear_first(V) - linear_first(M * V)).norm(), 1e-14);
}

TEST(EigenAdaptors, ScalarFirstIsTheOrderOfMuJoCo) {
  const Quaternion<> a{0.1, 0.2, 0.3, 0.9};
  EXPECT_EQ(scalar_first(a), (Eigen::Vector4d{0.9, 0.1, 0.2, 0.3}));
  EXPECT_EQ(to_eigen(from_scalar_first(scalar_first(a))), to_eigen(a));
}

TEST(EigenAdaptors, AnotherShapeIsRefusedByName) {
  const Eigen::VectorXd five = Eigen::VectorXd::Zero(5);
  try {
    from_eigen<Screw<>>(five);
    FAIL() << "a vector of five entries passed for a screw";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "expected an Eigen matrix of shape 6 x 1, got 5 x 1");
  }
  EXPECT_THROW(from_eigen<SE3<>>(Eigen::MatrixXd::Zero(3, 4)), std::invalid_argument);
  EXPECT_THROW(from_linear_first<Twist<Hybrid>>(five), std::invalid_argument);
  EXPECT_THROW(exchange_halves(five), std::invalid_argument);
}

TEST(EigenAdaptors, VectorsAndSpansShareTheirEntries) {
  Eigen::VectorXd q = Eigen::VectorXd::LinSpaced(5, 0, 4);
  const Eigen::VectorXd& constant = q;
  const std::span<double> writable = as_span(q);
  const std::span<const double> readable = as_span(constant), tail = as_span(constant.tail(2));
  writable[3] = 7;
  EXPECT_EQ(readable.data(), q.data());
  EXPECT_EQ(readable.size(), 5u);
  EXPECT_EQ(tail[0], 7);
  as_eigen(writable) *= 2;
  EXPECT_EQ(as_eigen(readable)[3], 14);

  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(2, 3);
  const std::span<double> by_columns = as_span(M);
  EXPECT_EQ(by_columns.size(), 6u);
  by_columns[1] = 5;
  EXPECT_EQ(M(1, 0), 5);
}

}  // namespace
}  // namespace axode::test
