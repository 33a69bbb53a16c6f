#include "axode/model/configuration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "axode/kinematics.hpp"
#include "tests/model/random_mechanism.hpp"

/// The configuration manifold: its laws on every kind of joint.
namespace axode::test {
namespace {

using std::numbers::pi;
using testing::ElementsAre;
using testing::ThrowsMessage;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A model of one body that is connected to the ground by one joint, with limits for each degree of freedom.
Model one_joint(JointKind kind, std::vector<Dof> dof = {}) {
  return ModelBuilder("single")
      .add({.name = "b",
            .joint = {.name = "j",
                      .kind = kind,
                      .pitch = traits(kind).has("pitch") ? 0.1 : 0,
                      .dof = std::move(dof)},
            .inertia = MassProperties{.mass = 1}})
      .build();
}
Model any_model(std::uint64_t seed) {
  Random<double> random(seed);
  return ModelBuilder(random_tree(random, 10, moving_kinds)).build();
}
/// The largest distance between the poses of any frame in two configurations.
double motion_between(const Model& model, const std::vector<double>& q0, const std::vector<double>& q1) {
  const std::vector<SE3<>> C0 = poses_of(model, q0), C1 = poses_of(model, q1);
  double largest = 0;
  for (std::size_t f = 0; f < C0.size(); ++f) largest = std::max(largest, distance(C0[f], C1[f]));
  return largest;
}
std::vector<double> scaled(double s, std::vector<double> x) {
  for (double& value : x) value *= s;
  return x;
}
/// A tangent vector whose rotation part turns each spherical, planar or free joint by less than the angle.
std::vector<double> random_step(Random<double>& random, const Model& model, double angle) {
  std::vector<double> dv = random_numbers(random, model.nv(), 2);
  for (const Joint& joint : model.joints()) {
    if (joint.kind == Subgroup::planar) dv[joint.iv] = random.number(-angle, angle);
    if (joint.kind != Subgroup::spherical && joint.kind != Subgroup::free) continue;
    const Vec3<> turn = random.rotation_vector(0, angle);
    dv[joint.iv] = turn.x, dv[joint.iv + 1] = turn.y, dv[joint.iv + 2] = turn.z;
  }
  return dv;
}

// --------------------------------------------------------------------------------------------------- neutral

TEST(Configuration, NeutralIsTheDrawing) {
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    const Model model = any_model(seed);
    const std::vector<SE3<>> C = poses_of(model, neutral(model));
    for (int i = 1; i <= model.n_bodies(); ++i) EXPECT_LE(distance(C[i], model.body(i).A), 1e-12);
  }
  EXPECT_THAT(neutral(one_joint(JointKind::free)), ElementsAre(0, 0, 0, 1, 0, 0, 0));
  EXPECT_THAT(neutral(one_joint(JointKind::spherical)), ElementsAre(0, 0, 0, 1));
  EXPECT_THAT(neutral(one_joint(JointKind::planar)), ElementsAre(0, 0, 0));
  EXPECT_THAT(neutral(one_joint(JointKind::revolute, {{.lower = 1, .upper = 2}})), ElementsAre(0))
      << "whatever the limits are";
}

// ---------------------------------------------------------------------------------- integrate and difference

TEST(Configuration, DifferenceIsTheInverseOfIntegrate) {
  Random<double> random(51);
  for (const JointKind kind : moving_kinds) {
    const Model model = one_joint(kind);
    for (int trial = 0; trial < 300; ++trial) {
      const std::vector<double> q = random_configuration(model, static_cast<std::uint64_t>(trial));
      const std::vector<double> dv = random_step(random, model, trial % 3 == 0 ? 1e-9 : 3.141);
      const std::vector<double> again = difference(model, q, integrate(model, q, dv));
      EXPECT_LE(distance(again, dv), 2e-12) << to_string(kind);
    }
  }
}

TEST(Configuration, IntegrateLeadsToTheOtherConfiguration) {
  for (std::uint64_t seed = 1; seed < 100; ++seed) {
    const Model model = any_model(seed);
    const std::vector<double> q0 = random_configuration(model, seed),
                              q1 = random_configuration(model, 1000 + seed);
    const std::vector<double> there = integrate(model, q0, difference(model, q0, q1));
    EXPECT_LE(motion_between(model, there, q1), 1e-11);
    EXPECT_LE(size(difference(model, there, q1)), 1e-12);
  }
}

TEST(Configuration, NoStepIsNoMotion) {
  for (std::uint64_t seed = 1; seed < 30; ++seed) {
    const Model model = any_model(seed);
    const std::vector<double> q = random_configuration(model, seed);
    EXPECT_LE(distance(integrate(model, q, std::vector<double>(model.nv())), q), 1e-15);
    EXPECT_LE(size(difference(model, q, q)), 1e-15);
  }
}

TEST(Configuration, StepsAlongOneScrewAddUp) {
  Random<double> random(52);
  for (std::uint64_t seed = 1; seed < 50; ++seed) {
    const Model model = any_model(seed);
    const std::vector<double> q = random_configuration(model, seed), dv = random_step(random, model, 3);
    const std::vector<double> once = integrate(model, q, scaled(5, dv));  // rotates by much more than π
    const std::vector<double> twice = integrate(model, integrate(model, q, scaled(2, dv)), scaled(3, dv));
    EXPECT_LE(motion_between(model, once, twice), 1e-11);
    EXPECT_LE(motion_between(model, integrate(model, once, scaled(-5, dv)), q), 1e-11) << "and back";
  }
}

TEST(Configuration, StepsAreLeftTrivialised) {
  Random<double> random(53);
  for (const JointKind kind : moving_kinds) {
    if (kind == JointKind::cylindrical || kind == JointKind::universal)
      continue;  // the library splits these into
                 // two joints
    const Model model = one_joint(kind);
    const Body& body = model.body(1);
    for (int trial = 0; trial < 100; ++trial) {
      const std::vector<double> q = random_configuration(model, static_cast<std::uint64_t>(trial));
      const std::vector<double> dv = random_step(random, model, 3);
      Screw<> X{};
      for (int k = 0; k < model.nv(); ++k) X = X + dv[k] * body.X[k];
      const SE3<> C = poses_of(model, q)[1];
      EXPECT_LE(distance(poses_of(model, integrate(model, q, dv))[1], C * exp(X)), 2e-13)
          << to_string(kind) << ": C(q ⊕ dv) = C(q) exp(X dv)";
    }
  }
}

TEST(Configuration, VelocityIsTheRateOfTheDifference) {
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    Random<double> random(seed);
    const Model model = any_model(seed);
    const std::vector<double> q = random_configuration(model, seed), v = random_numbers(random, model.nv());
    Workspace<double> workspace(model);
    std::vector<Twist<BodyFixed>> V(model.n_frames());
    twists<BodyFixed>(model, workspace, q, v, V);
    const double h = 1e-5;
    const std::vector<SE3<>> C0 = poses_of(model, integrate(model, q, scaled(-h, v))),
                             C1 = poses_of(model, integrate(model, q, scaled(h, v)));
    for (int f = 0; f < model.n_frames(); ++f) {
      const Screw<> step = log(inverse(C0[f]) * C1[f]);
      EXPECT_LE(distance((0.5 / h) * step, screw(V[f])), 2e-7 * (1 + to_eigen(V[f]).norm()));
    }
  }
}

