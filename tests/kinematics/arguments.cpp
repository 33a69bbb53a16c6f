#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// Wrong arguments of the kinematics are refused; numbers that are none pass through.
namespace axode::test {
namespace {

template <class C> class KinematicsArguments : public testing::Test {
 protected:
  using Real = typename C::T;
  using Rep = typename C::Rep;
  Model model = shoulder();
  Workspace<Real> workspace{model};
  std::vector<Real> q{0, 0, 0, 1, 0}, zero{0, 0, 0, 0};
  std::vector<SE3<Real>> C_f = std::vector<SE3<Real>>(3);
  std::vector<Twist<Rep, Real>> V = std::vector<Twist<Rep, Real>>(3);
  std::vector<TwistRate<Rep, Real>> dV = std::vector<TwistRate<Rep, Real>>(3);

  void find_poses() { poses<Real>(model, workspace, q, C_f); }
  void find_twists(const std::vector<Real>& v) { twists<Rep>(model, workspace, q, v, V); }
  void find_accelerations(const std::vector<Real>& v, const std::vector<Real>& a) {
    accelerations<Rep>(model, workspace, q, v, a, dV);
  }
  void find_center_of_mass() { center_of_mass<Real>(model, workspace, q); }
};
TYPED_TEST_SUITE(KinematicsArguments, Cases, CaseNames);

TYPED_TEST(KinematicsArguments, OfTheWrongSizeAreNamed) {
  const std::vector<typename TypeParam::T> good(4), bad(6);
  EXPECT_THAT([&] { this->find_twists(bad); }, refused("v", 6, "nv", 4));
  EXPECT_THAT([&] { this->find_accelerations(bad, good); }, refused("v", 6, "nv", 4));
  EXPECT_THAT([&] { this->find_accelerations(good, bad); }, refused("a", 6, "nv", 4));
  this->C_f.resize(2), this->V.resize(4), this->dV.resize(1);
  EXPECT_THAT([&] { this->find_poses(); }, refused("C", 2, "n_frames", 3));
  EXPECT_THAT([&] { this->find_twists(good); }, refused("V", 4, "n_frames", 3));
  EXPECT_THAT([&] { this->find_accelerations(good, good); }, refused("dV", 1, "n_frames", 3));
  this->C_f.resize(3), this->V.resize(3), this->dV.resize(3);
  this->q.pop_back();
  EXPECT_THAT([&] { this->find_poses(); }, refused("q", 4, "nq", 5));
  EXPECT_THAT([&] { this->find_twists(good); }, refused("q", 4, "nq", 5));
  EXPECT_THAT([&] { this->find_accelerations(good, good); }, refused("q", 4, "nq", 5));
  EXPECT_THAT([&] { this->find_center_of_mass(); }, refused("q", 4, "nq", 5));
}

TYPED_TEST(KinematicsArguments, AWorkspaceOfASmallerModelIsRefused) {
  this->workspace = Workspace<typename TypeParam::T>(one_body());
  const auto too_small = refused_workspace(1, 2);
  EXPECT_THAT([&] { this->find_poses(); }, too_small);
  EXPECT_THAT([&] { this->find_twists(this->zero); }, too_small);
  EXPECT_THAT([&] { this->find_accelerations(this->zero, this->zero); }, too_small);
  EXPECT_THAT([&] { this->find_center_of_mass(); }, too_small);
}

TYPED_TEST(KinematicsArguments, QuaternionsAreNotNormalisedInSilence) {
  using T = typename TypeParam::T;
  const T allowed = std::same_as<T, double> ? T(5e-7) : T(5e-5);
  this->q[3] = 1 + allowed;
  EXPECT_NO_THROW(this->find_poses());
  for (const T w : {1 + 4 * allowed, T(2), T(0), std::numeric_limits<T>::quiet_NaN()}) {
    this->q[3] = w;
    EXPECT_THAT([&] { this->find_poses(); }, refused_quaternion("ball"));
    EXPECT_THAT([&] { this->find_twists(this->zero); }, refused_quaternion("ball"));
    EXPECT_THAT([&] { this->find_accelerations(this->zero, this->zero); }, refused_quaternion("ball"));
    EXPECT_THAT([&] { this->find_center_of_mass(); }, refused_quaternion("ball"));
  }
}

TYPED_TEST(KinematicsArguments, WhatIsNotANumberPassesThrough) {
  using T = typename TypeParam::T;
  const T nan = std::numeric_limits<T>::quiet_NaN();
  this->q[4] = nan;  // the elbow
  EXPECT_NO_THROW(this->find_poses());
  EXPECT_FALSE(std::isnan(largest(entries(this->C_f[1]))));
  EXPECT_TRUE(std::isnan(largest(entries(this->C_f[2]))));
  this->q[4] = 0;
  std::vector<T> v = this->zero, a = this->zero;
  v[3] = nan;
  EXPECT_NO_THROW(this->find_twists(v));
  EXPECT_FALSE(std::isnan(largest(entries(this->V[1]))));
  EXPECT_TRUE(std::isnan(largest(entries(this->V[2]))));
  a[3] = nan;
  EXPECT_NO_THROW(this->find_accelerations(this->zero, a));
  EXPECT_FALSE(std::isnan(largest(entries(this->dV[1]))));
  EXPECT_TRUE(std::isnan(largest(entries(this->dV[2]))));
}

}  // namespace
}  // namespace axode::test
