#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "axode/constraints/assembly.hpp"
#include "axode/integration.hpp"
#include "tests/contact/scene.hpp"
#include "tests/fmi/instance_of.hpp"

/// Co-simulations with contact and hard stops.
namespace axode::test {
namespace {

using fmi::Instance;
using fmi::Kind;
using fmi::Role;
using testing::HasSubstr;
using testing::Not;

constexpr double drop = 0.5;

/// A ball that hops straight up and down on the floor.
Model hopping_ball(double restitution) {
  ShapeDescription floor{
      .role = ShapeDescription::Role::collision, .name = "floor", .kind = ShapeKind::plane};
  ShapeDescription skin = floor;
  skin.name = "skin";
  skin.kind = ShapeKind::sphere;
  skin.radius = 0.1;
  skin.contact.restitution = restitution;
  Description d = ModelBuilder("ball")
                      .gravity({0, 0, -10})
                      .add({.name = "ball",
                            .joint = {.name = "rail", .kind = JointKind::prismatic, .axis = {0, 0, 1}},
                            .inertia = MassProperties{.mass = 2, .Theta = {0.01, 0.01, 0.01, 0, 0, 0}},
                            .shapes = {skin}})
                      .build()
                      .description();
  d.shapes = {floor};
  d.contact.emplace();
  return ModelBuilder(d).build();
}

/// A slider that hops straight up and down on a hard stop, which moves as the ball does on the floor.
Model stopped_slide(double restitution) {
  Description d = hopping_ball(restitution).description();
  d.contact.reset();
  d.shapes.clear();
  d.bodies[0].shapes.clear();
  d.bodies[0].joint.dof = {{.lower = 0.1, .upper = 5, .hard_stops = true, .restitution = restitution}};
  return ModelBuilder(d).build();
}

/// Advances by equal communication steps from time `from` (s).
void advance(Instance& instance, int steps, double h, double from = 0) {
  for (int k = 0; k < steps; ++k) instance.step(from + k * h, h);
}

TEST(FmuContact, BouncesAsInTheLibraryAndNearlyByTheClosedForm) {
  constexpr double e = 0.6, g = 10, speed = 3.1622776601683795, first = speed / g;
  for (const Model& model : {hopping_ball(e), stopped_slide(e)}) {
    const fmi::VariableTable table = variables_of(model);
    const std::vector<double> q_0{0.1 + drop}, v_0{0};
    const Trajectory motion = simulate_contact(model, q_0, v_0, 0.5, 1e-3);
    Instance instance = instance_of(model, Kind::co_simulation);
    start(instance, table, q_0, v_0);
    advance(instance, 5, 0.1);
    const double t = 0.5 - first, q = values(instance, reference(table, "q.rail"))[0],
                 v = values(instance, reference(table, "v.rail"))[0];
    EXPECT_NEAR(q, motion.q(motion.size() - 1)[0], 1e-11);
    EXPECT_NEAR(v, motion.v(motion.size() - 1)[0], 1e-11);
    EXPECT_NEAR(q, 0.1 + e * speed * t - g * t * t / 2, 5e-3);
    EXPECT_NEAR(v, e * speed - g * t, 2e-2);
    EXPECT_NEAR(values(instance, reference(table, "der(v.rail)"))[0], -g, 1e-9);
  }
}

/// A ball hops on a plate that follows a motion. A copy of the co-simulation goes on as the first one does.
TEST(FmuContact, FollowsPrescribedMotionsAsInTheLibrary) {
  Description d = hopping_ball(0.6).description();
  BodyDescription plate = d.bodies[0];
  plate.name = "plate";
  plate.joint.name = "lift";
  plate.shapes = std::exchange(d.shapes, {});
  d.bodies.push_back(plate);
  d.motions = {{.of = "lift", .kind = MotionDescription::Kind::harmonic, .amplitude = 0.05, .frequency = 2}};
  const Model model = ModelBuilder(d).build();
  const AssemblyResult at = assemble(model, std::vector<double>{0.1 + drop, 0}, std::vector<double>(2));
  const fmi::VariableTable table = variables_of(model);
  const Trajectory motion = simulate_contact(model, at.q, at.v, 0.5, 1e-3);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  Instance instance = instance_of(model, Kind::co_simulation);
  start(instance, table, at.q, at.v);
  advance(instance, 3, 0.1);
  Instance copy = instance;
  for (Instance* each : {&instance, &copy}) {
    advance(*each, 2, 0.1, 0.3);
    const std::size_t last = motion.size() - 1;
    EXPECT_NEAR(values(*each, reference(table, "q.rail"))[0], motion.q(last)[0], 1e-11);
    EXPECT_NEAR(values(*each, reference(table, "v.rail"))[0], motion.v(last)[0], 1e-11);
    EXPECT_NEAR(values(*each, reference(table, "q.lift"))[0], motion.q(last)[1], 1e-12);
  }
}

/// With a tolerance of the master, steps are adaptive, so that impacts are found as well as it asks.
TEST(FmuContact, IsAsExactAsTheToleranceOfTheMaster) {
  constexpr double e = 0.6, g = 10, speed = 3.1622776601683795, first = speed / g, t = 0.5 - first;
  const Model model = hopping_ball(e);
  const fmi::VariableTable table = variables_of(model);
  double before = 0.1;
  for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
    Instance instance = instance_of(model, Kind::co_simulation);
    start(instance, table, {{0.1 + drop}}, {{0}}, tolerance);
    advance(instance, 5, 0.1);
    const double error =
        std::abs(values(instance, reference(table, "q.rail"))[0] - (0.1 + e * speed * t - g * t * t / 2));
    EXPECT_LE(error, 20 * tolerance);
    EXPECT_LT(error, before);
    before = error;
  }
}

/// Each communication step continues from the impulses of the last one, as the library does. All times are
/// binary fractions, so that both take the same steps.
TEST(FmuContact, IsThatOfTheLibraryInStepsOfTheUsualLengthToTheLastBit) {
  constexpr double step = 0x1p-10, communication = 8 * step;
  constexpr int count = 12;
  const Model model = shipped("quadruped.toml");
  const fmi::VariableTable table = variables_of(model);
  const InitialState at = initial_state(model);
  SimulationOptions options;
  options.joint_losses = true;
  options.drive = [](double, std::span<const double>, std::span<const double>, std::span<double> tau) {
    std::ranges::fill(tau, 0.0);
  };
  options.computed_loads = [](double, std::span<const double>, std::span<const double>,
                              std::vector<AppliedWrench<>>&) {};
  const Trajectory motion = simulate_contact(model, at.q, at.v, count * communication, step, options);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  Instance instance = instance_of(model, Kind::co_simulation, {.joint_losses = true});
  start(instance, table, at.q, at.v);
  advance(instance, count, communication);
  const std::size_t last = motion.size() - 1;
  EXPECT_TRUE(std::ranges::equal(values(instance, references(table, Role::coordinate)), motion.q(last)));
  EXPECT_TRUE(std::ranges::equal(values(instance, references(table, Role::velocity)), motion.v(last)));
}

TEST(FmuContact, SuggestsNoTolerance) {
  const auto description = [](const Model& model) -> std::string {
    for (const fmi::FmuFile& file : fmi::fmu_files(model, {.kinds = {Kind::co_simulation}}, ""))
      if (file.name == "modelDescription.xml") return file.contents;
    return "";
  };
  EXPECT_THAT(description(shipped("four_bar.toml")), HasSubstr("tolerance=\"1e-8\""));
  EXPECT_THAT(description(hopping_ball(0)), Not(HasSubstr("tolerance=")));
}

TEST(FmuContact, CarriesDrives) {
  const Model model = ModelBuilder(hopper()).build();
  const fmi::VariableTable table = variables_of(model);
  const std::vector<double> q_0{0.8, 0}, v_0{0, 0};
  const Trajectory motion = simulate_contact(model, q_0, v_0, 0.4, 1e-3);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  Instance instance = instance_of(model, Kind::co_simulation);
  start(instance, table, q_0, v_0);
  advance(instance, 40, 0.01);
  const std::size_t last = motion.size() - 1;
  const auto expect = [&](Role role, std::span<const double> expected) {
    const std::vector<double> found = values(instance, references(table, role));
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t k = 0; k < found.size(); ++k) EXPECT_NEAR(found[k], expected[k], 1e-8);
  };
  expect(Role::coordinate, motion.q(last));
  expect(Role::velocity, motion.v(last));
  expect(Role::drive_state, motion.x(last));
}

