#include <gtest/gtest.h>

#include <cmath>

#include "axode/dynamics.hpp"
#include "axode/integration.hpp"
#include "axode/model/building/builder.hpp"
#include "tests/vectors/machine_files.hpp"

/// A gear with losses between a rotor and a load, against closed forms.
namespace axode::test {
namespace gear_losses {
namespace {

using Numbers = std::vector<double>;
using Span = std::span<const double>;

class GearLoss : public MachineOfFile {
 protected:
  double of(const char* key) const { return number(file_.at(key)); }
  bool unique() const { return file_.at("unique").text() == "true"; }
  Model model() const {
    const double I = of("load_inertia");
    Description d{.name = GetParam(), .gravity = {}};
    d.bodies.push_back(
        {.name = "load",
         .joint = {.name = "hinge",
                   .kind = JointKind::revolute,
                   .dof = {{.armature = of("rotor_inertia_reflected"), .gear_loss = of("kappa")}}},
         .inertia = MassProperties{.mass = 1, .Theta = {I, I, I}}});
    return ModelBuilder(std::move(d)).build();
  }
  /// The torque on the load, as a wrench.
  static AppliedWrench<> load(const Json& state) {
    return {1, Wrench<BodyFixed>{{0, 0, number(state.at("load_torque"))}, {}}};
  }
  static SimulationOptions options(const Json& state) {
    SimulationOptions options{.loads = {load(state)}, .joint_losses = true};
    options.drive = [motor = number(state.at("motor_torque"))](double, Span, Span, std::span<double> tau) {
      tau[0] = motor;
    };
    return options;
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, GearLoss, testing::ValuesIn(machines_of({"gear_loss"})),
                         [](const auto& file) { return file.param; });

TEST_P(GearLoss, MovesOrSticksAsInClosedForm) {
  const Model machine = model();
  for (const Json& state : file_.at("cases")) {
    SCOPED_TRACE(state.at("status").text());
    const double a = unique() ? number(state.at("acceleration")) : 0,
                 direction = number(state.at("direction"));
    constexpr double until = 0.125;
    const Numbers q{0.4}, v{direction * (0.1 + std::abs(a) * until)};  // it does not turn back
    for (const Trajectory& motion :
         {simulate(machine, q, v, until, {}, options(state)),
          simulate_fixed(machine, q, v, until, until / 2, runge_kutta(4), options(state)),
          simulate_stiff(machine, q, v, until, until / 4, 0.8, options(state))}) {
      if (!unique()) {
        EXPECT_FALSE(motion.complete);
        EXPECT_NE(motion.stop_reason.find("joint \"hinge\" locks itself so strongly"), std::string::npos);
        continue;
      }
      ASSERT_TRUE(motion.complete) << motion.stop_reason;
      const double scale = 1e-12 * (1 + std::abs(a)), load = number(state.at("load_torque"));
      for (std::size_t k = 0; k < motion.size(); ++k) {
        const double t = motion.t()[k], a_t = motion.a(k)[0], F = of("load_inertia") * a_t - load;
        EXPECT_NEAR(a_t, a, scale);
        EXPECT_NEAR(F, number(state.at("transmitted")), scale * (1 + std::abs(load)));
        EXPECT_NEAR(number(state.at("motor_torque")) - F - of("rotor_inertia_reflected") * a_t,
                    number(state.at("loss_torque")), scale * (1 + std::abs(load)));
        EXPECT_NEAR(motion.v(k)[0], v[0] + a * t, scale);
        EXPECT_NEAR(motion.q(k)[0], q[0] + (v[0] + a * t / 2) * t, scale);
      }
      const bool rests = motion.q(motion.size() - 1)[0] == q[0];
      EXPECT_EQ(rests, state.at("status").text() == "sticks");
    }
  }
}

TEST_P(GearLoss, HasForwardAndInverseDynamics) {
  const Model machine = model();
  Workspace<> workspace(machine);
  for (const Json& state : file_.at("cases")) {
    const double direction = number(state.at("direction"));
    if (direction == 0) continue;
    const AppliedWrench<> wrench = load(state);
    const Loads<> loads{.wrenches = {&wrench, 1}, .joint_losses = true};
    const Numbers q{-0.3}, v{0.7 * direction}, tau{number(state.at("motor_torque"))};
    Numbers a(1), back(1);
    const Solvability found = forward_dynamics(machine, workspace, q, v, tau, std::span(a), loads);
    if (!unique()) {
      EXPECT_EQ(found.locked_body, 1);
      EXPECT_TRUE(std::isnan(a[0]));
      continue;
    }
    ASSERT_TRUE(found.ok());
    EXPECT_NEAR(a[0], number(state.at("acceleration")), 1e-12 * (1 + std::abs(a[0])));
    inverse_dynamics(machine, workspace, q, v, Numbers{number(state.at("acceleration"))}, std::span(back),
                     loads);
    EXPECT_NEAR(back[0], tau[0], 1e-12 * (1 + std::abs(tau[0]) + std::abs(a[0])));
  }
}

/// At a constant speed the drive force times the efficiency is the force on the load, or the other way round.
TEST_P(GearLoss, HasItsEfficiencies) {
  const Model machine = model();
  Workspace<> workspace(machine);
  for (const double torque : {-3.0, 3.0})
    for (const double speed : {-2.0, 2.0}) {
      const AppliedWrench<> wrench{1, Wrench<BodyFixed>{{0, 0, torque}, {}}};
      const Loads<> loads{.wrenches = {&wrench, 1}, .joint_losses = true};
      Numbers tau(1);
      inverse_dynamics(machine, workspace, Numbers{0}, Numbers{speed}, Numbers{0}, std::span(tau), loads);
      const bool drives = torque * speed < 0;
      EXPECT_NEAR(tau[0], -torque * (drives ? 1 / of("efficiency") : of("efficiency_back")), 1e-14 * 10);
    }
}

}  // namespace
}  // namespace gear_losses
}  // namespace axode::test