TEST(Configuration, DifferencesTakeTheShorterWayRound) {
  const Model plane = one_joint(JointKind::planar);
  EXPECT_NEAR(difference(plane, std::vector{3.0, 0., 0.}, std::vector{-3.0, 0., 0.})[0], 2 * pi - 6, 1e-14);
  EXPECT_NEAR(difference(plane, std::vector{0.1, 0., 0.}, std::vector{0.1 + 8 * pi, 0., 0.})[0], 0, 1e-14);
  EXPECT_NEAR(difference(plane, std::vector{-50.0, 1., 2.}, std::vector{50.0, 3., 4.})[0],
              std::remainder(100.0, 2 * pi), 1e-13);
  const Model hinge = one_joint(JointKind::revolute);
  EXPECT_EQ(difference(hinge, std::vector{3.0}, std::vector{-3.0})[0], -6)
      << "a coordinate of its own has no way round";
  const Model ball = one_joint(JointKind::spherical);
  for (const double angle : {0.1, 3.0, 3.2, 6.2}) {
    const std::vector<double> q{0, 0, std::sin(angle / 2), std::cos(angle / 2)};
    EXPECT_NEAR(difference(ball, neutral(ball), q)[2], std::remainder(angle, 2 * pi), 1e-14) << angle;
  }
}

