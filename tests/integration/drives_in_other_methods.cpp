#include <gmock/gmock.h>

#include "axode/constraints/assembly.hpp"
#include "axode/integration.hpp"
#include "axode/integration/methods.hpp"
#include "axode/model/configuration.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/integration/driven_mechanisms.hpp"

/// Drives with states in symplectic methods, in schemes on momenta, and in absolute coordinates.
namespace axode::test {
namespace drives_in_other_methods {
namespace {

/// A method, its order, and the steps with which the order is measured.
struct Case {
  const char* method;
  Coordinates coordinates;
  double order, h;
};
constexpr Case cases[]{
    {"midpoint", Coordinates::relative, 2, 2e-3},
    {"suzuki4", Coordinates::relative, 4, 8e-3},
    {"kahan_li6", Coordinates::relative, 6, 2e-2},
    {"rk4_momenta", Coordinates::relative, 4, 8e-3},
    {"rattle", Coordinates::absolute, 2, 2e-3},
    {"rattle", Coordinates::absolute_SO3xR3, 2, 2e-3},
    {"rattle_suzuki4", Coordinates::absolute, 4, 8e-3},
    {"half_explicit", Coordinates::absolute, 3, 4e-3},
    {"generalized_alpha", Coordinates::absolute, 2, 2e-3},
    {"generalized_alpha_index3", Coordinates::absolute, 2, 2e-3},
    {"rk4", Coordinates::absolute, 4, 8e-3},
};

Trajectory motion_by(const Case& it, const Model& model, Span q, Span v, double until, double h,
                     SimulationOptions options = {}) {
  options.coordinates = it.coordinates;
  const auto method = std::ranges::find(methods, it.method, &std::pair<std::string_view, Method>::first);
  return method->second.simulate({model, q, v, until, h, {}, 0.8, options});
}

TEST(DrivesInOtherMethods, HaveTheOrderOfTheMethod) {
  Description d = controlled_pendulum();
  d.drives[0].parameters = {{"kp", 4}, {"ki", 2}, {"kd", 0.4}, {"filter_time", 0.1}};
  d.drives[1].parameters[1].second = 0.1;  // the inductance
  const Model model = ModelBuilder(d).build();
  const double until = 0.4;
  const Trajectory exact = simulate(model, {{0.3}}, {{0.5}}, until, {.relative = 1e-13, .absolute = 1e-14});
  ASSERT_TRUE(exact.complete) << exact.stop_reason;
  for (const Case& it : cases) {
    const Trajectory coarse = motion_by(it, model, {{0.3}}, {{0.5}}, until, it.h),
                     fine = motion_by(it, model, {{0.3}}, {{0.5}}, until, it.h / 2);
    ASSERT_TRUE(coarse.complete && fine.complete) << it.method << ": " << coarse.stop_reason;
    const double order = std::log2(deviation_at_end(coarse, exact) / deviation_at_end(fine, exact));
    EXPECT_NEAR(order, it.order, 0.35) << it.method << " " << to_string(it.coordinates);
    EXPECT_LT(deviation_at_end(fine, exact), 1e-3) << it.method;
  }
}

/// All kinds of drives on joints and along lines, on mechanisms with floating bases too.
TEST(DrivesInOtherMethods, FollowTheMotionOfDopri5) {
  for_seeds(6, [](std::uint64_t seed) {
    const double until = 0.05;
    const DrivenMotion at(seed, until);
    for (const Case& it : cases) {
      const Trajectory motion = motion_by(it, at.smooth, at.q, at.v, until, 1e-3, at.options);
      ASSERT_TRUE(motion.complete) << it.method << ": " << motion.stop_reason;
      EXPECT_LT(deviation_at_end(motion, at.exact), it.order < 3 ? 1e-2 : 1e-3) << it.method;
    }
    SimulationOptions absolute = at.options;
    absolute.coordinates = Coordinates::absolute;
    const Trajectory motion =
        simulate(at.smooth, at.q, at.v, until, {.relative = 1e-10, .absolute = 1e-11}, absolute);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_LT(deviation_at_end(motion, at.exact), 1e-7);
  });
}

/// A four-bar whose crank a motor turns.
TEST(DrivesInOtherMethods, ActInLoops) {
  Description d = four_bar();
  d.bodies[0].joint.name = "crank";
  d.drives = {
      {.name = "motor",
       .joints = {{"crank", 1.0}},
       .parameters = {{"resistance", 1}, {"inductance", 0.05}, {"torque_constant", 0.3}, {"ratio", 4}},
       .input = {.values = {6}}}};
  const Model model = ModelBuilder(d).build();
  const AssemblyResult start = assemble(model, neutral(model), Numbers(static_cast<std::size_t>(model.nv())));
  const double until = 0.3;
  const Trajectory exact = simulate(model, start.q, start.v, until, {.relative = 1e-12, .absolute = 1e-13});
  ASSERT_TRUE(exact.complete) << exact.stop_reason;
  for (const Case& it : cases) {
    const Trajectory motion = motion_by(it, model, start.q, start.v, until, 1e-3);
    ASSERT_TRUE(motion.complete) << it.method << ": " << motion.stop_reason;
    EXPECT_LT(deviation_at_end(motion, exact), it.order < 3 ? 1e-4 : 1e-7) << it.method;
  }
  const Trajectory touching = simulate_contact(model, start.q, start.v, until, 1e-3);
  ASSERT_TRUE(touching.complete) << touching.stop_reason;
  EXPECT_LT(deviation_at_end(touching, exact), 1e-4);
}

/// ΔE = ∫ (P_in - P_loss) dt (D17.2): the balance of a step of the midpoint rule, with the powers in its
/// middle, is of the third order.
TEST(DrivesInOtherMethods, BalanceTheEnergyOfTheirMechanism) {
  const Model model = ModelBuilder(controlled_pendulum()).build();
  DriveSystem drives(model);
  const auto imbalance = [&](double h) {
    const Trajectory motion = simulate_symplectic(model, {{0.3}}, {{0.5}}, 0.4, h);
    const auto energy = [&](std::size_t k) {
      drives.set_state(motion.t()[k], motion.q(k), motion.v(k), motion.x(k));
      return energy_of(model, motion.q(k), motion.v(k)) +
             drives.energy(motion.t()[k], motion.q(k), motion.v(k), motion.x(k)).stored;
    };
    double work = 0;
    for (std::size_t k = 0; k + 1 < motion.size(); ++k) {
      const auto middle = [](Span a, Span b) {
        Numbers mean(a.begin(), a.end());
        for (std::size_t c = 0; c < mean.size(); ++c) mean[c] = (mean[c] + b[c]) / 2;
        return mean;
      };
      const double t = (motion.t()[k] + motion.t()[k + 1]) / 2;
      const Numbers q = middle(motion.q(k), motion.q(k + 1)), v = middle(motion.v(k), motion.v(k + 1)),
                    x = middle(motion.x(k), motion.x(k + 1));
      drives.set_state(t, q, v, x);
      const DriveEnergy power = drives.energy(t, q, v, x);
      work += (motion.t()[k + 1] - motion.t()[k]) * (power.supplied - power.lost);
    }
    return std::abs(energy(motion.size() - 1) - energy(0) - work);
  };
  const double coarse = imbalance(2e-3), fine = imbalance(1e-3);
  EXPECT_GT(coarse, 1e-9);
  EXPECT_NEAR(coarse / fine, 4, 0.5);
}

/// Methods whose steps are not cut restore a limit at the end of the step.
TEST(DrivesInOtherMethods, KeepTheirLimits) {
  const Model model = ModelBuilder(limited_motor()).build();
  const double until = 1;
  const Trajectory exact = simulate(model, {{0.0}}, {{-40.0}}, until, {.relative = 1e-11});
  for (const Case& it : cases) {
    const Trajectory coarse = motion_by(it, model, {{0.0}}, {{-40.0}}, until, 2e-3),
                     fine = motion_by(it, model, {{0.0}}, {{-40.0}}, until, 5e-4);
    ASSERT_TRUE(coarse.complete && fine.complete) << it.method << ": " << coarse.stop_reason;
    EXPECT_LT(deviation_at_end(fine, exact), 0.5 * deviation_at_end(coarse, exact) + 1e-6) << it.method;
    EXPECT_LT(deviation_at_end(fine, exact), 0.02) << it.method;
  }
}

TEST(DrivesInOtherMethods, RefuseFastStatesInPartsThatRunBackwards) {
  Description d = controlled_pendulum();
  d.drives[1].parameters[1].second = 1e-5;  // the inductance
  const Model model = ModelBuilder(d).build();
  for (const Case& it : cases) {
    if (it.order < 4 || std::string_view(it.method).starts_with("rk4")) continue;
    const Trajectory motion = motion_by(it, model, {{0.3}}, {{0.0}}, 0.1, 5e-3);
    EXPECT_FALSE(motion.complete) << it.method;
    EXPECT_THAT(motion.stop_reason, testing::HasSubstr("in which time runs backwards; use a shorter step"))
        << it.method;
  }
  for (const Case& it : {cases[0], cases[4]}) {
    const Trajectory motion = motion_by(it, model, {{0.3}}, {{0.0}}, 0.1, 1e-3);
    EXPECT_TRUE(motion.complete) << it.method << motion.stop_reason;
  }
}

}  // namespace
}  // namespace drives_in_other_methods
}  // namespace axode::test
