#include <gmock/gmock.h>

#include "axode/contact/contact_shapes.hpp"
#include "axode/integration.hpp"
#include "axode/integration/exact/simulate_contact_exact.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "axode/io.hpp"
#include "tests/contact/scene.hpp"
#include "tests/integration/driven_mechanisms.hpp"

/// Drives with states in motions with contact.
namespace axode::test {
namespace drives_in_contact {
namespace {

/// A body of 1 kg on a prismatic joint along x that the motor drives.
Description slider_with(const DriveDescription& motor) {
  Description slider{.name = "slider"};
  slider.bodies = {{.name = "box",
                    .joint = {.name = "slide", .kind = JointKind::prismatic, .axis = {1, 0, 0}},
                    .inertia = MassProperties{.mass = 1, .com = {}, .Theta = {1, 1, 1, 0, 0, 0}}}};
  slider.drives = {motor};
  slider.drives[0].joints = {{"slide", 1.0}};
  return slider;
}

TEST(DrivesInContact, HaveOrderTwoInFlight) {
  for_seeds(6, [](std::uint64_t seed) {
    const double until = 0.1;
    const DrivenMotion at(seed, until);
    std::vector<double> errors;
    for (const double h : {2e-3, 1e-3, 5e-4}) {
      const Trajectory motion = simulate_contact(at.smooth, at.q, at.v, until, h, at.options);
      ASSERT_TRUE(motion.complete) << motion.stop_reason;
      errors.push_back(deviation_at_end(motion, at.exact));
    }
    EXPECT_NEAR(errors[0] / errors[2], 16, 4);
    EXPECT_LT(errors[2], 1e-3);
  });
}

TEST(DrivesInContact, AdaptedStepsAreAsExactAsTheirTolerance) {
  for_seeds(4, [](std::uint64_t seed) {
    const double until = 0.05;
    const DrivenMotion at(seed, until);
    const Trajectory motion =
        simulate_contact(at.smooth, at.q, at.v, until, {.relative = 1e-7, .absolute = 1e-7}, at.options);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_EQ(motion.t().back(), until);
    EXPECT_LT(deviation_at_end(motion, at.exact), 1e-4);
  });
}

/// A linear motor along the line from the ground to a box, which slides on the floor. A slider with the same
/// motor and a constant friction force moves in the same way.
TEST(DrivesInContact, HaveOrderTwoWhileContactsSlide) {
  constexpr double mu = 0.3, half = 0.1, speed = 0.5, until = 0.4;
  DriveDescription motor{.name = "motor", .input = {.values = {6}}};
  motor.parameters = {{"resistance", 1}, {"inductance", 0.05}, {"torque_constant", 1}};
  Description sled = Scene({.friction = mu}).add("box", ShapeKind::box, half, {.friction = mu}).description;
  sled.drives = {motor};
  sled.drives[0].line = DriveDescription::Line{.between = {"ground", "box"}, .points = {Vec3<>{-2, 0, half}}};
  const Description slider = slider_with(motor);
  SimulationOptions friction;
  friction.drive = [](double, Span, Span, std::span<double> tau) { tau[0] = -mu * g; };
  const Trajectory exact = simulate(ModelBuilder(slider).build(), {{0.0}}, {{speed}}, until,
                                    {.relative = 1e-12, .absolute = 1e-13}, friction);
  const Model model = ModelBuilder(sled).build();
  std::vector<double> errors;
  for (const double h : {4e-3, 2e-3, 1e-3}) {
    const Trajectory motion =
        simulate_contact(model, at({0, 0, half}), Numbers{0, 0, 0, speed, 0, 0}, until, h);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_LE(std::ranges::max(motion.certificates), 1e-9);
    errors.push_back(std::max({std::abs(last_q(motion)[4] - last_q(exact)[0]),
                               std::abs(last_v(motion)[3] - last_v(exact)[0]),
                               std::abs(motion.x(motion.size() - 1)[0] - exact.x(exact.size() - 1)[0])}));
  }
  EXPECT_NEAR(errors[0] / errors[2], 16, 1);
  EXPECT_LT(errors[2], 1e-4);
}

/// The hopper falls on its foot and comes to rest: the floor carries its weight, and the current the trunk.
TEST(DrivesInContact, AMotorHoldsALegOnTheGround) {
  const Model model = ModelBuilder(hopper()).build();
  const Trajectory motion = simulate_contact(model, {{0.8, 0.0}}, {{0.0, 0.0}}, 6, 2e-3);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_LE(std::ranges::max(motion.certificates), 1e-9);
  EXPECT_NEAR(last_q(motion)[1], 0.1, 1e-6);
  EXPECT_NEAR(last_q(motion)[0], 0.1 + 0.5 + foot, 1e-6);
  EXPECT_NEAR(motion.x(motion.size() - 1)[2], trunk * g / (0.05 * 100), 1e-4);
  double force = 0;
  for (const ContactForce& contact : motion.contacts(motion.size() - 1)) force += contact.force.z;
  EXPECT_NEAR(force, (trunk + leg) * g, 1e-4);
  double most = 0, gap = 1;
  for (std::size_t k = 0; k < motion.size(); ++k) {
    most = std::max(most, std::abs(motion.x(k)[2]));
    gap = std::min(gap, motion.q(k)[0] - motion.q(k)[1] - 0.5 - foot);
  }
  EXPECT_LE(most, 30 * (1 + 1e-9));  // the limit of the current
  EXPECT_GE(most, 30 * (1 - 1e-9));  // which the landing reaches
  EXPECT_GE(gap, -1e-11);
}

/// Times of impacts differ between steps by O(h), so that steps of contact converge with the first order.
TEST(DrivesInContact, ALandingConverges) {
  const Model model = ModelBuilder(hopper()).build();
  const auto end = [&](double h) {
    const Trajectory motion = simulate_contact(model, {{0.8, 0.0}}, {{0.0, 0.0}}, 0.5, h);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    return last_q(motion)[0];
  };
  const double exact = end(1e-4);
  EXPECT_NEAR(end(2e-3), exact, 4e-3);
  EXPECT_NEAR(end(5e-4), exact, 1e-3);
}

TEST(DrivesInContact, ContinueAMotionFromTheirStates) {
  const Model model = ModelBuilder(hopper()).build();
  const Trajectory whole = simulate_contact(model, {{0.8, 0.0}}, {{0.0, 0.0}}, 0.1, 1e-3);
  const std::size_t k = whole.size() / 2;
  SimulationOptions options;
  options.x.assign(whole.x(k).begin(), whole.x(k).end());
  const Trajectory rest = simulate_contact(model, whole.q(k), whole.v(k), 0.1 - whole.t()[k], 1e-3, options);
  ASSERT_TRUE(rest.complete) << rest.stop_reason;
  EXPECT_LT(deviation_at_end(rest, whole), 1e-9);
}

/// A wheel with a motor whose electric time constant is far below the step.
Model fast_motor(double until_step) {
  Description d = Scene({.friction = 0.5}).description;
  d.bodies = {{.name = "wheel",
               .joint = {.name = "hinge", .kind = JointKind::revolute},
               .inertia = MassProperties{.mass = 1, .com = {}, .Theta = {1, 1, 0.05, 0, 0, 0}}}};
  d.drives = {{.name = "motor",
               .joints = {{"hinge", 1.0}},
               .parameters = {{"resistance", 1}, {"inductance", 1e-6}, {"torque_constant", 0.5}}}};
  d.drives[0].input = {.times = {0, until_step}, .values = {10, -10}};
  return ModelBuilder(d).build();
}

TEST(DrivesInContact, FastCurrentsDoNotAlternate) {
  const double jump = 0.0105;
  const Model model = fast_motor(jump);
  const Trajectory motion = simulate_contact(model, {{0.0}}, {{0.0}}, 0.02, 1e-3);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_EQ(motion.steps, 21U);  // the jump of the input ends a step
  double after = 0;
  for (std::size_t k = 1; k < motion.size(); ++k) {
    const double t = motion.t()[k], u = t <= jump ? 10 : -10;
    if (t == jump) after = 1;
    if (k > 1 && (t < jump || t > jump + 1.1e-3)) {
      EXPECT_NEAR(motion.x(k)[0], u - 0.5 * motion.v(k)[0], 1e-2) << t;
    }
  }
  EXPECT_EQ(after, 1);
}

/// A four-bar that a fast motor drives against a stiff spring: Newton's matrix of a step counts both, and not the
/// loop, whose impulses are given in the motion between them.
TEST(DrivesInContact, AFastMotorAndAStiffSpringMoveALoop) {
  Description d = load(AXODE_SOURCE_DIR "/examples/robots/four_bar.toml").description();
  d.bodies[0].joint.dof.resize(1);
  d.bodies[0].joint.dof[0].stiffness = 500;
  d.drives = {{.name = "motor",
               .joints = {{d.bodies[0].joint.name, 1.0}},
               .parameters = {{"resistance", 1}, {"inductance", 1e-4}, {"torque_constant", 3}},
               .input = {.values = {20}}}};
  const Model model = ModelBuilder(d).build();
  const InitialState start = initial_state(model);
  const double until = 0.02;
  const Trajectory exact = simulate(model, start.q, start.v, until, {.relative = 1e-11, .absolute = 1e-12});
  std::vector<double> errors;
  for (const double h : {1e-3, 5e-5, 2.5e-5}) {
    const Trajectory motion = simulate_contact(model, start.q, start.v, until, h);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    errors.push_back(apart(model, last_q(exact), last_q(motion)));
  }
  EXPECT_LT(errors[0], 1e-2);
  EXPECT_NEAR(errors[1] / errors[2], 4, 0.5);
  EXPECT_LT(errors[2], 1e-5);
}

/// The limits of a motor end steps, and a status that is the sign of rounding errors does not.
TEST(DrivesInContact, StepsEndAtLimitsOnly) {
  const Model model = ModelBuilder(limited_motor()).build();
  const Trajectory exact = simulate(model, {{0.0}}, {{-40.0}}, 1, {.relative = 1e-11, .absolute = 1e-12});
  double before = 0;
  for (const double h : {4e-3, 1e-3}) {
    const Trajectory motion = simulate_contact(model, {{0.0}}, {{-40.0}}, 1, h);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_LE(static_cast<double>(motion.steps), 1 / h + 6);
    const double error = deviation_at_end(motion, exact);
    if (before > 0) {
      EXPECT_NEAR(before / error, 16, 4);
    }
    before = error;
  }

  Description d = hopper();
  d.drives.push_back({.name = "friction",
                      .kind = DriveKind::lugre,
                      .joints = {{"leg", 1.0}},
                      .parameters = {{"bristle_stiffness", 1e4},
                                     {"bristle_damping", 50},
                                     {"coulomb", 5},
                                     {"stiction", 6},
                                     {"stribeck_velocity", 0.01}}});
  const Model rubbing = ModelBuilder(d).build();
  const Trajectory motion = simulate_contact(rubbing, {{0.8, 0.0}}, {{0.0, 0.0}}, 3, 2e-3);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_LE(motion.steps, 1600U);
  EXPECT_LE(std::ranges::max(motion.certificates), 1e-9);
}

constexpr Tolerances tight{.relative = 1e-12, .absolute = 1e-12};

TEST(DrivesInExactContact, HaveTheirStatesAndLimitsInFlight) {
  for_seeds(6, [](std::uint64_t seed) {
    const double until = 0.3;
    const DrivenMotion at(seed, until);
    const Trajectory motion = simulate_contact_exact(at.smooth, at.q, at.v, until, tight, at.options);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_LT(deviation_at_end(motion, at.exact), 1e-9);
  });
}

/// A drive along the line from the ground to a box on the floor, at a distance of 2 m.
Model pulled_box(DriveDescription drive, double mu) {
  constexpr double half = 0.1;
  Description d = Scene({.friction = mu}).add("box", ShapeKind::box, half, {.friction = mu}).description;
  drive.line = DriveDescription::Line{.between = {"ground", "box"}, .points = {Vec3<>{-2, 0, half}}};
  d.drives = {std::move(drive)};
  return ModelBuilder(d).build();
}
std::vector<double> times_of(const Trajectory& motion, Trajectory::ContactEvent::Kind kind) {
  std::vector<double> times;
  for (const Trajectory::ContactEvent& event : motion.contact_events)
    if (event.kind == kind) times.push_back(event.t);
  return times;
}

/// The current of a motor grows until friction cannot hold the box any more, which then moves as a slider.
TEST(DrivesInExactContact, ABoxSlipsWhenTheCurrentOfItsMotorCanPullIt) {
  constexpr double mu = 0.3, V = 6, R = 1, L = 0.05, k = 1, until = 0.4;
  DriveDescription motor{.name = "motor", .input = {.values = {V}}};
  motor.parameters = {{"resistance", R}, {"inductance", L}, {"torque_constant", k}};
  const Trajectory motion =
      simulate_contact_exact(pulled_box(motor, mu), at({0, 0, 0.1}), Numbers(6), until, tight);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_LE(std::ranges::max(motion.certificates), 1e-9);
  const std::vector<double> slips = times_of(motion, Trajectory::ContactEvent::Kind::slip);
  ASSERT_FALSE(slips.empty());
  const double slip = -L / R * std::log(1 - mu * g * R / (k * V));
  for (const double t : slips) EXPECT_NEAR(t, slip, 1e-10);

  const Description slider = slider_with(motor);
  SimulationOptions friction{.x = {mu * g / k}};
  friction.drive = [](double, Span, Span, std::span<double> tau) { tau[0] = -mu * g; };
  const Trajectory exact =
      simulate(ModelBuilder(slider).build(), {{0.0}}, {{0.0}}, until - slip, tight, friction);
  EXPECT_NEAR(last_q(motion)[4], last_q(exact)[0], 1e-10);
  EXPECT_NEAR(last_v(motion)[3], last_v(exact)[0], 1e-10);
  EXPECT_NEAR(motion.x(motion.size() - 1)[0], exact.x(exact.size() - 1)[0], 1e-10);
}

/// The force of a controller jumps with its reference, and the box begins to slip in this moment.
TEST(DrivesInExactContact, ABoxSlipsWhenAnInputJumps) {
  constexpr double mu = 0.3, jump = 0.123, kp = 100, step = 0.05;
  DriveDescription controller{.name = "controller", .kind = DriveKind::pid};
  controller.parameters = {{"kp", kp}};
  controller.input = {.times = {0, jump}, .values = {2, 2 + step}};
  const Trajectory motion =
      simulate_contact_exact(pulled_box(controller, mu), at({0, 0, 0.1}), Numbers(6), 0.2, tight);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  const std::vector<double> slips = times_of(motion, Trajectory::ContactEvent::Kind::slip);
  ASSERT_FALSE(slips.empty());
  for (const double t : slips) EXPECT_EQ(t, jump);
  const double omega = std::sqrt(kp), reach = step - mu * g / kp;
  EXPECT_NEAR(last_q(motion)[4], reach * (1 - std::cos(omega * (0.2 - jump))), 1e-10);
}

TEST(DrivesInExactContact, AHopperLandsAndRests) {
  const Model model = ModelBuilder(hopper()).build();
  const Trajectory motion =
      simulate_contact_exact(model, {{0.8, 0.0}}, {{0.0, 0.0}}, 6, {.relative = 1e-9, .absolute = 1e-10});
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_LE(std::ranges::max(motion.certificates), 1e-9);
  EXPECT_NEAR(last_q(motion)[0], 0.1 + 0.5 + foot, 1e-6);
  EXPECT_NEAR(motion.x(motion.size() - 1)[2], trunk * g / (0.05 * 100), 1e-4);
  const Trajectory stepped = simulate_contact(model, {{0.8, 0.0}}, {{0.0, 0.0}}, 0.5, 1e-4);
  Numbers q(2), v(2);
  motion.at(0.5, q, v);
  EXPECT_NEAR(q[0], last_q(stepped)[0], 3e-4);
  EXPECT_NEAR(q[1], last_q(stepped)[1], 3e-4);
}

}  // namespace
}  // namespace drives_in_contact
}  // namespace axode::test