TEST(Configuration, AQuaternionAndItsNegativeAreOneRotation) {
  for (const JointKind kind : {JointKind::spherical, JointKind::free}) {
    const Model model = one_joint(kind);
    for (std::uint64_t seed = 1; seed < 200; ++seed) {
      const std::vector<double> q = random_configuration(model, seed),
                                p = random_configuration(model, 500 + seed);
      std::vector<double> negative = q;
      for (int k = 0; k < 4; ++k) negative[k] = -q[k];
      EXPECT_LE(size(difference(model, q, negative)), 1e-14);
      EXPECT_LE(distance(difference(model, p, negative), difference(model, p, q)), 1e-12);
      EXPECT_LE(distance(difference(model, negative, p), difference(model, q, p)), 1e-12);
    }
  }
}

TEST(Configuration, QuaternionsStayUnit) {
  Random<double> random(54);
  const Model model = one_joint(JointKind::free);
  std::vector<double> q = neutral(model);
  for (int step = 0; step < 1000; ++step) q = integrate(model, q, random_numbers(random, 6, 3));
  EXPECT_NEAR(std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3])), 1, 1e-12);
  EXPECT_NO_THROW(check_configuration(model, q));
}

TEST(Configuration, InterpolationRunsFromEndToEnd) {
  for (std::uint64_t seed = 1; seed < 50; ++seed) {
    const Model model = any_model(seed);
    const std::vector<double> q0 = random_configuration(model, seed),
                              q1 = random_configuration(model, 1000 + seed);
    EXPECT_LE(distance(interpolate(model, q0, q1, 0), q0), 1e-15);
    EXPECT_LE(motion_between(model, interpolate(model, q0, q1, 1), q1), 1e-11);
    const std::vector<double> half = interpolate(model, q0, q1, 0.5);
    const std::vector<double> to = difference(model, q0, half), from = difference(model, half, q1);
    EXPECT_LE(distance(to, from), 1e-11) << "at constant speed";
    const std::vector<double> backwards = interpolate(model, q1, q0, 0.5);
    EXPECT_LE(motion_between(model, half, backwards), 1e-10) << "and backwards on the same way";
  }
}

TEST(Configuration, CoupledJointsAddNothing) {
  Random<double> random(55);
  Description description;
  description.bodies = {random_body(random, 0, "ground", JointKind::revolute),
                        random_body(random, 1, "b0", JointKind::prismatic)};
  description.bodies[1].joint.coupling = Coupling{"j0", 3, 1};
  description.bodies[1].joint.dof = {{.lower = -0.01, .upper = 0.01}};
  const Model model = ModelBuilder(description).build();
  EXPECT_THAT(neutral(model), ElementsAre(0));
  EXPECT_THAT(integrate(model, std::vector{0.5}, std::vector{0.25}), ElementsAre(0.75));
  EXPECT_THAT(difference(model, std::vector{0.5}, std::vector{0.25}), ElementsAre(-0.25));
  EXPECT_THAT(limits(model).lower, ElementsAre(-infinity)) << "those of the leader";
}

// -------------------------------------------------------------------------------------------- random, limits

