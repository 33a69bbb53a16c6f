#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "axode/constraints/assembly.hpp"
#include "axode/integration.hpp"
#include "tests/fmi/event_master.hpp"
#include "tests/fmi/instance_of.hpp"

/// Dry friction and losses of gears in FMUs for model exchange.
namespace axode::test {
namespace {

using fmi::Instance;
using fmi::Kind;
using fmi::Role;
using testing::ElementsAre;

const fmi::Settings with_losses{.joint_losses = true};

/// A chain of two pendulums with dry friction, damping and, if wanted, a gear with losses.
Model rubbing_pendulums(double loss = 0, double friction = 0.3) {
  Description d = load(AXODE_SOURCE_DIR "/examples/robots/double_pendulum.toml").description();
  d.bodies[0].joint.dof = {{.damping = 0.05, .friction = 0.8}};
  d.bodies[1].joint.dof = {{.damping = 0.02, .friction = friction}};
  if (loss > 0) {
    d.bodies[0].joint.dof[0].gear_loss = loss;
    d.bodies[0].joint.dof[0].armature = 0.05;
  }
  return ModelBuilder(d).build();
}

Model rubbing_four_bar() {
  Description d = load(AXODE_SOURCE_DIR "/examples/robots/four_bar.toml").description();
  double friction = 0.01;
  for (BodyDescription& body : d.bodies)
    if (body.joint.kind == JointKind::revolute) body.joint.dof = {{.friction = friction += 0.01}};
  return ModelBuilder(d).build();
}

/// Compares an instance at the end of an integration in model exchange with the motion of the library under
/// the same constant forces. Returns the number of events.
int expect_the_motion(const Model& model, std::vector<double> q, const std::vector<double>& v,
                      const std::vector<double>& tau, double until, double h, double off = 1e-9) {
  SimulationOptions options;
  options.joint_losses = true;
  options.drive = [&](double, std::span<const double>, std::span<const double>, std::span<double> out) {
    std::ranges::copy(tau, out.begin());
  };
  Tolerances tolerances{1e-12, 1e-13};
  tolerances.largest_step = until;
  const Trajectory motion = simulate(model, q, v, until, tolerances, options);
  EXPECT_TRUE(motion.complete) << motion.stop_reason;
  const fmi::VariableTable table = variables_of(model, with_losses);
  Instance instance = instance_of(model, Kind::model_exchange, with_losses);
  start(instance, table, q, v, 1e-11);
  std::vector<double> inputs;
  for (const std::size_t c : table.driven()) inputs.push_back(tau[c]);
  instance.set(references(table, Role::force), inputs);
  EventMaster master(instance);
  master.integrate(until, h);
  expect_end_of(motion, instance, table, off);
  return master.events;
}

TEST(FmuFriction, SticksAndSlidesInModelExchange) {
  const Model model = rubbing_pendulums();
  EXPECT_GE(expect_the_motion(model, {1.2, -0.7}, {0, 0}, {0, 0}, 4, 1e-3), 6);
  EXPECT_GE(expect_the_motion(model, {0, 0}, {0, 0}, {1.5, -0.6}, 4, 1e-3), 2);
  EXPECT_EQ(expect_the_motion(model, {0, 0}, {0, 0}, {0.7, 0.2}, 1, 1e-2), 0);
}

TEST(FmuFriction, CountsTheLossesOfGears) {
  const Model model = rubbing_pendulums(0.3);
  EXPECT_GE(expect_the_motion(model, {1.2, -0.7}, {0, 0}, {0.5, 0}, 2, 2e-4, 2e-8), 4);
}

TEST(FmuFriction, SticksAndSlidesInLoops) {
  const Model model = rubbing_four_bar();
  const AssemblyResult at = assemble(model, initial_state(model).q, initial_state(model).v);
  EXPECT_GE(expect_the_motion(model, at.q, at.v, std::vector<double>(at.v.size()), 2, 4e-4), 2);
}

/// A slide with drive force 5 t against a bound of 2 N, and back.
TEST(FmuFriction, BreaksAwayWhereTheForceReachesTheBound) {
  Description d;
  d.name = "slide";
  d.gravity = {};
  d.bodies = {{.name = "block",
               .joint = {.name = "rail", .kind = JointKind::prismatic, .axis = {1, 0, 0}},
               .inertia = MassProperties{.mass = 3, .Theta = {1, 1, 1, 0, 0, 0}}}};
  d.bodies[0].joint.dof = {{.friction = 2}};
  const Model model = ModelBuilder(d).build();
  const fmi::VariableTable table = variables_of(model, with_losses);
  EXPECT_EQ(table.of(Role::indicator).size(), 1U);
  EXPECT_EQ(table.of(Role::indicator)[0].name, "event.rail.friction");
  Instance instance = instance_of(model, Kind::model_exchange, with_losses);
  start(instance, table, {{0}}, {{0}});
  static_cast<void>(instance.update_discrete_states());
  const auto push = [&](double tau, double v) {
    instance.set_states({std::vector<double>{0, v}});
    instance.set(reference(table, "tau.rail"), std::vector{tau});
    return std::pair{values(instance, reference(table, "event.rail.friction"))[0],
                     values(instance, reference(table, "der(v.rail)"))[0]};
  };
  EXPECT_NEAR(push(0.5, 0).first, 1.5, 1e-8);
  EXPECT_EQ(push(-1.5, 0).second, 0);
  EXPECT_NEAR(push(-1.5, 0).first, 0.5, 1e-8);
  EXPECT_FALSE(instance.needs_event());
  EXPECT_NEAR(push(2.6, 0).first, -0.6, 1e-8);
  EXPECT_TRUE(instance.needs_event());
  static_cast<void>(instance.update_discrete_states());
  EXPECT_NEAR(push(2.6, 0.1).second, 0.2, 1e-12);
  EXPECT_NEAR(push(1.4, 0.1).second, -0.2, 1e-12);
  EXPECT_NEAR(push(1.4, 0.1).first, 0.1, 1e-11);
  EXPECT_FALSE(instance.needs_event());
  EXPECT_LT(push(1.4, -1e-9).first, 0);
  EXPECT_TRUE(instance.needs_event());
  EXPECT_TRUE(instance.update_discrete_states().states_changed);
  std::vector<double> states(2);
  instance.get_states(states);
  EXPECT_THAT(states, ElementsAre(0, 0));
  EXPECT_EQ(push(1.4, 0).second, 0);
}

TEST(FmuFriction, HasTheExactDerivativesOfItsStatus) {
  constexpr double firm = 8;
  for (const Model& model : {rubbing_pendulums(0, firm), rubbing_four_bar()}) {
    const fmi::VariableTable table = variables_of(model, with_losses);
    const AssemblyResult at = assemble(model, initial_state(model).q, initial_state(model).v);
    for (const bool moves : {false, true}) {
      std::vector<double> v(at.v.size());
      if (moves && model.loops().empty()) v = {0.6, 0};
      Instance instance = instance_of(model, Kind::model_exchange, with_losses);
      start(instance, table, at.q, v);
      EventMaster begun(instance);
      const std::vector<unsigned> unknowns = references(table, Role::acceleration);
      std::vector<double> x(instance.n_states()), by(unknowns.size());
      instance.get_states(x);
      if (model.loops().empty()) {
        EXPECT_EQ(values(instance, reference(table, "der(v.elbow)"))[0], 0);
      }
      for (const Role role : {Role::coordinate, Role::velocity})
        for (std::size_t k = 0; k < table.count(role); ++k) {
          const unsigned known = static_cast<unsigned>(table.first(role) + k);
          const std::size_t place = role == Role::coordinate ? k : at.q.size() + k;
          const auto accelerations = [&](double step) {
            std::vector<double> changed = x, a(x.size());
            changed[place] += step;
            instance.set_states(changed);
            instance.get_rates(a);
            return std::vector<double>(a.begin() + std::ssize(at.q), a.end());
          };
          constexpr double step = 1e-4;
          const std::vector<double> more = accelerations(step), less = accelerations(-step);
          instance.set_states(x);
          const std::vector<double> one{1};
          instance.directional_derivative(unknowns, {&known, 1}, one, by);
          for (std::size_t i = 0; i < by.size(); ++i)
            EXPECT_NEAR(by[i], (more[i] - less[i]) / (2 * step), 1e-5 * (1 + std::abs(by[i])))
                << model.name() << " " << table[known].name << " moves: " << moves;
        }
    }
  }
}

TEST(FmuFriction, HasTheDerivativesByDamping) {
  const Model model = rubbing_pendulums();
  const fmi::VariableTable table = variables_of(model, with_losses);
  const auto accelerations = [&](double damping) {
    Instance instance = instance_of(model, Kind::model_exchange, with_losses);
    instance.set(reference(table, "joint.pin.damping"), std::vector{damping});
    instance.set(reference(table, "v.pin"), std::vector{2.0});
    instance.set(reference(table, "v.elbow"), std::vector{-1.0});
    std::vector<double> by(2);
    instance.enter_initialization(0, {});
    const std::vector<double> a = values(instance, references(table, Role::acceleration)), one{1};
    instance.directional_derivative(references(table, Role::acceleration),
                                    reference(table, "joint.pin.damping"), one, by);
    return std::pair{a, by};
  };
  const auto [a, by] = accelerations(0.05);
  const auto [more, unused] = accelerations(0.15);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(by[k], (more[k] - a[k]) / 0.1, 1e-9);
  EXPECT_GT(std::abs(by[0]), 1e-3);
}

TEST(FmuFriction, ContinuesAsItWasSaved) {
  const Model model = rubbing_pendulums();
  const fmi::VariableTable table = variables_of(model, with_losses);
  Instance instance = instance_of(model, Kind::model_exchange, with_losses);
  start(instance, table, {{1.2, -0.7}}, {{0, 0}});
  EventMaster master(instance);
  master.integrate(0.55, 1e-2);
  Instance saved(instance);
  EventMaster(instance, 0.55).integrate(1.5, 1e-2);
  EventMaster(saved, 0.55).integrate(1.5, 1e-2);
  EXPECT_EQ(values(saved, references(table, Role::coordinate)),
            values(instance, references(table, Role::coordinate)));
}

}  // namespace
}  // namespace axode::test