TEST(FmuContact, CarriesForcesOfTheMaster) {
  const Model model = hopping_ball(0);
  const fmi::VariableTable table = variables_of(model);
  Instance instance = instance_of(model, Kind::co_simulation);
  start(instance, table, {{0.1}}, {{0}});
  advance(instance, 2, 0.05);
  EXPECT_NEAR(values(instance, reference(table, "q.rail"))[0], 0.1, 1e-12);
  EXPECT_NEAR(values(instance, reference(table, "der(v.rail)"))[0], 0, 1e-9);
  instance.set(reference(table, "tau.rail"), std::vector{24.0});
  advance(instance, 2, 0.05, 0.1);
  EXPECT_NEAR(values(instance, reference(table, "q.rail"))[0], 0.1 + 2 * 0.1 * 0.1 / 2, 1e-12);
  EXPECT_NEAR(values(instance, reference(table, "der(v.rail)"))[0], 2, 1e-9);
}

TEST(FmuContact, ContinuesAsItWasSaved) {
  const Model model = shipped("quadruped.toml");
  const fmi::VariableTable table = variables_of(model);
  const InitialState at = initial_state(model);
  Instance instance = instance_of(model, Kind::co_simulation);
  start(instance, table, at.q, at.v);
  advance(instance, 2, 0.01);
  const Instance saved(instance);
  advance(instance, 2, 0.01, 0.02);
  Instance again(saved);
  advance(again, 2, 0.01, 0.02);
  for (const Role role : {Role::coordinate, Role::velocity, Role::acceleration})
    EXPECT_EQ(values(again, references(table, role)), values(instance, references(table, role)));
}