std::vector<Dof> six_limits() {
  std::vector<Dof> dof(6);
  for (int d = 0; d < 6; ++d) dof[d].lower = -1 - d, dof[d].upper = 0.5 + d;
  return dof;
}

TEST(Configuration, LimitsStandAtTheCoordinatesTheyBound) {
  const auto of = [](JointKind kind, int n) {
    const std::vector<Dof> all = six_limits();
    return limits(one_joint(kind, {all.begin(), all.begin() + n}));
  };
  EXPECT_THAT(of(JointKind::revolute, 1).lower, ElementsAre(-1));
  EXPECT_THAT(of(JointKind::prismatic, 1).upper, ElementsAre(0.5));
  EXPECT_THAT(of(JointKind::universal, 2).lower, ElementsAre(-1, -2));
  EXPECT_THAT(of(JointKind::planar, 3).upper, ElementsAre(0.5, 1.5, 2.5));
  EXPECT_THAT(of(JointKind::spherical, 3).lower, ElementsAre(-infinity, -infinity, -infinity, -infinity));
  EXPECT_THAT(of(JointKind::spherical, 3).upper, ElementsAre(infinity, infinity, infinity, infinity));
  EXPECT_THAT(of(JointKind::free, 6).lower,
              ElementsAre(-infinity, -infinity, -infinity, -infinity, -4, -5, -6));
  EXPECT_THAT(of(JointKind::free, 6).upper,
              ElementsAre(infinity, infinity, infinity, infinity, 3.5, 4.5, 5.5));
  EXPECT_THAT(limits(one_joint(JointKind::revolute)).lower, ElementsAre(-infinity));
}

TEST(Configuration, ClampGoesToTheNearestWithinTheLimits) {
  const Model model = one_joint(JointKind::free, six_limits());
  EXPECT_THAT(clamp(model, std::vector{0., 0., 0., -1., 9., -9., 0.25}),
              ElementsAre(0, 0, 0, -1, 3.5, -5, 0.25));
  const Model hinge = one_joint(JointKind::revolute, {{.lower = -1, .upper = 2}});
  EXPECT_THAT(clamp(hinge, std::vector{-5.0}), ElementsAre(-1));
  EXPECT_THAT(clamp(hinge, std::vector{1.5}), ElementsAre(1.5));
  EXPECT_THAT(clamp(one_joint(JointKind::revolute), std::vector{100.0}), ElementsAre(100));
  EXPECT_THAT(clamp(one_joint(JointKind::revolute, {{.lower = 0}}), std::vector{-1.0}), ElementsAre(0));
}

TEST(Configuration, RandomIsWithinTheLimitsAndRepeatsWithItsSeed) {
  for (std::uint64_t seed = 1; seed < 200; ++seed) {
    Random<double> random(seed);
    Description tree = random_tree(random, 6, one_dof_kinds);
    for (BodyDescription& body : tree.bodies) {
      const double lower = random.number(-5, 5);
      body.joint.dof = {{.lower = random.number(0, 1) < 0.3 ? -infinity : lower,
                         .upper = random.number(0, 1) < 0.3 ? infinity : lower + random.number(0, 3)}};
    }
    const Model model = ModelBuilder(tree).build();
    const CoordinateLimits limit = limits(model);
    const std::vector<double> q = random_configuration(model, seed);
    for (int k = 0; k < model.nq(); ++k) {
      EXPECT_GE(q[k], limit.lower[k]);
      EXPECT_LE(q[k], limit.upper[k]);
      EXPECT_LE(std::abs(q[k]), 5 + 3 + 2 * pi) << "where one side is open, near the other";
    }
    EXPECT_EQ(random_configuration(model, seed), q);
    EXPECT_NE(random_configuration(model, seed + 1), q);
    EXPECT_EQ(clamp(model, q), q);
  }
}

TEST(Configuration, RandomIsFiniteWithinAnyLimits) {
  const Model model = one_joint(JointKind::prismatic, {{.lower = -1e308, .upper = 1e308}});
  for (std::uint64_t seed = 0; seed < 100; ++seed)
    EXPECT_LE(std::abs(random_configuration(model, seed)[0]), 1e308);
}

