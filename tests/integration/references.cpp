#include <numbers>

#include "axode/constraints.hpp"
#include "axode/io.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/integration/motions.hpp"
#include "tests/support/refused_arguments.hpp"

/// Motions that controllers follow: through samples, by functions of time, and profiles within limits.
namespace axode::test {
namespace references {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

struct At {
  Numbers q, v, a;

  At(const Trajectory& motion, double t)
      : q(static_cast<std::size_t>(motion.model().nq())),
        v(static_cast<std::size_t>(motion.model().nv())),
        a(v) {
    motion.at(t, q, v, a);
  }
};

/// The motion q = q_0 ⊕ x(t) with waves x, of every joint of a random tree.
struct Wave {
  Model model;
  Numbers q_0, amplitude, phase;

  explicit Wave(std::uint64_t seed)
      : model(Mover(seed).model),
        q_0(random_configuration(model, seed)),
        amplitude(static_cast<std::size_t>(model.nv())),
        phase(amplitude) {
    Random<double> random(seed + 7);
    for (std::size_t c = 0; c < phase.size(); ++c)
      amplitude[c] = random.number(0.2, 0.8), phase[c] = random.number(0, 6);
  }
  Numbers x(double t, int derivative) const {
    Numbers out(phase.size());
    for (std::size_t c = 0; c < out.size(); ++c)
      out[c] = amplitude[c] * std::sin(t + phase[c] + derivative * std::numbers::pi / 2);
    return out;
  }
  Numbers q(double t) const { return integrate(model, q_0, x(t, 0)); }
  Numbers v(double t) const {
    Numbers out(phase.size());
    ConfigurationGroup<double>(model.tree<double>()).velocity(x(t, 0), x(t, 1), out);
    return out;
  }
  Numbers a(double t) const {
    Numbers out(phase.size());
    ConfigurationGroup<double>(model.tree<double>()).acceleration(x(t, 0), x(t, 1), x(t, 2), out);
    return out;
  }
  /// The trajectory through samples of the first `derivatives` derivatives.
  Trajectory sampled(std::span<const double> times, int derivatives) const {
    Numbers all_q, all_v, all_a;
    const auto append = [](Numbers& to, const Numbers& row) { to.insert(to.end(), row.begin(), row.end()); };
    for (const double t : times) {
      append(all_q, q(t));
      if (derivatives > 0) append(all_v, v(t));
      if (derivatives > 1) append(all_a, a(t));
    }
    return trajectory_from_samples(model, times, all_q, all_v, all_a);
  }
};

Numbers evenly(double from, double to, int steps) {
  Numbers t;
  for (int k = 0; k <= steps; ++k) t.push_back(from + (to - from) * k / steps);
  return t;
}

double largest_difference(Span x, Span y) {
  double most = 0;
  for (std::size_t k = 0; k < x.size(); ++k) most = std::max(most, std::abs(x[k] - y[k]));
  return most;
}

/// v is the rate of q along the group and a that of v, by central differences.
void expect_derivatives(const Trajectory& motion, double t, double tolerance) {
  constexpr double h = 1e-5;
  const At before(motion, t - h), at(motion, t), after(motion, t + h);
  const Numbers step = difference(motion.model(), before.q, after.q);
  for (std::size_t c = 0; c < step.size(); ++c) {
    EXPECT_NEAR(at.v[c], step[c] / (2 * h), tolerance) << "v of velocity " << c << " at " << t;
    EXPECT_NEAR(at.a[c], (after.v[c] - before.v[c]) / (2 * h), tolerance) << "a of " << c << " at " << t;
  }
}

TEST(TrajectoriesFromSamples, HaveTheDerivativesOfWhatTheyInterpolate) {
  for_seeds(20, [](std::uint64_t seed) {
    const Wave wave(seed);
    for (const int derivatives : {0, 1, 2}) {
      const Trajectory motion = wave.sampled(evenly(0, 2, 20), derivatives);
      EXPECT_EQ(motion.steps, 20);
      for (const double t : {0.03, 0.77, 1.02, 1.96}) expect_derivatives(motion, t, 1e-6);
    }
  });
}

TEST(TrajectoriesFromSamples, ApproachTheMotionWithTheirOrder) {
  double worst = 0;
  for_seeds(20, [&](std::uint64_t seed) {
    const Wave wave(seed);
    for (const int derivatives : {0, 1, 2}) {
      double error[3][2] = {};
      for (const int refined : {0, 1}) {
        const Trajectory motion = wave.sampled(evenly(0, 2, 20 << refined), derivatives);
        for (int k = 1; k < 40; ++k) {
          const double t = 0.05 * k + 0.012;
          const At at(motion, t);
          error[0][refined] = std::max(error[0][refined], apart(wave.model, at.q, wave.q(t)));
          error[1][refined] = std::max(error[1][refined], largest_difference(at.v, wave.v(t)));
          error[2][refined] = std::max(error[2][refined], largest_difference(at.a, wave.a(t)));
        }
      }
      for (int order = 0; order < 3; ++order)
        if (error[order][1] > 1e-10) {
          EXPECT_LT(error[order][1], 1.6 * error[order][0] * std::pow(0.5, 6 - order))
              << "derivative " << order << " from samples of " << derivatives << " derivatives";
        }
      worst = std::max(worst, error[0][1]);
    }
  });
  EXPECT_LT(worst, 1e-6);
}

TEST(TrajectoriesFromSamples, OfJointsOfOneVelocityAreMotionsOfTheKindSamples) {
  const Model model = load(AXODE_SOURCE_DIR "/examples/robots/arm7.toml");
  Random<double> random(5);
  const Numbers t{0, 0.1, 0.3, 0.35, 0.6, 0.8, 0.9, 1.4}, q = random_numbers(random, 8 * 7);
  const Trajectory motion = trajectory_from_samples(model, t, q);
  for (std::size_t c = 0; c < 7; ++c) {
    MotionDescription samples{.of = "", .kind = MotionDescription::Kind::samples, .times = t};
    for (std::size_t k = 0; k < 8; ++k) samples.values.push_back(q[7 * k + c]);
    const MotionFunction function(samples);
    for (const double time : {0.0, 0.07, 0.31, 0.5, 0.8, 1.1, 1.4}) {
      const At at(motion, time);
      const MotionValue expected = function(time);
      EXPECT_NEAR(at.q[c], expected.s, 1e-9);
      EXPECT_NEAR(at.v[c], expected.ds, 1e-7);
      EXPECT_NEAR(at.a[c], expected.dds, 1e-5);
    }
  }
}

/// The samples say in which direction a body turns if it turns by less than half a turn from one to the next.
TEST(TrajectoriesFromSamples, FollowBodiesThatSpinFast) {
  const Model model = ModelBuilder("top").add({.name = "top", .joint = {.kind = JointKind::free}}).build();
  const Numbers z{1.7, -2.1, 0.8, 3, -1, 0.5}, t = evenly(0, 9, 9), q_0 = random_configuration(model, 3);
  Numbers q, step(6);
  const auto at_time = [&](double time) {
    for (std::size_t c = 0; c < 6; ++c) step[c] = time * z[c];
    return integrate(model, q_0, step);
  };
  for (const double time : t) {
    const Numbers q_k = at_time(time);
    q.insert(q.end(), q_k.begin(), q_k.end());
  }
  const Trajectory motion = trajectory_from_samples(model, t, q);
  for (const double time : {0.0, 0.4, 2.5, 4.9, 8.7, 9.0}) {
    const At at(motion, time);
    EXPECT_LT(apart(model, at.q, at_time(time)), 1e-11);
    EXPECT_LT(largest_difference(at.v, z), 1e-10);
    EXPECT_LT(largest_difference(at.a, Numbers(6)), 1e-9);
  }
}

TEST(TrajectoriesFromFunctions, FollowThemAndRestElsewhere) {
  const Model model = load(AXODE_SOURCE_DIR "/examples/robots/arm7.toml");
  using Kind = MotionDescription::Kind;
  const MotionFunction wave(MotionDescription{
      .of = "", .kind = Kind::harmonic, .offset = 0.1, .amplitude = 0.4, .frequency = 1, .phase = 0.3});
  const MotionFunction ramp(
      MotionDescription{.of = "", .kind = Kind::ramp, .from = 0.2, .to = 1, .start = 0.123, .end = 0.777});
  Numbers rest(7, 0.05);
  const std::vector<PrescribedMotion> motions{{model.joint(2).name, wave}, {model.joint(5).name, ramp}};
  const Trajectory motion = trajectory_from_functions(model, evenly(0, 1, 20), motions, rest);
  EXPECT_EQ(motion.size(), 23) << "there is a state at each end of the ramp";
  for (const double t : {0.0, 0.017, 0.123, 0.13, 0.5, 0.76, 0.777, 0.9, 1.0}) {
    const At at(motion, t);
    for (std::size_t c = 0; c < 7; ++c) {
      const MotionValue expected = c == 1 ? wave(t) : c == 4 ? ramp(t) : MotionValue{.s = 0.05};
      EXPECT_NEAR(at.q[c], expected.s, 1e-8) << t;
      EXPECT_NEAR(at.v[c], expected.ds, 1e-6) << t;
      EXPECT_NEAR(at.a[c], expected.dds, 1e-3) << t;
    }
  }
}

TEST(TrajectoriesFromFunctions, CountTheMotionsOfTheModel) {
  Description arm = shoulder().description();
  arm.motions = {
      {.of = "elbow", .kind = MotionDescription::Kind::polynomial, .coefficients = {0.1, 0.2, 0.3}}};
  const Model model = ModelBuilder(arm).build();
  const Trajectory motion = trajectory_from_functions(model, Numbers{1, 3}, {});
  EXPECT_NEAR(At(motion, 2).q[4], 0.1 + 0.4 + 1.2, 1e-14);
  EXPECT_NEAR(At(motion, 2).v[3], 0.2 + 1.2, 1e-14);
  EXPECT_NEAR(At(motion, 2).a[3], 0.6, 1e-13);
}

/// A motion within limits of a random tree, of each kind.
struct Planned {
  Model model;
  Numbers start, goal, velocity, acceleration;

