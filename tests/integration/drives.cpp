#include "axode/integration/drives.hpp"

#include <cmath>

#include "axode/dynamics.hpp"
#include "axode/integration.hpp"
#include "axode/model/configuration.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// Drives of simulations: samples, and controllers that move a mechanism to a configuration or along a
/// motion.
namespace axode::test {
namespace drives {
namespace {

using Numbers = std::vector<double>;
using Span = std::span<const double>;

/// A random tree in which every joint moves mass, and a state of it.
struct Driven {
  Model model;
  State<double> at;

  explicit Driven(std::uint64_t seed, bool springs = false)
      : model([&] {
          Random<double> random(seed);
          Description tree = described(
              random_mechanism(random, {.most_bodies = 6, .couplings = false, .always_mass = true}), random);
          if (springs)
            tree.springs = {{.between = {"ground", tree.bodies[0].name},
                             .points = {random.vector(), random.vector()},
                             .stiffness = 5,
                             .rest = 0.3,
                             .damping = 1}};
          return ModelBuilder(tree).build();
        }()) {
    Random<double> random(seed + 1);
    at = random_state(model, random);
  }
  std::size_t nv() const { return at.v.size(); }
  Numbers call(Drive drive, double t) const {
    Numbers tau(nv(), NAN);
    drive(t, at.q, at.v, tau);
    return tau;
  }
};

double distance(const Model& model, Span q0, Span q1) {
  double most = 0;
  for (const double x : difference(model, q0, q1)) most = std::max(most, std::abs(x));
  return most;
}

Model two_hinges() { return reduced(shoulder(), {}, Numbers{0, 0, 0, 1, 0}); }

TEST(Drives, SamplesAreJoinedByLinesOrHeld) {
  const Model model = two_hinges();  // nv = 4
  const Numbers t{1, 2, 4}, tau{0, 1, 2, 3, 10, 11, 12, 13, 30, 31, 32, 33}, q{0, 0, 0, 1, 0}, v(4);
  const auto at = [&](double time, bool hold) {
    Numbers out(4);
    SampledDrive(model, t, tau, hold)(time, q, v, out);
    return out;
  };
  for (const bool hold : {false, true}) {
    EXPECT_EQ(at(-7, hold), Numbers({0, 1, 2, 3}));
    EXPECT_EQ(at(1, hold), Numbers({0, 1, 2, 3}));
    EXPECT_EQ(at(2, hold), Numbers({10, 11, 12, 13}));
    EXPECT_EQ(at(4, hold), Numbers({30, 31, 32, 33}));
    EXPECT_EQ(at(5, hold), Numbers({30, 31, 32, 33}));
  }
  EXPECT_EQ(at(3, false), Numbers({20, 21, 22, 23}));
  EXPECT_EQ(at(3, true), Numbers({10, 11, 12, 13}));
  EXPECT_EQ(at(1.25, false), Numbers({2.5, 3.5, 4.5, 5.5}));
}

/// While nothing moves, the error of a step is 0 whatever its length is.
TEST(Drives, AreNotMissedAfterARest) {
  const Model cart = ModelBuilder("cart")
                         .add({.name = "cart",
                               .joint = {.name = "x", .kind = JointKind::prismatic, .axis = {1, 0, 0}},
                               .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1, 0, 0, 0}}})
                         .build();
  const std::vector<double> zero(1), times{0, 4, 4.1, 4.4, 4.5, 10}, tau{0, 0, 1, 1, 0, 0};
  SimulationOptions options;
  options.drive = SampledDrive(cart, times, tau);
  const Trajectory motion = simulate(cart, zero, zero, 10, {}, options);
  ASSERT_TRUE(motion.complete);
  EXPECT_NEAR(motion.v(motion.size() - 1)[0], 0.4, 1e-6);  // the force has kinks
}

TEST(Drives, AProportionalDerivativeDriveIsItsFormulaOnTheGroup) {
  for_seeds(50, [](std::uint64_t seed) {
    const Driven subject(seed);
    Random<double> random(seed + 2);
    const Numbers q_d = random_configuration(subject.model, seed + 3),
                  v_d = random_numbers(random, subject.model.nv()),
                  forward = random_numbers(random, subject.model.nv());
    Numbers kp = random_numbers(random, subject.model.nv()), kd = kp;
    for (std::size_t c = 0; c < kp.size(); ++c) kp[c] = 10 * std::abs(kp[c]), kd[c] = std::abs(kd[c]);
    const Numbers tau = subject.call(
        ProportionalDerivative(
            subject.model, {kp, kd}, {subject.model, q_d, v_d},
            [&](double, Span, Span, std::span<double> out) { std::ranges::copy(forward, out.begin()); }),
        0);
    const Numbers x = difference(subject.model, subject.at.q, q_d);
    for (std::size_t c = 0; c < tau.size(); ++c)
      EXPECT_NEAR(tau[c], kp[c] * x[c] + kd[c] * (v_d[c] - subject.at.v[c]) + forward[c], 1e-12);
    const Numbers one{2}, none{0};
    const Numbers plain =
        subject.call(ProportionalDerivative(subject.model, {one, none}, {subject.model, q_d}), 0);
    for (std::size_t c = 0; c < tau.size(); ++c) EXPECT_NEAR(plain[c], 2 * x[c], 1e-13);
  });
}

TEST(Drives, AProportionalDerivativeDriveArrives) {
  Description tree{.name = "tree", .gravity = {}, .bodies = {}};
  for (const auto& [kind, on] : {std::pair{JointKind::free, "ground"},
                                 {JointKind::spherical, "free"},
                                 {JointKind::planar, "free"},
                                 {JointKind::revolute, "spherical"},
                                 {JointKind::prismatic, "planar"}}) {
    BodyDescription body{.name = std::string(to_string(kind)), .predecessor = on};
    body.joint = {.name = body.name + " joint", .kind = kind, .axis = {0.6, 0, 0.8}};
    body.inertia = MassProperties{.mass = 1.3, .com = {0.1, 0.2, -0.1}, .Theta = {0.5, 0.7, 0.6}};
    tree.bodies.push_back(std::move(body));
  }
  const Model model = ModelBuilder(tree).build();
  const Numbers kp{60}, kd{25}, rest(static_cast<std::size_t>(model.nv()));
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Numbers q_d = random_configuration(model, seed);
    SimulationOptions options;
    options.drive = ProportionalDerivative(model, {kp, kd}, {model, q_d});
    for (const Trajectory& motion :
         {simulate(model, random_configuration(model, seed + 10), rest, 20, {}, options),
          simulate_stiff(model, random_configuration(model, seed + 10), rest, 20, 0.01, 0.8, options)}) {
      ASSERT_TRUE(motion.complete) << motion.stop_reason;
      EXPECT_LE(distance(model, motion.q(motion.size() - 1), q_d), 1e-7);
    }
  }
}

