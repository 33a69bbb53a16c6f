#include "axode/drives.hpp"

#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>

#include "axode/dynamics.hpp"
#include "axode/integration.hpp"
#include "axode/model/configuration.hpp"
#include "tests/integration/driven_mechanisms.hpp"
#include "tests/integration/motions.hpp"

/// Drives with states of their own: balances of power, derivatives, small motions, and what is refused.
namespace axode::test {
namespace drives_with_states {
namespace {

/// ΔE = ∫ (P_in - P_loss) dt (D17.2), where dampers of springs are left out.
TEST(DrivesWithStates, BalanceTheEnergyOfTheirMechanism) {
  for_seeds(30, [](std::uint64_t seed) {
    Driven at(seed);
    Description undamped = at.model.description();
    for (SpringDescription& spring : undamped.springs) spring.damping = 0;
    for (BodyDescription& body : undamped.bodies)
      for (Dof& dof : body.joint.dof) dof.stop_stiffness = dof.stop_damping = 0;
    const Model model = ModelBuilder(undamped).build();
    const Trajectory motion =
        simulate(model, at.q, at.v, 0.2, {.relative = 1e-10, .absolute = 1e-11, .largest_step = 0.002});
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    DriveSystem drives(model);
    const auto energy_at = [&](std::size_t k) {
      drives.set_state(motion.t()[k], motion.q(k), motion.v(k), motion.x(k));
      return energy_of(model, motion.q(k), motion.v(k)) + spring_energy(model, motion.q(k)) +
             drives.energy(motion.t()[k], motion.q(k), motion.v(k), motion.x(k)).stored;
    };
    Numbers q(at.q), v(at.v), x(motion.nx());
    const auto power = [&](double t) {
      motion.at(t, q, v);
      motion.drive_states_at(t, x);
      drives.set_state(t, q, v, x);
      const DriveEnergy energy = drives.energy(t, q, v, x);
      return energy.supplied - energy.lost;
    };
    double work = 0, size = 1;
    for (std::size_t k = 0; k + 1 < motion.size(); ++k) {
      const double t = motion.t()[k], h = motion.t()[k + 1] - t, p = std::sqrt(0.15) * h;
      work += h / 18 * (5 * power(t + h / 2 - p) + 8 * power(t + h / 2) + 5 * power(t + h / 2 + p));
      size = std::max(size, std::abs(energy_at(k)));
    }
    EXPECT_NEAR(energy_at(motion.size() - 1) - energy_at(0), work, 1e-6 * size);
  });
}

TEST(DrivesWithStates, DerivativesAreThoseOfForcesAndRates) {
  for_seeds(60, [](std::uint64_t seed) {
    Driven at(seed);
    const DriveDerivatives by = at.drives.derivatives(0.1, at.q, at.v, at.x);
    const auto values = [&](Span q, Span v, Span x) {
      Eigen::VectorXd tau = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(at.nv())),
                      dx(static_cast<Eigen::Index>(at.x.size()));
      at.drives.evaluate(0.1, q, v, x, as_span(tau), as_span(dx));
      return std::pair(tau, dx);
    };
    const auto expect_slope = [&](const auto& ahead, const auto& behind, double h, const auto& tau,
                                  const auto& f, const char* what) {
      const auto near = [&](const Eigen::VectorXd& slope, const Eigen::VectorXd& exact,
                            const Eigen::VectorXd& size) {
        for (Eigen::Index k = 0; k < slope.size(); ++k)
          EXPECT_NEAR(slope[k], exact[k], 1e-5 * (1e-3 + std::abs(exact[k])) + 1e-9 * std::abs(size[k]) / h)
              << what << " " << k;
      };
      near((ahead.first - behind.first) / (2 * h), tau, ahead.first);
      near((ahead.second - behind.second) / (2 * h), f, ahead.second);
    };
    for (std::size_t j = 0; j < at.nv(); ++j) {
      constexpr double h = 1e-6;
      const auto c = static_cast<Eigen::Index>(j);
      Numbers d(at.nv()), faster = at.v, slower = at.v;
      d[j] = h;
      const Numbers q_1 = integrate(at.model, at.q, d);
      d[j] = -h;
      const Numbers q_0 = integrate(at.model, at.q, d);
      expect_slope(values(q_1, at.v, at.x), values(q_0, at.v, at.x), h, by.tau_q.col(c), by.f_q.col(c), "q");
      faster[j] += h, slower[j] -= h;
      expect_slope(values(at.q, faster, at.x), values(at.q, slower, at.x), h, by.tau_v.col(c), by.f_v.col(c),
                   "v");
    }
    for (std::size_t j = 0; j < at.x.size(); ++j) {
      const auto c = static_cast<Eigen::Index>(j);
      const double h = 1e-6 * (at.drives.states()[j].unit == "Pa" ? 1e3 : 1);
      Numbers more = at.x, less = at.x;
      more[j] += h, less[j] -= h;
      expect_slope(values(at.q, at.v, more), values(at.q, at.v, less), h, by.tau_x.col(c), by.f_x.col(c),
                   "x");
    }
  });
}

TEST(DrivesWithStates, SmallMotionsAreThoseOfTheLinearSystem) {
  const Model model = ModelBuilder(controlled_pendulum()).build();
  DriveSystem drives(model);
  Numbers x(drives.nx());
  drives.start(0, {{0.4}}, {{0.0}}, x);
  const DriveEquilibrium rest = equilibrium_with_drives(model, drives, 0, {{0.4}}, x);
  const Model nothing = ModelBuilder("nothing").build();
  DriveSystem without(nothing);
  EXPECT_TRUE(equilibrium_with_drives(nothing, without, 0, {}, {}).found);
  ASSERT_TRUE(rest.found) << rest.residual;
  EXPECT_NEAR(rest.q[0], 0.5, 1e-12);
  const DriveLinearization linear = linearize_with_drives(model, drives, 0, rest.q, {{0.0}}, rest.x);
  EXPECT_EQ(linear.B.cols(), 1);  // only the controller has an input of its own

  constexpr double small = 1e-5, until = 0.5;
  Description displaced = controlled_pendulum();
  displaced.drives[0].initial = {{"integral", rest.x[0]}, {"filter", rest.x[1]}};
  displaced.drives[1].initial = {{"current", rest.x[2]}};
  const Model start = ModelBuilder(displaced).build();
  const Trajectory motion =
      simulate(start, {{rest.q[0] + small}}, {{0.0}}, until, {.relative = 1e-11, .absolute = 1e-13});
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  Eigen::VectorXd z_0 = Eigen::VectorXd::Zero(5);
  z_0[0] = small;
  const Eigen::EigenSolver<Eigen::MatrixXd> modes(linear.A);
  const Eigen::MatrixXcd V = modes.eigenvectors();
  const Eigen::VectorXcd parts = V.partialPivLu().solve(z_0.cast<std::complex<double>>());
  const Eigen::VectorXd z =
      (V * ((until * modes.eigenvalues()).array().exp() * parts.array()).matrix()).real();
  const std::size_t last = motion.size() - 1;
  EXPECT_NEAR(last_q(motion)[0] - rest.q[0], z[0], 1e-4 * small);
  EXPECT_NEAR(last_v(motion)[0], z[1], 1e-3 * small);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(motion.x(last)[k] - rest.x[k], z[2 + static_cast<Eigen::Index>(k)], 2e-3 * small) << k;
  EXPECT_GT(z.lpNorm<Eigen::Infinity>(), 0.1 * small);

  // After a long run the motion rests where the equilibrium is.
  const Trajectory longer = simulate(model, {{0.0}}, {{0.0}}, 40, {.relative = 1e-9});
  ASSERT_TRUE(longer.complete) << longer.stop_reason;
  EXPECT_LT(linear.A.eigenvalues().real().maxCoeff(), -0.1);
  EXPECT_NEAR(last_q(longer)[0], 0.5, 1e-6);
}

/// The current of a motor that is held by hand, R i + L i' = u, as a law of the caller.
struct HeldCoil {
  std::vector<DriveState> states() const { return {{"flux", "V s", 1}}; }
  void start(const DrivePoint<double>&, std::span<double> x) const { x[0] = 0; }
  template <class T>
  void evaluate(const DrivePoint<T>& at, std::span<const int>, DriveResponse<T>& out) const {
    out.dx[0] = at.u - T(2) * at.x[0];
    out.force = T(3) * at.x[0];
  }
};

TEST(DrivesWithStates, OwnLawsActBesidesThoseOfTheModel) {
  Description d{.name = "wheel", .gravity = {}};
  d.bodies = {{.name = "wheel",
               .joint = {.name = "hinge", .kind = JointKind::revolute},
               .inertia = MassProperties{.mass = 1, .com = {}, .Theta = {1, 1, 0.5, 0, 0, 0}}}};
  const Model model = ModelBuilder(d).build();
  SimulationOptions options;
  options.drives = {{.name = "coil",
                     .joints = {{"hinge", 2.0}},
                     .law = std::make_shared<DriveLawOf<HeldCoil>>(HeldCoil{}),
                     .input = [](double) { return 4.0; }}};
  const double t = 1.5, x = 2 * (1 - std::exp(-2 * t)), v = 24 * (t - (1 - std::exp(-2 * t)) / 2);
  for (const Trajectory& motion :
       {simulate(model, {{0.0}}, {{0.0}}, t, {.relative = 1e-11, .absolute = 1e-12}, options),
        simulate_fixed(model, {{0.0}}, {{0.0}}, t, 1e-3, runge_kutta(4), options)}) {
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_THAT(std::vector(motion.drive_states().begin(), motion.drive_states().end()),
                testing::ElementsAre("coil.flux"));
    EXPECT_NEAR(motion.x(motion.size() - 1)[0], x, 1e-9);
    EXPECT_NEAR(last_v(motion)[0], v, 1e-9 * v);
    EXPECT_NEAR(motion.tau().back(), 6 * x, 1e-8);
  }
  const auto refuses = [&](const AddedDrive& drive, const char* why) {
    EXPECT_THAT([&] { DriveSystem(model, std::span(&drive, 1)); },
                testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(why)));
  };
  const auto law = options.drives[0].law;
  refuses({.name = "coil", .joints = {{"hinge", 1.0}}, .law = {}}, "drive \"coil\" has no law");
  refuses({.name = "coil", .joints = {}, .law = law}, "drive \"coil\" acts on nothing");
  refuses({.name = "coil", .joints = {{"hinge", std::nan("")}}, .law = law},
          "the factor nan of joint \"hinge\"");
}

/// Each controller passes its input on, in a description that names the last one first.
TEST(DrivesWithStates, FeedEachOtherInLongChains) {
  constexpr int n = 20000;
  Description d{.name = "chain", .gravity = {}};
  d.bodies = {{.name = "wheel",
               .joint = {.name = "hinge", .kind = JointKind::revolute},
               .inertia = MassProperties{.mass = 1, .com = {}, .Theta = {1, 1, 0.5, 0, 0, 0}}}};
  for (int k = n; k > 0; --k) {
    DriveDescription drive{.name = std::to_string(k), .kind = DriveKind::pid, .joints = {{"hinge", 1.0}}};
    drive.parameters = {{"kp", 1}};
    if (k > 1)
      drive.input.from = std::to_string(k - 1);
    else
      drive.input.values = {3};
    d.drives.push_back(drive);
  }
  DriveSystem drives(ModelBuilder(d).build());
  Numbers x(drives.nx()), dx(drives.nx()), tau(1);
  drives.start(0, {{0.0}}, {{0.0}}, x);
  drives.evaluate(0, {{0.0}}, {{0.0}}, x, tau, dx);
  EXPECT_EQ(tau[0], 3);
  d.drives.back().input = {.from = std::to_string(n)};
  EXPECT_THAT([&] { static_cast<void>(ModelBuilder(d).build()); },
              testing::ThrowsMessage<ModelError>(testing::HasSubstr("a drive must not feed itself")));
}

TEST(DrivesWithStates, CurrentsLeaveTheirLimitIfTheVoltageIsTooSmall) {
  const Model model = ModelBuilder(limited_motor()).build();
  const Trajectory motion = simulate(model, {{0.0}}, {{-40.0}}, 3, {.relative = 1e-10});
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  double largest = 0;
  std::size_t held = 0;
  for (std::size_t k = 0; k < motion.size(); ++k) {
    largest = std::max(largest, motion.x(k)[0]);
    held += motion.x(k)[0] == 4 ? 1 : 0;
  }
  EXPECT_GT(largest, 4.5);  // at -40 rad/s the coil has 20 V, of which the amplifier takes 10 V
  EXPECT_GT(held, 3U);
  EXPECT_NEAR(motion.x(motion.size() - 1)[0], 0, 0.2);
  EXPECT_NEAR(last_v(motion)[0], 20, 0.5);
}

TEST(DrivesWithStates, ImplicitStepsHaveOrderTwo) {
  const Model model = ModelBuilder(controlled_pendulum()).build();
  const Trajectory exact = simulate(model, {{0.3}}, {{0.0}}, 0.4, {.relative = 1e-12, .absolute = 1e-13});
  ASSERT_TRUE(exact.complete) << exact.stop_reason;
  for (const double rho : {1.0, 0.8, 0.5, 0.0}) {
    double before = 0;
    for (const double h : {0.4 / 400, 0.4 / 800, 0.4 / 1600}) {
      const Trajectory motion = simulate_stiff(model, {{0.3}}, {{0.0}}, 0.4, h, rho);
      ASSERT_TRUE(motion.complete) << motion.stop_reason;
      const double error = error_at_end(motion, exact);
      if (before > 0) {
        EXPECT_NEAR(before / error, 4, 0.25) << rho << " " << h;
      }
      before = error;
    }
    EXPECT_LT(before, 1e-3);
  }
}

/// Limits end steps of the implicit method as well, and steps are larger than an explicit one can take.
TEST(DrivesWithStates, ImplicitStepsFollowLimitsAndStiffStates) {
  Description d = controlled_pendulum();
  d.drives[0].parameters[4].second = 6;     // the limit
  d.drives[1].parameters[1].second = 1e-4;  // the inductance
  const Model model = ModelBuilder(d).build();
  const Trajectory exact = simulate(model, {{-0.5}}, {{0.0}}, 1, {.relative = 1e-10}),
                   motion = simulate_stiff(model, {{-0.5}}, {{0.0}}, 1, 1e-3, 0.5);
  ASSERT_TRUE(exact.complete) << exact.stop_reason;
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_LT(error_at_end(motion, exact), 2e-3);
  EXPECT_LE(motion.steps, 1020U);
}

/// A cylinder that begins farther in than its chamber has room.
TEST(DrivesWithStates, ChambersWithoutVolumeEndTheMotion) {
  Description d{.name = "boom", .gravity = {}};
  d.bodies = {{.name = "boom",
               .joint = {.name = "slide", .kind = JointKind::prismatic},
               .inertia = MassProperties{.mass = 1, .com = {}, .Theta = {1, 1, 1, 0, 0, 0}}}};
  d.drives = {{.name = "cylinder", .kind = DriveKind::hydraulic_cylinder, .joints = {{"slide", 1.0}}}};
  d.drives[0].parameters = {{"stroke", 1},           {"area_a", 1e-3},         {"area_b", 1e-3},
                            {"dead_volume_a", 1e-4}, {"dead_volume_b", 1e-4},  {"bulk_modulus", 1e8},
                            {"valve", 1e-7},         {"supply_pressure", 1e6}, {"valve_time", 0.1}};
  d.drives[0].input.values = {0};
  const Model model = ModelBuilder(d).build();
  for (const auto& [q, chamber] : {std::pair{-0.5, "pressure_a"}, {1.5, "pressure_b"}})
    EXPECT_EQ(
        simulate(model, {{q}}, {{0.0}}, 1).stop_reason,
        "at t = 0 s: the rate of the drive state \"cylinder." + std::string(chamber) + "\" is not finite");
}

TEST(DrivesWithStates, ContinueAMotionFromTheirStates) {
  for_seeds(10, [](std::uint64_t seed) {
    const Driven at(seed);
    Description constant = at.model.description();
    for (DriveDescription& drive : constant.drives)
      if (drive.input.function) drive.input = {.values = {drive.input.function->amplitude}};
    const Model model = ModelBuilder(constant).build();
    const Trajectory whole = simulate_fixed(model, at.q, at.v, 0.2, 0.005);
    ASSERT_TRUE(whole.complete) << whole.stop_reason;
    const std::size_t k = whole.size() / 2, last = whole.size() - 1;
    SimulationOptions options;
    options.x.assign(whole.x(k).begin(), whole.x(k).end());
    const Trajectory rest =
        simulate_fixed(model, whole.q(k), whole.v(k), 0.2 - whole.t()[k], 0.005, runge_kutta(4), options);
    ASSERT_TRUE(rest.complete) << rest.stop_reason;
    Comparison x("x", 1e-9), q("q", 1e-9);
    const auto numbers = [](Span all) { return Numbers(all.begin(), all.end()); };
    x.expect_equal(numbers(rest.x(rest.size() - 1)), numbers(whole.x(last)));
    q.expect_equal(numbers(rest.q(rest.size() - 1)), numbers(whole.q(last)));
  });
}

TEST(DrivesWithStates, AreRefusedWhereTheyAreNotFollowed) {
  const Model model = ModelBuilder(controlled_pendulum()).build();
  const Numbers q{0}, v{0};
  const auto refuses = [](const char* why) {
    return testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(why));
  };
  SimulationOptions given;
  given.x = {0.1};
  EXPECT_THAT([&] { simulate_fixed(model, q, v, 1, 0.1, runge_kutta(4), given); },
              refuses("x has 1 entries; expected nx = 3"));
  given.x = {0.1, std::nan(""), 0};
  EXPECT_THAT([&] { simulate_fixed(model, q, v, 1, 0.1, runge_kutta(4), given); },
              refuses("x[1], the state \"controller.filter\", is not finite"));
  Numbers tau(1), dq(2), dv(2);
  EXPECT_THAT([&] { static_cast<void>(rollout_jvp(model, q, v, tau, 0.1, q, v, tau, dq, dv)); },
              refuses("rollout sensitivities does not count drives with states, and model \"pendulum\" has "
                      "2; rollout_derivatives_with_drives counts them"));
}

}  // namespace
}  // namespace drives_with_states
}  // namespace axode::test