  explicit Planned(std::uint64_t seed)
      : model(Mover(seed).model),
        start(random_configuration(model, seed)),
        goal(random_configuration(model, seed + 1000)) {
    Random<double> random(seed);
    for (int c = 0; c < model.nv(); ++c) {
      velocity.push_back(random.number(0, 1) < 0.2 ? INFINITY : random.number(0.3, 3));
      acceleration.push_back(random.number(0.5, 5));
    }
  }
  ProfileLimits limits() const { return {.acceleration = acceleration, .velocity = velocity}; }
  std::vector<Trajectory> motions() const {
    return {quintic_profile(model, start, goal, limits()), trapezoidal_profile(model, start, goal, limits())};
  }
};

TEST(Profiles, GoFromRestToRestWithinLimitsAndAsFastAsTheseAllow) {
  for_seeds(40, [](std::uint64_t seed) {
    const Planned planned(seed);
    if (planned.model.nv() == 0) return;
    for (const Trajectory& motion : planned.motions()) {
      const double T = motion.t().back();
      EXPECT_EQ(motion.t().front(), 0);
      EXPECT_LT(apart(planned.model, At(motion, 0).q, planned.start), 1e-14);
      EXPECT_LT(apart(planned.model, At(motion, T).q, planned.goal), 1e-12);
      EXPECT_EQ(At(motion, 0).v, Numbers(planned.velocity.size()));
      EXPECT_EQ(At(motion, T).v, Numbers(planned.velocity.size()));
      double used = 0;
      for (int k = 0; k <= 400; ++k) {
        const At at(motion, k < 400 ? T * k / 400 : T);
        for (std::size_t c = 0; c < at.v.size(); ++c) {
          EXPECT_LE(std::abs(at.v[c]), planned.velocity[c] * (1 + 1e-9));
          EXPECT_LE(std::abs(at.a[c]), planned.acceleration[c] * (1 + 1e-7));
          used = std::max(
              {used, std::abs(at.v[c]) / planned.velocity[c], std::abs(at.a[c]) / planned.acceleration[c]});
        }
      }
      EXPECT_GT(used, 1 - 1e-3);
    }
  });
}

TEST(Profiles, HaveVelocitiesAndAccelerationsThatAreDerivatives) {
  for_seeds(20, [](std::uint64_t seed) {
    const Planned planned(seed);
    for (const Trajectory& motion : planned.motions()) {
      const std::span<const double> t = motion.t();
      for (std::size_t k = 0; k + 1 < t.size(); k += 7)
        if (t[k + 1] - t[k] > 1e-4) expect_derivatives(motion, 0.4 * t[k] + 0.6 * t[k + 1], 1e-5);
    }
  });
}

/// Every joint stays on its geodesic, between the states of the trajectory as well.
TEST(Profiles, MoveEveryJointAlongItsGeodesic) {
  for_seeds(20, [](std::uint64_t seed) {
    const Planned planned(seed);
    const Numbers X = difference(planned.model, planned.start, planned.goal);
    for (const Trajectory& motion : planned.motions())
      for (const double part : {0.111, 0.347, 0.5, 0.83}) {
        const At at(motion, part * motion.t().back());
        const Numbers x = difference(planned.model, planned.start, at.q);
        for (const Joint& joint : planned.model.joints()) {
          double s = 0, length = 0;
          for (int c = joint.iv; c < joint.iv + joint.nv; ++c) {
            s += x[static_cast<std::size_t>(c)] * X[static_cast<std::size_t>(c)];
            length += X[static_cast<std::size_t>(c)] * X[static_cast<std::size_t>(c)];
          }
          for (int c = joint.iv; c < joint.iv + joint.nv; ++c)
            EXPECT_NEAR(x[static_cast<std::size_t>(c)], s / length * X[static_cast<std::size_t>(c)], 1e-10);
          EXPECT_TRUE(joint.nv == 0 || (s > 0 && s < length));
        }
      }
  });
}

/// The arm of the examples; test_drives.py expects the same numbers.
struct Arm {
  Model model = load(AXODE_SOURCE_DIR "/examples/robots/arm7.toml");
  Numbers start = Numbers(7), goal{0.3, 0.9, -0.2, -1.2, 0.1, 0.7, 0}, acceleration{5};
  ProfileLimits limits{.acceleration = acceleration};
};

TEST(Profiles, TakeTheTimesOfTheirFormulas) {
  const Arm arm;
  const Numbers fast{1, 1, 1, 1, 1, 1, 1}, slow{0.5};
  const auto quintic = [&](Span v) {
    return quintic_profile(arm.model, arm.start, arm.goal, {arm.acceleration, v}).t().back();
  };
  const auto trapezoidal = [&](Span v) {
    return trapezoidal_profile(arm.model, arm.start, arm.goal, {arm.acceleration, v}).t().back();
  };
  EXPECT_NEAR(quintic(fast), 15.0 / 8 * 1.2, 1e-14);
  EXPECT_NEAR(quintic(Numbers{100}), std::sqrt(10 / std::sqrt(3) * 1.2 / 5), 1e-14);
  EXPECT_NEAR(trapezoidal(fast), 1.2 + 0.2, 1e-14);
  EXPECT_NEAR(trapezoidal(slow), 2.4 + 0.1, 1e-14);
  EXPECT_NEAR(trapezoidal(Numbers{100}), 2 * std::sqrt(1.2 / 5), 1e-14);
  EXPECT_EQ(quintic({}), quintic(velocity_limits(arm.model)));
  EXPECT_EQ(trapezoidal({}), trapezoidal(velocity_limits(arm.model)));

  const Numbers at_once{1e9};
  const Trajectory constant = trapezoidal_profile(arm.model, arm.start, arm.goal, {at_once, slow});
  EXPECT_EQ(At(constant, 0).v, Numbers(7)) << "the joints start at rest even if they accelerate at once";
  EXPECT_NEAR(At(constant, 1.2).v[3], -0.5, 1e-9);

  const Trajectory motion = trapezoidal_profile(arm.model, arm.start, arm.goal, {arm.acceleration, fast});
  EXPECT_NEAR(At(motion, 0.1).a[3], -5, 1e-9);
  EXPECT_NEAR(At(motion, 0.2 + 1e-6).a[3], 0, 1e-9);
  EXPECT_NEAR(At(motion, 0.7).v[3], -1, 1e-12);
  EXPECT_NEAR(At(motion, 1.3).a[3], 5, 1e-9);
  const Trajectory nothing = quintic_profile(arm.model, arm.goal, arm.goal, arm.limits);
  EXPECT_EQ(nothing.size(), 1);
  EXPECT_EQ(At(nothing, 0).q, arm.goal);
}

TEST(References, AreFollowedByComputedTorque) {
  for_seeds(15, [](std::uint64_t seed) {
    const Planned planned(seed);
    const Numbers kp{400}, kd{40}, rest(static_cast<std::size_t>(planned.model.nv()));
    for (const Trajectory& reference : planned.motions()) {
      const double T = reference.t().back();
      SimulationOptions options;
      options.drive = ComputedTorque(planned.model, {kp, kd}, {planned.model, reference});
      const Trajectory motion = simulate(planned.model, planned.start, rest, std::min(T, 1.0),
                                         {.relative = 1e-8, .absolute = 1e-9}, options);
      ASSERT_TRUE(motion.complete) << motion.stop_reason;
      for (const double part : {0.3, 0.7, 1.0}) {
        const double t = part * std::min(T, 1.0);
        EXPECT_LT(apart(planned.model, At(motion, t).q, At(reference, t).q), 1e-5);
      }
    }
  });
}

/// The numbers are those of test_drives.py.
TEST(References, AreFollowedAsInPython) {
  const Arm arm;
  const Numbers kp{300, 300, 100, 100, 20, 20, 5}, kd{30, 30, 10, 10, 1, 1, 0.2};
  const Numbers one{400}, two{40};
  const Trajectory profile = trapezoidal_profile(arm.model, arm.start, arm.goal, arm.limits);
  SimulationOptions options;
  const auto ends_at = [&](const Drive& drive) {
    options.drive = drive;
    const Trajectory motion =
        simulate_fixed(arm.model, arm.start, arm.start, 0.5, 1e-3, runge_kutta(4), options);
    return Numbers(last_q(motion).begin(), last_q(motion).end());
  };
  const Numbers with_pd = ends_at(ProportionalDerivative(arm.model, {kp, kd}, {arm.model, profile}));
  const Numbers with_torque = ends_at(ComputedTorque(arm.model, {one, two}, {arm.model, profile}));
  const Numbers expected_pd{0.102331471969416,  0.32730562631117,  -0.0787280669991157, -0.46728652434372,
                            0.0363755519853867, 0.247725641339614, 4.88768689048955e-05};
  const Numbers expected_torque{0.107996512861124,
                                0.348494549706939,
                                -0.071997675240749,
                                -0.483152231099273,
                                0.0359988376203745,
                                0.251991863342621,
                                0};
  EXPECT_LT(largest_difference(expected_pd, with_pd), 1e-9) << testing::PrintToString(with_pd);
  EXPECT_LT(largest_difference(expected_torque, with_torque), 1e-9) << testing::PrintToString(with_torque);
}

/// Passive joints get no force, and the coordinates of the crank follow the profile.
TEST(References, OfAClosedMechanismAreFollowedByItsDrives) {
  Description d = four_bar();
  d.bodies[1].joint.passive = d.bodies[2].joint.passive = true;
  const Model model = ModelBuilder(d).build();
  const auto closed = [&](double crank) {
    const std::vector<int> held{0};
    const AssemblyResult found = assemble(model, Numbers{crank, 0, 0}, {}, {.held = held});
    EXPECT_EQ(found.status, AssemblyStatus::closed);
    return found.q;
  };
  const Numbers start = closed(0), goal = closed(0.5), acceleration{4}, velocity{1}, kp{400}, kd{40};
  const Trajectory reference = quintic_profile(model, start, goal, {acceleration, velocity});
  SimulationOptions options;
  options.drive = ComputedTorque(model, {kp, kd}, {model, reference});
  const Trajectory motion =
      simulate(model, start, Numbers(3), reference.t().back(), {.relative = 1e-8, .absolute = 1e-9}, options);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  for (const double part : {0.2, 0.5, 0.8, 1.0}) {
    const double t = part * reference.t().back();
    EXPECT_NEAR(At(motion, t).q[0], At(reference, t).q[0], 1e-6);
  }
  EXPECT_LT(apart(model, last_q(motion), goal), 1e-5);
  for (std::size_t k = 0; k < motion.size(); ++k) EXPECT_EQ(motion.tau()[3 * k + 1], 0);
}

TEST(References, ThatCannotBeAreRefused) {
  const Model model = shoulder();
  const Numbers q{0, 0, 0, 1, 0}, t{0, 1}, two{0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, v(8);
  const auto sampled = [&](const Numbers& times, const Numbers& rows, const Numbers& rates = {},
                           const Numbers& a = {}) {
    return message_of([&] { trajectory_from_samples(model, times, rows, rates, a); });
  };
  EXPECT_EQ(sampled(t, two, v, v), "no error");
  EXPECT_THAT(sampled({0}, q), StartsWith("t has 1 times; a trajectory needs at least two"));
  EXPECT_THAT(sampled({0, 0}, two), StartsWith("t[1] is 0"));
  EXPECT_THAT(sampled({0, NAN}, two), StartsWith("t[1] is nan"));
  EXPECT_THAT(sampled(t, q), StartsWith("q has 5 entries; expected nq for each time = 10"));
  EXPECT_THAT(sampled(t, two, {0}), StartsWith("v has 1 entries; expected nv for each time = 8"));
  EXPECT_THAT(sampled(t, two, v, {0}), StartsWith("a has 1 entries"));
  EXPECT_THAT(sampled(t, two, {}, v), StartsWith("v is missing"));
  Numbers bad = two;
  bad[8] = 2;
  EXPECT_THAT(sampled(t, bad), StartsWith("q[1]: the quaternion of joint \"ball\" has norm 2"));
  bad[8] = INFINITY;
  EXPECT_THAT(sampled(t, bad), StartsWith("q[8] is not finite"));
  EXPECT_THAT(sampled(t, two, Numbers(8, NAN)), StartsWith("v[0] is not finite"));

  const auto functions = [&](const std::vector<PrescribedMotion>& motions) {
    return message_of([&] { trajectory_from_functions(model, t, motions, q); });
  };
  const auto constant = [](double s) { return MotionFunction([s](double) { return MotionValue{s}; }); };
  EXPECT_EQ(functions({{"elbow", constant(1)}}), "no error");
  EXPECT_THAT(functions({{"elbo", constant(1)}}), HasSubstr("did you mean"));
  EXPECT_THAT(functions({{"ball", constant(1)}}), HasSubstr("joint \"ball\" has 3 velocities"));
  EXPECT_THAT(functions({{"elbow", constant(1)}, {"elbow", constant(1)}}), HasSubstr("has two motions"));
  EXPECT_THAT(functions({{"elbow", constant(NAN)}}),
              StartsWith("motions: the motion of \"elbow\" is not finite at t = 0 s"));
  const MotionFunction known(MotionDescription{
      .of = "", .kind = MotionDescription::Kind::samples, .times = {0, 0.5}, .values = {0, 1}});
  EXPECT_THAT(functions({{"elbow", known}}), HasSubstr("known from 0 s to 0.5 s"));

  Description limited = model.description();
  limited.bodies[1].joint.dof = {{.lower = -1, .upper = 1, .velocity = 0}};
  const Model arm = ModelBuilder(limited).build();
  for (auto* profile : {&quintic_profile, &trapezoidal_profile}) {
    const auto planned = [&](const Numbers& goal, const Numbers& acceleration, const Numbers& velocity) {
      return message_of([&] { (*profile)(arm, q, goal, {acceleration, velocity}); });
    };
    const Numbers there{0, 0, 0, 1, 0.5}, outside{0, 0, 0, 1, 1.5}, one{1};
    EXPECT_EQ(planned(there, one, one), "no error");
    EXPECT_EQ(planned(there, one, {INFINITY}), "no error");
    EXPECT_EQ(planned(q, one, {}), "no error");
    EXPECT_THAT(planned(there, one, {}),
                AllOf(StartsWith("velocity is missing"), HasSubstr("the limit 0 for \"elbow\""),
                      HasSubstr("has to move by 0.5")));
    EXPECT_THAT(planned(outside, one, one),
                AllOf(StartsWith("goal[4] is 1.5; coordinate \"elbow\" has the limits -1 and 1")));
    EXPECT_THAT(planned(there, {0}, one), StartsWith("acceleration[0] is 0; a limit must be positive"));
    EXPECT_THAT(planned(there, {1, 1, -1, 1}, one), StartsWith("acceleration[2] is -1"));
    EXPECT_THAT(planned(there, {INFINITY}, one), StartsWith("acceleration[0] is inf"));
    EXPECT_THAT(planned(there, {}, one), StartsWith("acceleration has 0 numbers; expected 1 or nv = 4"));
    EXPECT_THAT(planned(there, one, {0}), StartsWith("velocity[0] is 0; a limit must be positive"));
    EXPECT_THAT(planned(there, one, {NAN}), StartsWith("velocity[0] is nan"));
    EXPECT_THAT(planned(there, one, {1, 1}), StartsWith("velocity has 2 numbers"));
    EXPECT_THAT(planned({0, 0, 0, 1}, one, one), StartsWith("goal has 4 entries; expected nq = 5"));
    EXPECT_THAT(planned({0, 0, 0, 2, 0}, one, one), StartsWith("goal: the quaternion of joint \"ball\""));
    EXPECT_THAT(planned({0, 0, 0, 1, NAN}, one, one), StartsWith("goal[4] is not finite"));
  }
}

}  // namespace
}  // namespace references
}  // namespace axode::test
