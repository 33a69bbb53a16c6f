#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// Wrong arguments of the kinematics are refused; numbers that are none pass through.
namespace axode::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

class KinematicsArguments : public Law {
 protected:
  const Model model = shoulder();
  std::unique_ptr<Subject> subject = test::subject(GetParam(), model);
  Ask ask{.q = {0, 0, 0, 1, 0}, .v = {0, 0, 0, 0}, .a = {0, 0, 0, 0}};

  /// Of frames, with memory for so many.
  std::vector<SE3<>> poses(std::size_t n = 3) {
    return poses_of(subject->call("poses", ask, 12 * n).numbers);
  }
  std::vector<Six> twists(std::size_t n = 3) { return sixes_of(subject->call("twists", ask, 6 * n).numbers); }
  std::vector<Six> accelerations(std::size_t n = 3) {
    return sixes_of(subject->call("accelerations", ask, 6 * n).numbers);
  }
  void expect_poses(const Refusal& refusal, std::size_t n = 3) {
    EXPECT_THAT([&] { poses(n); }, refusal);
  }
  void expect_twists(const Refusal& refusal, std::size_t n = 3) {
    EXPECT_THAT([&] { twists(n); }, refusal);
  }
  void expect_accelerations(const Refusal& refusal, std::size_t n = 3) {
    EXPECT_THAT([&] { accelerations(n); }, refusal);
  }
  void expect_all(const Refusal& refusal) {
    expect_poses(refusal), expect_twists(refusal), expect_accelerations(refusal);
    EXPECT_THAT([&] { subject->call("center_of_mass", ask); }, refusal);
  }
};
INSTANTIATE_TEST_SUITE_P(Kinematics, KinematicsArguments, testing::ValuesIn(cases()), name_of);

TEST_P(KinematicsArguments, OfTheWrongSizeAreNamed) {
  ask.v.resize(6);
  expect_twists(refused("v", 6, "nv", 4));
  expect_accelerations(refused("v", 6, "nv", 4));
  ask.v.resize(4), ask.a.resize(6);
  expect_accelerations(refused("a", 6, "nv", 4));
  ask.a.resize(4);
  expect_poses(refused("C", 2, "n_frames", 3), 2);
  expect_twists(refused("V", 4, "n_frames", 3), 4);
  expect_accelerations(refused("V'", 1, "n_frames", 3), 1);
  ask.q.pop_back();
  expect_all(refused("q", 4, "nq", 5));
}

TEST_P(KinematicsArguments, AWorkspaceOfASmallerModelIsRefused) {
  subject = test::subject(GetParam(), model, one_body());
  expect_all(refused_workspace(1, 2));
}

TEST_P(KinematicsArguments, QuaternionsAreNotNormalisedInSilence) {
  const double allowed = GetParam().single ? 5e-5 : 5e-7;
  ask.q[3] = 1 + allowed;
  EXPECT_NO_THROW(poses());
  for (const double w : {1 + 4 * allowed, 2.0, 0.0, nan}) {
    ask.q[3] = w;
    expect_all(refused_quaternion("ball"));
  }
}

/// Of the two bodies, only the forearm has numbers that are none.
template <class Quantity> void expect_nan_in_the_forearm(const std::vector<Quantity>& frames) {
  EXPECT_FALSE(std::isnan(largest(entries(frames[1]))));
  EXPECT_TRUE(std::isnan(largest(entries(frames[2]))));
}

TEST_P(KinematicsArguments, WhatIsNotANumberPassesThrough) {
  ask.q[4] = nan;  // the elbow
  expect_nan_in_the_forearm(poses());
  ask.q[4] = 0, ask.v[3] = nan;
  expect_nan_in_the_forearm(twists());
  ask.v[3] = 0, ask.a[3] = nan;
  expect_nan_in_the_forearm(accelerations());
}

}  // namespace
}  // namespace axode::test