/// Counts the samples in ten equal bins. Each of the shares must be a tenth to within six standard
/// deviations.
void expect_uniform(const std::vector<double>& samples, double lower, double upper, const char* what) {
  std::array<int, 10> bins{};
  for (const double x : samples) {
    ASSERT_GE(x, lower);
    ASSERT_LE(x, upper);
    ++bins[std::min(9, static_cast<int>(10 * (x - lower) / (upper - lower)))];
  }
  const double n = static_cast<double>(samples.size());
  for (const int count : bins) EXPECT_NEAR(count, n / 10, 6 * std::sqrt(0.09 * n)) << what;
}

TEST(Configuration, RandomIsUniform) {
  const int n = 20'000;
  const auto coordinate = [&](const Model& model, int k) {
    std::vector<double> samples;
    for (int seed = 0; seed < n; ++seed)
      samples.push_back(random_configuration(model, static_cast<std::uint64_t>(seed))[k]);
    return samples;
  };
  expect_uniform(coordinate(one_joint(JointKind::revolute), 0), -pi, pi, "an angle");
  expect_uniform(coordinate(one_joint(JointKind::helical), 0), -pi, pi, "the angle of a helix");
  expect_uniform(coordinate(one_joint(JointKind::prismatic), 0), -1, 1, "a length");
  expect_uniform(coordinate(one_joint(JointKind::revolute, {{.lower = 2, .upper = 5}}), 0), 2, 5,
                 "within limits");
  expect_uniform(coordinate(one_joint(JointKind::planar), 0), -pi, pi, "the angle in a plane");
  expect_uniform(coordinate(one_joint(JointKind::planar), 2), -1, 1, "a place in a plane");
  expect_uniform(coordinate(one_joint(JointKind::free), 5), -1, 1, "a place in space");
}

TEST(Configuration, RandomRotationsFavourNoDirection) {
  for (const JointKind kind : {JointKind::spherical, JointKind::free}) {
    const Model model = one_joint(kind);
    std::array<std::vector<double>, 9> entries;  // each entry of a uniformly distributed rotation matrix is
                                                 // itself uniformly distributed (Archimedes)
    for (std::uint64_t seed = 0; seed < 20'000; ++seed) {
      const std::vector<double> q = random_configuration(model, seed);
      EXPECT_NO_THROW(check_configuration(model, q));
      const Eigen::Matrix3d R = to_eigen(rotation(Quaternion<>{q[0], q[1], q[2], q[3]}));
      for (int k = 0; k < 9; ++k) entries[k].push_back(std::clamp(R(k), -1.0, 1.0));
    }
    for (const std::vector<double>& entry : entries) expect_uniform(entry, -1, 1, "an entry of the rotation");
  }
}

// --------------------------------------------------------------------------------------------- bad arguments

auto throws(const std::string& message) { return ThrowsMessage<std::invalid_argument>(message); }

TEST(Configuration, WrongSizesAreNamed) {
  const Model model = one_joint(JointKind::free);
  const std::vector<double> q = neutral(model), v(6), wrong(5);
  EXPECT_THAT([&] { check_configuration(model, wrong); }, throws("q has 5 entries; expected nq = 7"));
  EXPECT_THAT([&] { check_configuration(model, wrong, "q_start"); },
              throws("q_start has 5 entries; expected nq = 7"));
  EXPECT_THAT([&] { integrate(model, wrong, v); }, throws("q has 5 entries; expected nq = 7"));
  EXPECT_THAT([&] { integrate(model, q, wrong); }, throws("dv has 5 entries; expected nv = 6"));
  EXPECT_THAT([&] { difference(model, wrong, q); }, throws("q0 has 5 entries; expected nq = 7"));
  EXPECT_THAT([&] { difference(model, q, wrong); }, throws("q1 has 5 entries; expected nq = 7"));
  EXPECT_THAT([&] { interpolate(model, q, wrong, 0.5); }, throws("q1 has 5 entries; expected nq = 7"));
  EXPECT_THAT([&] { clamp(model, wrong); }, throws("q has 5 entries; expected nq = 7"));
  EXPECT_THAT([&] { check_size("tau", 3, 4, "nv"); }, throws("tau has 3 entries; expected nv = 4"));
}