TEST(Drives, ForcesStayWithinTheLimitsOfEffortWhereAsked) {
  Description arm = two_hinges().description();
  arm.bodies[0].joint.dof = {{.effort = 2}, {.effort = 0}, {}};
  arm.bodies[1].joint.dof = {{.effort = 5}};
  const Model model = ModelBuilder(arm).build();
  const Numbers q{0, 0, 0, 1, 0}, v{100, 100, 100, -1}, kp{0}, kd{3};
  Numbers tau(4);
  ProportionalDerivative(model, {kp, kd}, {model, q}, {}, true)(0, q, v, tau);
  EXPECT_EQ(tau, Numbers({-2, 0, -300, 3}));
}

TEST(Drives, ComputedTorqueFollowsAMotion) {
  int followed = 0;
  for_seeds(30, [&](std::uint64_t seed) {
    const Driven subject(seed, seed % 2 == 0);
    SimulationOptions options;
    options.drive = [](double t, Span, Span v, std::span<double> tau) {
      for (std::size_t c = 0; c < tau.size(); ++c) tau[c] = std::sin(3 * t + static_cast<double>(c)) - v[c];
    };
    const Trajectory reference = simulate(subject.model, subject.at.q, subject.at.v, 0.5,
                                          {.relative = 1e-11, .absolute = 1e-12}, options);
    double worst = 0;
    for (const double a : reference.a()) worst = std::max(worst, std::abs(a));
    if (!reference.complete || worst > 1e3) return;
    const Numbers kp{100}, kd{20};
    options.drive = ComputedTorque(subject.model, {kp, kd}, {subject.model, reference});
    const Trajectory motion = simulate(subject.model, subject.at.q, subject.at.v, 0.5,
                                       {.relative = 1e-10, .absolute = 1e-11}, options);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    Numbers q(subject.at.q.size()), q_d(q.size()), v(subject.nv()), v_d(v.size());
    for (const double t : {0.1, 0.2333, 0.4, 0.5}) {
      motion.at(t, q, v), reference.at(t, q_d, v_d);
      EXPECT_LE(distance(subject.model, q, q_d), 1e-6);
    }
    ++followed;
  });
  EXPECT_GT(followed, 15);
}

TEST(Drives, ComputedTorqueLeavesADeviationThatDiesAwayAsItsGainsSay) {
  Description arm{.name = "arm"};
  for (int k = 0; k < 3; ++k) {
    BodyDescription body{.name = std::string(1, static_cast<char>('a' + k)),
                         .predecessor = k == 0 ? "ground" : std::string(1, static_cast<char>('a' + k - 1))};
    body.joint = {.name = "joint " + body.name,
                  .kind = k == 1 ? JointKind::prismatic : JointKind::revolute,
                  .axis = {0.1 * k, 1, 0.3},
                  .point = {0.4 * k, 0, 0}};
    body.inertia = MassProperties{.mass = 2, .com = {0.4 * k + 0.2, 0, 0.1}, .Theta = {0.1, 0.2, 0.15}};
    body.joint.dof = {{.armature = 0.2, .stiffness = 3, .rest = 0.1}};
    arm.bodies.push_back(std::move(body));
  }
  const Model model = ModelBuilder(arm).build();
  const double w = 5;
  const Numbers q0{0.3, -0.2, 0.5}, q_d{0.1, 0.1, -0.4}, kp{w * w}, kd{2 * w};
  SimulationOptions options;
  options.drive = ComputedTorque(model, {kp, kd}, {model, q_d});
  const Trajectory motion =
      simulate(model, q0, Numbers(3), 1, {.relative = 1e-10, .absolute = 1e-12}, options);
  const double t = 1, left = (1 + w * t) * std::exp(-w * t);
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(motion.q(motion.size() - 1)[c], q_d[c] + left * (q0[c] - q_d[c]), 1e-8);
}