TEST(FmuContact, KeepsTheShapesThatTouchInTheDrawing) {
  const Model model = shipped("quadruped.toml");
  const auto count = [](const Description& d, ShapeDescription::Role role) {
    std::ptrdiff_t n = std::ranges::count(d.shapes, role, &ShapeDescription::role);
    for (const BodyDescription& body : d.bodies)
      n += std::ranges::count(body.shapes, role, &ShapeDescription::role);
    return n;
  };
  const auto kept = [](const Model& of) {
    for (const fmi::FmuFile& file : fmi::fmu_files(of, {.kinds = {Kind::co_simulation}}, ""))
      if (file.name == "resources/mechanism.toml") return read_drawing_text(file.contents, "");
    return Description{};
  };
  using enum ShapeDescription::Role;
  EXPECT_GT(count(model.description(), collision), 4);
  EXPECT_EQ(count(kept(model), collision), count(model.description(), collision));
  EXPECT_EQ(count(kept(model), visual), 0);
  Description without = model.description();
  without.contact.reset();
  EXPECT_EQ(count(kept(ModelBuilder(without).build()), collision), 0);
}

TEST(FmuContact, IsRefusedInOneSentenceWhereItDoesNotAct) {
  const auto refusal = [](const Model& model, Kind kind, const fmi::Settings& settings = {}) -> std::string {
    try {
      check_supported(model, settings, kind);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "nothing was refused";
  };
  const Model ball = hopping_ball(0.5);
  EXPECT_EQ(refusal(ball, Kind::co_simulation), "nothing was refused");
  EXPECT_EQ(refusal(ball, Kind::model_exchange),
            "an FMU for model exchange does not count contact, and model \"ball\" has shapes that touch; "
            "export it for co-simulation, or remove [contact]");
  Description d = ball.description();
  d.bodies[0].shapes[0].kind = ShapeKind::mesh;
  d.bodies[0].shapes[0].file = "ball.stl";
  EXPECT_EQ(
      refusal(ModelBuilder(d).build(), Kind::co_simulation),
      "an FMU for co-simulation with contact does not count contact of meshes, and body \"ball\" of "
      "model \"ball\" has the collision shape \"ball.stl\"; give it boxes, spheres, cylinders, capsules "
      "or ellipsoids");
  d = ball.description();
  d.bodies[0].joint.dof = {{.gear_loss = 0.2}};
  EXPECT_THAT(refusal(ModelBuilder(d).build(), Kind::co_simulation, {.joint_losses = true}),
              HasSubstr("does not count a loss of a gear, and joint \"rail\""));

  const fmi::VariableTable table = variables_of(ball);
  Instance instance = instance_of(ball, Kind::co_simulation);
  start(instance, table, {{1}}, {{0}});
  std::vector<double> one(1);
  try {
    instance.directional_derivative(reference(table, "der(v.rail)"), reference(table, "q.rail"), one, one);
    ADD_FAILURE() << "nothing was refused";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(),
                 "there are no derivatives with losses of gears or, in co-simulation, with contact, hard "
                 "stops or play");
  }
}

}  // namespace
}  // namespace axode::test