TEST(Configuration, StepsWithoutAFiniteResultAreRefused) {
  const Model ball = one_joint(JointKind::spherical), slide = one_joint(JointKind::prismatic);
  const auto refused = [](const std::string& step) {
    return throws(step + ": at joint \"j\" it is not finite, or so large that the result is not");
  };
  EXPECT_THAT([&] { integrate(ball, neutral(ball), std::vector<double>{0, 1e200, 0}); }, refused("dv"));
  EXPECT_THAT(
      [&] {
        integrate(ball, neutral(ball), std::vector<double>{0, std::nan(""), 0});
      },
      refused("dv"));
  EXPECT_THAT([&] { difference(slide, std::vector{-1e308}, std::vector{1e308}); }, refused("q1 - q0"));
  EXPECT_THAT(integrate(slide, std::vector{0.0}, std::vector{1e200}), ElementsAre(1e200));
}

TEST(Configuration, QuaternionsAreNotNormalisedBehindTheUsersBack) {
  const Model model = one_joint(JointKind::spherical);
  const auto off = [](double norm) { return std::vector<double>{0, 0, 0, norm}; };
  EXPECT_THAT([&] { check_configuration(model, off(2)); },
              throws("q: the quaternion of joint \"j\" has norm 2; it must be 1 to 1e-06"));
  EXPECT_THAT([&] { check_configuration(model, off(0), "q1"); },
              throws("q1: the quaternion of joint \"j\" has norm 0; it must be 1 to 1e-06"));
  EXPECT_THAT([&] { check_configuration(model, off(std::nan(""))); },
              throws("q: the quaternion of joint \"j\" has norm nan; it must be 1 to 1e-06"));
  EXPECT_THROW(check_configuration(model, off(1 + 1.1e-6)), std::invalid_argument);
  EXPECT_THROW(check_configuration(model, off(1 - 1.1e-6)), std::invalid_argument);
  EXPECT_NO_THROW(check_configuration(model, off(1 + 0.9e-6)));
  EXPECT_NO_THROW(check_configuration(model, off(-1 + 0.9e-6)));
  const std::vector<float> nearly{0, 0, 0, 1.00009f}, wrong{0, 0, 0, 1.00011f};
  EXPECT_NO_THROW(check_configuration(model, nearly)) << "1e-4 in float";
  EXPECT_THROW(check_configuration(model, wrong), std::invalid_argument);
  EXPECT_THROW(integrate(model, off(2), std::vector<double>(3)), std::invalid_argument);
  EXPECT_THROW(difference(model, neutral(model), off(2)), std::invalid_argument);
}

// -------------------------------------------------------------------------------------- rates, names, limits

TEST(Configuration, RatesAreTheDerivativeOfIntegrateAndVelocitiesTheWayBack) {
  Random<double> random(53);
  for (const JointKind kind : moving_kinds) {
    const Model model = one_joint(kind);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const std::vector<double> q = random_configuration(model, seed), v = random_numbers(random, model.nv());
      const std::vector<double> dq = coordinate_rates(model, q, v);
      constexpr double h = 1e-5;
      const std::vector<double> after = integrate(model, q, scaled(h, v)),
                                before = integrate(model, q, scaled(-h, v));
      for (std::size_t k = 0; k < dq.size(); ++k)
        EXPECT_NEAR(dq[k], (after[k] - before[k]) / (2 * h), 1e-9) << to_string(kind) << " " << k;
      EXPECT_LE(distance(velocities_from_rates(model, q, dq), v), 1e-14) << to_string(kind);
    }
  }
}

