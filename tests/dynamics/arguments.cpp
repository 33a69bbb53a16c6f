#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// Wrong arguments of the dynamics are refused; numbers that are none pass through.
namespace axode::test {
namespace {

template <class C> class DynamicsArguments : public testing::Test {
 protected:
  using Real = typename C::T;
  using Rep = typename C::Rep;
  Model model = shoulder();
  Workspace<Real> workspace{model};
  std::vector<Real> q{0, 0, 0, 1, 0}, v{0, 0, 0, 0}, a{0, 0, 0, 0}, tau{0, 0, 0, 0};
  std::vector<Wrench<Rep, Real>> W = std::vector<Wrench<Rep, Real>>(2);
  std::vector<AppliedWrench<Real>> wrenches;

  void find_torques() { inverse_dynamics<Rep>(model, workspace, q, v, a, tau, {.wrenches = wrenches}); }
  void find_wrenches() { joint_wrenches<Rep>(model, workspace, q, v, a, W, {.wrenches = wrenches}); }
  template <class Matcher> void expect_both(const Matcher& matcher) {
    EXPECT_THAT([&] { find_torques(); }, matcher);
    EXPECT_THAT([&] { find_wrenches(); }, matcher);
  }
};
TYPED_TEST_SUITE(DynamicsArguments, Cases, CaseNames);

TYPED_TEST(DynamicsArguments, OfTheWrongSizeAreNamed) {
  this->q.resize(4);
  this->expect_both(refused("q", 4, "nq", 5));
  this->q = {0, 0, 0, 1, 0};
  this->v.resize(7);
  this->expect_both(refused("v", 7, "nv", 4));
  this->v.resize(4);
  this->a.resize(0);
  this->expect_both(refused("a", 0, "nv", 4));
  this->a.resize(4);
  this->tau.resize(5);
  EXPECT_THAT([&] { this->find_torques(); }, refused("tau", 5, "nv", 4));
  this->W.resize(3);
  EXPECT_THAT([&] { this->find_wrenches(); }, refused("W", 3, "n_bodies", 2));
  this->tau.resize(4), this->W.resize(2);
  EXPECT_NO_THROW(this->find_torques());
  EXPECT_NO_THROW(this->find_wrenches());
}

TYPED_TEST(DynamicsArguments, LoadsOnFramesThatDoNotExistAreRefused) {
  using T = typename TypeParam::T;
  for (const int frame : {-1, 3}) {
    this->wrenches = {AppliedWrench<T>(frame, Wrench<Hybrid, T>{})};
    this->expect_both(testing::ThrowsMessage<std::invalid_argument>(
        testing::AllOf(testing::StartsWith("loads: "), testing::HasSubstr("frame " + std::to_string(frame)),
                       testing::HasSubstr("\"shoulder\" has frames 0 to 2"))));
  }
  this->wrenches = {AppliedWrench<T>(0, Wrench<Hybrid, T>{}), AppliedWrench<T>(2, Wrench<Mixed, T>{})};
  EXPECT_NO_THROW(this->find_torques());
}

TYPED_TEST(DynamicsArguments, AWorkspaceOfASmallerModelIsRefused) {
  this->workspace = Workspace<typename TypeParam::T>(one_body());
  this->expect_both(refused_workspace(1, 2));
}

TYPED_TEST(DynamicsArguments, QuaternionsAreNotNormalisedInSilence) {
  using T = typename TypeParam::T;
  for (const T w : {T(0.999), T(0), std::numeric_limits<T>::quiet_NaN()}) {
    this->q[3] = w;
    this->expect_both(refused_quaternion("ball"));
  }
}

TYPED_TEST(DynamicsArguments, WhatIsNotANumberPassesThrough) {
  using T = typename TypeParam::T;
  const T nan = std::numeric_limits<T>::quiet_NaN();
  for (std::vector<T>* argument : {&this->q, &this->v, &this->a}) {
    T& last = argument->back();  // of the elbow
    last = nan;
    EXPECT_NO_THROW(this->find_torques());
    EXPECT_TRUE(std::isnan(largest(entries(this->tau))));
    EXPECT_NO_THROW(this->find_wrenches());
    EXPECT_TRUE(std::isnan(largest(entries(this->W))));
    last = 0;
  }
  this->wrenches = {AppliedWrench<T>(2, Wrench<Hybrid, T>{{nan, 0, 0}, {}})};
  EXPECT_NO_THROW(this->find_torques());
  EXPECT_TRUE(std::isnan(largest(entries(this->tau))));
}

}  // namespace
}  // namespace axode::test
