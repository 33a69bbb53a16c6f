#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/constraints/assembly.hpp"
#include "axode/integration.hpp"
#include "axode/model/building/placement.hpp"
#include "tests/fmi/event_master.hpp"
#include "tests/fmi/instance_of.hpp"

/// Play and hard stops in FMUs for model exchange. A hard stop is a play of one joint between its limits.
namespace axode::test {
namespace {

using fmi::Instance;
using fmi::Kind;
using fmi::Role;
using testing::HasSubstr;

constexpr double threshold = 1e-3, none = std::numeric_limits<double>::infinity();

/// A mechanism with a hard stop at the limits of one of its joints, or with a coupling whose play is as wide.
Model stopped(const Model& model, const std::string& joint, double lower, double upper, double restitution,
              bool as_play) {
  Description d = model.description();
  d.contact = ContactDescription{.threshold = threshold};
  if (as_play)
    d.couplings.push_back({.name = "between the stops",
                           .terms = {{joint, 1.0}},
                           .offset = (lower + upper) / 2,
                           .play = upper - lower,
                           .restitution = restitution});
  for (BodyDescription& body : d.bodies)
    if (joint_name(body) == joint && !as_play)
      body.joint.dof = {{.lower = lower, .upper = upper, .hard_stops = true, .restitution = restitution}};
  return ModelBuilder(d).build();
}

/// Compares an instance of `model` at the end of an integration with the motion of `reference` in the
/// library. Returns the number of its impacts.
std::ptrdiff_t expect_the_motion(const Model& model, const Model& library, const std::vector<double>& q,
                                 const std::vector<double>& v, double until, double off = 1e-9) {
  const Trajectory motion = simulate(library, q, v, until, {1e-12, 1e-13});
  EXPECT_TRUE(motion.complete) << motion.stop_reason;
  const fmi::VariableTable table = variables_of(model);
  Instance instance = instance_of(model, Kind::model_exchange);
  start(instance, table, q, v, 1e-11);
  EventMaster master(instance);
  master.integrate(until, 5e-4);
  expect_end_of(motion, instance, table, off);
  return std::ranges::count(motion.play_events, true, &Trajectory::PlayEvent::impact);
}

/// Sliders on one axis with the masses 1, 2 and 3, each coupled to the next one with a play of 0.2.
Model train(double restitution) {
  Description d{.name = "train", .gravity = {0, 0, 0}};
  for (const std::string name : {"a", "b", "c"}) {
    const double mass = static_cast<double>(d.bodies.size() + 1);
    d.bodies.push_back({.name = name,
                        .joint = {.name = name, .kind = JointKind::prismatic, .axis = {1, 0, 0}},
                        .inertia = MassProperties{.mass = mass, .Theta = {1, 1, 1}}});
    if (mass == 1) continue;
    d.couplings.push_back({.name = "buffer " + name,
                           .terms = {{d.bodies[d.bodies.size() - 2].name, 1.0}, {name, -1.0}},
                           .play = 0.2,
                           .restitution = restitution});
  }
  d.contact = ContactDescription{.threshold = threshold};
  return ModelBuilder(std::move(d)).build();
}

TEST(FmuPlay, MeetsItsEndsInModelExchange) {
  for (const double e : {0.0, 0.4, 1.0}) {
    const Model model = train(e);
    EXPECT_GE(expect_the_motion(model, model, {0, 0.02, -0.03}, {2, 1, -1}, 1), 2) << e;
  }
  const fmi::VariableTable table = variables_of(train(0));
  EXPECT_EQ(table.of(Role::indicator)[1].name, "event.buffer c.play");
}

TEST(FmuHardStop, BouncesAndStaysLikeAPlay) {
  const Model pendulum = shipped("double_pendulum.toml");
  for (const double e : {0.0, 0.5}) {
    const auto of = [&](bool as_play) { return stopped(pendulum, "elbow", -0.4, 0.3, e, as_play); };
    EXPECT_GE(expect_the_motion(of(false), of(true), {1.2, 0.1}, {0, 0}, 2), 2) << e;
  }
}

TEST(FmuHardStop, ActsOnLoops) {
  const Model four_bar = shipped("four_bar.toml");
  const AssemblyResult at = assemble(four_bar, initial_state(four_bar).q, initial_state(four_bar).v);
  for (const double e : {0.0, 0.6}) {
    const auto of = [&](bool as_play) {
      return stopped(four_bar, "rocker_joint", at.q[2] - 0.2, at.q[2] + 0.15, e, as_play);
    };
    EXPECT_GE(expect_the_motion(of(false), of(true), at.q, at.v, 1), 1) << e;
  }
}

/// A slide that falls on a stop below it.
TEST(FmuHardStop, FollowsTheClosedFormOfABounce) {
  constexpr double e = 0.6, g = 10, drop = 0.5, until = 0.5;
  Description d{.name = "slide", .gravity = {0, 0, -g}};
  d.bodies = {{.name = "block",
               .joint = {.name = "rail", .kind = JointKind::prismatic, .axis = {0, 0, 1}},
               .inertia = MassProperties{.mass = 3, .Theta = {1, 1, 1}}}};
  d.bodies[0].joint.dof = {{.lower = 0.1, .upper = none, .hard_stops = true, .restitution = e}};
  const Model model = ModelBuilder(d).build();
  const fmi::VariableTable table = variables_of(model);
  EXPECT_EQ(table.of(Role::indicator)[0].name, "event.rail.stop");
  Instance instance = instance_of(model, Kind::model_exchange);
  start(instance, table, {{0.1 + drop}}, {{0}}, 1e-11);
  EventMaster(instance).integrate(until, 1e-2);
  const double speed = std::sqrt(2 * g * drop), t = until - speed / g;
  EXPECT_NEAR(values(instance, reference(table, "q.rail"))[0], 0.1 + e * speed * t - g * t * t / 2, 1e-11);
  EXPECT_NEAR(values(instance, reference(table, "v.rail"))[0], e * speed - g * t, 1e-11);

  // It comes to rest on the stop, which presses until a force lifts the block.
  EventMaster rest(instance, until);
  rest.integrate(3, 1e-2);
  EXPECT_NEAR(values(instance, reference(table, "der(v.rail)"))[0], 0, 1e-12);
  EXPECT_NEAR(values(instance, reference(table, "q.rail"))[0], 0.1, 1e-9);
  EXPECT_NEAR(values(instance, reference(table, "event.rail.stop"))[0], 3 * g, 1e-9);
  const std::vector<double> one{1};
  std::vector<double> by(1);
  instance.directional_derivative(reference(table, "der(v.rail)"), reference(table, "tau.rail"), one, by);
  EXPECT_NEAR(by[0], 0, 1e-12);
  Instance saved(instance);
  for (Instance* each : {&instance, &saved}) {
    each->set(reference(table, "tau.rail"), std::vector{36.0});
    EventMaster(*each, 3).integrate(3.5, 1e-2);
    EXPECT_NEAR(values(*each, reference(table, "q.rail"))[0], 0.1 + 2 * 0.5 * 0.5 / 2, 1e-9);
    each->directional_derivative(reference(table, "der(v.rail)"), reference(table, "tau.rail"), one, by);
    EXPECT_NEAR(by[0], 1.0 / 3, 1e-12);
  }
}

TEST(FmuHardStop, IsRefusedWhereItDoesNotAct) {
  const Model model = stopped(shipped("double_pendulum.toml"), "pin", -1, 1, 0.5, false);
  Instance instance = instance_of(model, Kind::model_exchange);
  instance.enter_initialization(0, {});
  instance.set(reference(variables_of(model), "q.pin"), std::vector{1.1});
  const auto refusal = [](const auto& f) -> std::string {
    try {
      f();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "nothing was refused";
  };
  EXPECT_EQ(refusal([&] { instance.exit_initialization(); }),
            "joint \"pin\" is at 1.1 at the start; its hard stops are at -1 and 1");
  Description d = model.description();
  d.bodies[1].joint.dof = {{.friction = 0.1}};
  const Model rubs = ModelBuilder(d).build();
  const fmi::Settings losses{.joint_losses = true};
  EXPECT_EQ(
      refusal([&] { check_supported(rubs, losses, Kind::model_exchange); }),
      "an FMU for model exchange does not count dry friction or losses of gears together with hard stops, "
      "and joint \"elbow\" of model \"double pendulum\" has it; export it for co-simulation, or without "
      "joint losses");
  EXPECT_EQ(refusal([&] { check_supported(rubs, losses, Kind::co_simulation); }), "nothing was refused");
  d = model.description();
  d.motions = {{.of = "pin", .coefficients = {0, 1}}};
  EXPECT_THAT(refusal([&] { check_supported(ModelBuilder(d).build(), {}, Kind::model_exchange); }),
              HasSubstr("does not count a hard stop of a joint that follows a motion, and joint \"pin\""));
}

}  // namespace
}  // namespace axode::test