TEST(Configuration, VelocitiesLeaveOutWhatWouldChangeTheNorm) {
  const Model model = one_joint(JointKind::spherical);
  const std::vector<double> q = random_configuration(model, 3);
  EXPECT_LE(size(velocities_from_rates(model, q, scaled(2, q))), 1e-15);
  EXPECT_THAT([&] { coordinate_rates(model, q, q); },
              ThrowsMessage<std::invalid_argument>("v has 4 entries; expected nv = 3"));
  EXPECT_THAT([&] { velocities_from_rates(model, q, std::vector<double>(3)); },
              ThrowsMessage<std::invalid_argument>("dq has 3 entries; expected nq = 4"));
  EXPECT_THAT([&] { coordinate_rates(model, scaled(2, q), std::vector<double>(3)); },
              ThrowsMessage<std::invalid_argument>(testing::HasSubstr("norm")));
}

TEST(Configuration, NormalizeBringsQuaternionsToLengthOneAndNothingElse) {
  const Model model = one_joint(JointKind::free);
  const std::vector<double> q = random_configuration(model, 5);
  std::vector<double> longer = q;
  for (int k = 0; k < 4; ++k) longer[k] *= 1e200;
  EXPECT_LE(distance(normalize(model, longer), q), 1e-15);
  EXPECT_EQ(normalize(model, q)[5], q[5]);
  const auto refuses = [](const std::string& norm) {
    return ThrowsMessage<std::invalid_argument>("q: the quaternion of joint \"j\" has norm " + norm +
                                                "; it must be finite and not 0 to be normalised");
  };
  EXPECT_THAT([&] { normalize(model, std::vector<double>(7)); }, refuses("0"));
  longer[2] = infinity;
  EXPECT_THAT([&] { normalize(model, longer); }, refuses("inf"));
}

TEST(Configuration, ManyRandomOnesAreOneAfterTheOther) {
  const Model model = any_model(4);
  const std::size_t nq = static_cast<std::size_t>(model.nq());
  const std::vector<double> all = random_configurations(model, 9, 5);
  ASSERT_EQ(all.size(), 5 * nq);
  EXPECT_EQ(std::vector<double>(all.begin(), all.begin() + model.nq()), random_configuration(model, 9));
  for (std::size_t k = 0; k < 5; ++k)
    EXPECT_NO_THROW(check_configuration(model, std::span(all).subspan(k * nq, nq)));
  EXPECT_GT(std::abs(all[0] - all[nq]), 1e-6);
  EXPECT_THAT(random_configurations(model, 9, 0), ElementsAre());
}

TEST(Configuration, NamesAndLimitsGoWithTheNumbers) {
  const Model model =
      ModelBuilder("mixed")
          .add({.name = "a",
                .joint = {.name = "hip",
                          .kind = JointKind::spherical,
                          .dof = {{.velocity = 1, .effort = 4}, {.velocity = 2}, {.effort = 6}}},
                .inertia = MassProperties{.mass = 1}})
          .add({.name = "b",
                .predecessor = "a",
                .joint = {.name = "knee", .kind = JointKind::revolute, .dof = {{.velocity = 3, .effort = 7}}},
                .inertia = MassProperties{.mass = 1}})
          .add({.name = "c",
                .predecessor = "b",
                .joint = {.name = "toe",
                          .kind = JointKind::revolute,
                          .dof = {{.velocity = 5, .effort = 8}},
                          .coupling = Coupling{"knee", 2}},
                .inertia = MassProperties{.mass = 1}})
          .build();
  EXPECT_THAT(coordinate_names(model), ElementsAre("hip[0]", "hip[1]", "hip[2]", "hip[3]", "knee"));
  EXPECT_THAT(velocity_names(model), ElementsAre("hip[0]", "hip[1]", "hip[2]", "knee"));
  EXPECT_THAT(velocity_limits(model), ElementsAre(1, 2, infinity, 3));
  EXPECT_THAT(effort_limits(model), ElementsAre(4, infinity, 6, 7));
}

}  // namespace
}  // namespace axode::test