TEST(Drives, AMotionRestsBeforeItBeginsAndAfterItEnds) {
  const Driven subject(3);
  const Trajectory motion = simulate(subject.model, subject.at.q, subject.at.v, 0.1);
  ASSERT_TRUE(motion.complete);
  Reference reference(subject.model, motion);
  const std::size_t last = motion.size() - 1;
  reference.find(7);
  EXPECT_EQ(reference.q(), Numbers(motion.q(last).begin(), motion.q(last).end()));
  EXPECT_EQ(reference.v(), Numbers(subject.nv()));
  reference.find(-1);
  EXPECT_EQ(reference.q(), subject.at.q);
  EXPECT_EQ(reference.v(), Numbers(subject.nv()));
  reference.find(std::nextafter(motion.t().back(), 1));
  EXPECT_EQ(reference.v(), Numbers(motion.v(last).begin(), motion.v(last).end()));
}

TEST(Drives, AccelerationsInBetweenAreDerivativesOfTheVelocities) {
  for_seeds(20, [](std::uint64_t seed) {
    const Driven subject(seed);
    const Trajectory motion = simulate(subject.model, subject.at.q, subject.at.v, 0.1);
    if (!motion.complete) return;
    Numbers q(subject.at.q.size()), v(subject.nv()), a(v.size()), before(v.size()), after(v.size());
    for (const double t : {0.0137, 0.05, 0.09}) {
      constexpr double h = 1e-6;
      motion.at(t - h, q, before), motion.at(t + h, q, after), motion.at(t, q, v, a);
      double scale = 1;
      for (const double a_c : a) scale = std::max(scale, std::abs(a_c));
      for (std::size_t c = 0; c < a.size(); ++c)
        EXPECT_NEAR(a[c], (after[c] - before[c]) / (2 * h), 1e-4 * scale);
    }
  });
}

TEST(Drives, ThatCannotBeAreRefused) {
  const Model model = two_hinges();
  const Numbers q{0, 0, 0, 1, 0}, good{1}, three(3), none, negative{-1}, infinite{INFINITY};
  const auto sampled = [&](const Numbers& t, const Numbers& tau) {
    return message_of([&] { SampledDrive(model, t, tau); });
  };
  using testing::StartsWith;
  EXPECT_THAT(sampled({}, {}), StartsWith("t is empty"));
  EXPECT_THAT(sampled({0, 0}, Numbers(8)), StartsWith("t[1] is 0"));
  EXPECT_THAT(sampled({0, NAN}, Numbers(8)), StartsWith("t[1] is nan"));
  EXPECT_THAT(sampled({0, 1}, Numbers(7)), StartsWith("tau has 7 entries"));
  EXPECT_THAT(sampled({0}, {0, 0, NAN, 0}), StartsWith("tau[2] is not finite"));
  const auto gains = [&](const Numbers& kp, const Numbers& kd) {
    return message_of([&] { ProportionalDerivative(model, {kp, kd}, {model, q}); });
  };
  EXPECT_EQ(gains(good, good), "no error");
  EXPECT_THAT(gains(three, good), StartsWith("kp has 3 numbers; expected 1 or nv = 4"));
  EXPECT_THAT(gains(good, none), StartsWith("kd has 0 numbers"));
  EXPECT_THAT(gains(negative, good), StartsWith("kp[0] is -1"));
  EXPECT_THAT(gains(good, infinite), StartsWith("kd[0] is inf"));
  EXPECT_THAT(message_of([&] { Reference(model, three); }), StartsWith("q has 3 entries"));
  EXPECT_THAT(message_of([&] { Reference(model, q, three); }), StartsWith("v has 3 entries"));
  EXPECT_THAT(message_of([&] { Reference(model, Numbers{0, 0, 0, 2, 0}); }), testing::HasSubstr("\"ball\""));
  EXPECT_THAT(message_of([&] { Reference(model, Trajectory(model)); }), StartsWith("motion is empty"));
  EXPECT_THAT(message_of([&] { Reference(model, Trajectory(one_body())); }),
              StartsWith("the trajectory has nq = 1 and nv = 1"));
}

}  // namespace
}  // namespace drives
}  // namespace axode::test
