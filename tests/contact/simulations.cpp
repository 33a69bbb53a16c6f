#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "axode/constraints/assembly.hpp"
#include "axode/dynamics/forward_dynamics.hpp"
#include "axode/dynamics/momentum/energy.hpp"
#include "axode/dynamics/momentum/momentum.hpp"
#include "axode/integration/exact/simulate_contact_exact.hpp"
#include "axode/integration/simulation.hpp"
#include "tests/contact/reference_contacts.hpp"
#include "tests/contact/scene.hpp"
#include "tests/support/random_loops.hpp"

/// Motions with contact whose results are known.
namespace axode::test {
namespace {

using testing::HasSubstr;
using Numbers = std::vector<double>;
using Span = std::span<const double>;

TEST(ContactSimulation, APlasticImpactEndsAtRest) {
  const Model model = Scene({.friction = 0.5}).add("ball", ShapeKind::sphere, 0.1, {.friction = 0.5}).build();
  for (const double step : {1e-2, 3e-3, 1e-3}) {
    const Trajectory motion = simulate_contact(model, at({0, 0, 0.3}), std::vector<double>(6), 0.5, step);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    double least = 1, fastest = 0;
    for (std::size_t k = 0; k < motion.size(); ++k) {
      least = std::min(least, motion.q(k)[6]);
      fastest = std::max(fastest, motion.v(k)[5]);
    }
    EXPECT_GE(least, 0.1 - 1e-12) << "no overlap";
    EXPECT_LE(fastest, 1e-12) << "no rebound";
    EXPECT_NEAR(last(motion, false)[6], 0.1, 1e-12);
    EXPECT_LE(largest(last(motion, true)), 1e-12);
    EXPECT_LE(std::ranges::max(motion.certificates), 1e-9);
  }
}

TEST(ContactSimulation, AccelerationsInFlightCountTheDamping) {
  Description d{.name = "damped arms", .bodies = {}, .frames = {}};
  std::string last = "ground";
  for (const std::string name : {"upper arm", "lower arm"}) {
    d.bodies.push_back({.name = name,
                        .predecessor = last,
                        .joint = {.kind = JointKind::revolute, .axis = {0, 1, 0}, .dof = {{.damping = 0.7}}},
                        .inertia = MassProperties{.mass = 2, .com = {0.3, 0, 0}, .Theta = {0.1, 0.2, 0.2}}});
    last = name;
  }
  const Model model = ModelBuilder(d).build();
  const std::vector<double> q{0.4, -0.9}, v{3, -5}, tau(2);
  SimulationOptions options;
  options.joint_losses = true;
  const Trajectory motion = simulate_contact(model, q, v, 0.05, 1e-2, options);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  Workspace<> workspace(model);
  for (std::size_t k = 0; k < motion.size(); ++k) {
    std::vector<double> a(2);
    ASSERT_TRUE(forward_dynamics(model, workspace, motion.q(k), motion.v(k), tau, a, {{}, true}).ok());
    for (std::size_t c = 0; c < 2; ++c) EXPECT_NEAR(motion.a(k)[c], a[c], 1e-11) << k;
  }
}

TEST(ContactSimulation, ABallBouncesToTheHeightsOfItsRestitution) {
  const double e = 0.8, height = 0.5;
  const Model model = Scene({.restitution = e}).add("ball", ShapeKind::sphere, 0.1, {.friction = 0}).build();
  const Trajectory motion =
      simulate_contact(model, at({0, 0, 0.1 + height}), std::vector<double>(6), 1.2, 2e-4);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  std::vector<double> tops;
  double made = 0;
  for (std::size_t k = 1; k + 1 < motion.size(); ++k) {
    const auto z = [&](std::size_t i) { return motion.q(i)[6]; };
    if (z(k) > z(k - 1) && z(k) >= z(k + 1)) tops.push_back(z(k) - 0.1);
    made = std::max(made, energy_at(model, motion, k) - energy_at(model, motion, k - 1));
  }
  ASSERT_GE(tops.size(), 2u);
  EXPECT_NEAR(tops[0], e * e * height, 4e-3 * height);
  EXPECT_NEAR(tops[1], std::pow(e, 4) * height, 6e-3 * height);
  EXPECT_LE(made, 1e-12) << "an impact makes no energy";
}

/// The height of a ball that falls from a height and bounces, at a time.
double height_of_bouncing_ball(double height, double e, double t) {
  double speed = std::sqrt(2 * g * height), t_0 = speed / g;
  if (t < t_0) return height - g * t * t / 2;
  for (;;) {
    speed *= e;
    if (const double flight = 2 * speed / g; t < t_0 + flight)
      return speed * (t - t_0) - g * (t - t_0) * (t - t_0) / 2;
    else
      t_0 += flight;
  }
}

TEST(ContactSimulation, AdaptedStepsFollowImpactsWithinTheirTolerance) {
  const double e = 0.8, height = 0.5, until = 1.2;
  const Model model = Scene({.restitution = e}).add("ball", ShapeKind::sphere, 0.1, {.friction = 0}).build();
  for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
    const Trajectory motion = simulate_contact(model, at({0, 0, 0.1 + height}), std::vector<double>(6), until,
                                               Tolerances{.relative = 0, .absolute = tolerance});
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_EQ(motion.t().back(), until);
    EXPECT_NEAR(last(motion, false)[6] - 0.1, height_of_bouncing_ball(height, e, until), 30 * tolerance);
    EXPECT_LE(std::ranges::max(motion.certificates), 1e-9);
    EXPECT_LT(motion.steps, 1000);
    EXPECT_EQ(motion.certificates.size(), motion.size() - 1);
  }
}

TEST(ContactSimulation, AdaptedStepsFollowTheBeginningOfSticking) {
  const double mu = 0.3, v_0 = 1;
  const Model model = Scene({.friction = mu}).add("box", ShapeKind::box, 0.1, {.friction = mu}).build();
  const Trajectory motion = simulate_contact(model, at({0, 0, 0.1}), std::vector<double>{0, 0, 0, v_0, 0, 0},
                                             1, Tolerances{.relative = 1e-9, .absolute = 1e-9});
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_NEAR(last(motion, false)[4], v_0 * v_0 / (2 * mu * g), 1e-7);
  EXPECT_LE(largest(last(motion, true)), 1e-12);
}

/// Gravity alone may close a gap that the velocity at the start of the step would leave open.
TEST(ContactSimulation, ABallBouncesWhereverInAStepItMeetsTheFloor) {
  const double e = 0.8, step = 1e-2;
  const Model model = Scene({.restitution = e}).add("ball", ShapeKind::sphere, 0.1, {.friction = 0}).build();
  for (int k = 0; k < 200; ++k) {
    const double height = 0.2 + 1e-4 * k;
    const Trajectory motion =
        simulate_contact(model, at({0, 0, 0.1 + height}), std::vector<double>(6), 0.25, step);
    double fastest = 0;
    for (std::size_t i = 0; i < motion.size(); ++i) fastest = std::max(fastest, motion.v(i)[5]);
    EXPECT_NEAR(fastest, e * std::sqrt(2 * g * height), g * step) << "from " << height << " m";
  }
}

/// A box slides down an incline with g (sin α - μ cos α), and does not move below the angle of friction.
TEST(ContactSimulation, ABoxOnAnInclineSticksOrSlidesByTheLaw) {
  const double angle = 20 * std::acos(-1.0) / 180, half = 0.1, until = 1;
  for (const double mu : {std::tan(angle) * (1 + 1e-9), 0.3}) {
    const Model model =
        Scene({.friction = mu}, angle).add("box", ShapeKind::box, half, {.friction = mu}).build();
    const Vec3<> n{std::sin(angle), 0, std::cos(angle)}, down{std::cos(angle), 0, -std::sin(angle)};
    const Trajectory motion =
        simulate_contact(model, at(half * n, angle), std::vector<double>(6), until, 1e-2);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    const std::vector<double> q = last(motion, false);
    const Vec3<> r{q[4], q[5], q[6]};
    const double way = g * std::max(0.0, std::sin(angle) - mu * std::cos(angle)) * until * until / 2;
    EXPECT_NEAR(dot(r, down), way, 1e-12);
    EXPECT_NEAR(dot(r, n), half, 1e-12);
    EXPECT_LE(std::ranges::max(motion.certificates), 1e-9);
  }
}

TEST(ContactSimulation, ABowlingBallRollsWithFiveSeventhsOfItsSpeed) {
  const Model model = Scene({.friction = 0.3}).add("ball", ShapeKind::sphere, 0.1, {.friction = 0.3}).build();
  const Trajectory motion =
      simulate_contact(model, at({0, 0, 0.1}), std::vector<double>{0, 0, 0, 2, 0, 0}, 1, 1e-2);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  Workspace<> workspace(model);
  const Momentum<Spatial> Pi =
      spatial_momentum<double>(model, workspace, motion.q(motion.size() - 1), motion.v(motion.size() - 1));
  EXPECT_NEAR(Pi.p.x, 2 * 5.0 / 7, 1e-12);
  EXPECT_NEAR(last(motion, false)[6], 0.1, 1e-12);
}

/// Ten boxes on each other, the top one a thousand times as heavy, do not move.
TEST(ContactSimulation, AStackStands) {
  const double half = 0.1;
  Scene scene({.friction = 0.5});
  std::vector<double> q;
  for (int k = 0; k < 10; ++k) {
    scene.add("box " + std::to_string(k), ShapeKind::box, half, {.friction = 0.5});
    for (const double x : at({0, 0, half * (2 * k + 1)})) q.push_back(x);
  }
  scene.description.bodies.back().inertia->mass = 1000;
  const Model model = scene.build();
  const Trajectory motion = simulate_contact(model, q, std::vector<double>(60), 0.1, 5e-3);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  const std::vector<double> end = last(motion, false);
  for (std::size_t k = 0; k < q.size(); ++k) EXPECT_NEAR(end[k], q[k], 1e-11);
  EXPECT_LE(std::ranges::max(motion.certificates), 1e-9);
}

/// A mechanism that floats freely, under gravity and with hard stops that it meets, keeps the momentum about
/// its centre of mass.
TEST(ContactSimulation, AFloatingTreeKeepsItsMomentum) {
  int stopped = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Random<double> random(seed);
    const Model model = floating_tree_with_stops(random, 0);
    if (model.n_bodies() < 2) continue;
    const std::vector<double> q = neutral(model), v = random_numbers(random, model.nv());
    const Trajectory motion = simulate_contact(model, q, v, 0.5, 5e-3);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    if (std::ranges::any_of(motion.certificates, [](double x) { return x > 0; })) ++stopped;
    Workspace<> workspace(model);
    const auto momentum = [&](std::size_t k) {
      return centroidal_momentum<double>(model, workspace, motion.q(k), motion.v(k));
    };
    const auto first = momentum(0), end = momentum(motion.size() - 1);
    const double size = 1 + norm(first.l) + norm(first.p);
    EXPECT_LE(norm(end.l - first.l), 1e-11 * size) << "seed " << seed;
    const Vec3<> gained = 0.5 * model.total_mass() * model.gravity();
    EXPECT_LE(norm(end.p - first.p - gained), 1e-11 * (size + norm(gained))) << "seed " << seed;
  }
  EXPECT_GE(stopped, 2) << "mechanisms that met their stops";
}

TEST(ContactSimulation, LoopsAreClosedAtTheEndsOfSteps) {
  int loops = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random<double> random(seed);
    const ClosedMechanism mechanism =
        closed_mechanism(random, {.most_bodies = 6, .couplings = false, .springs = 0});
    const Model& model = mechanism.model;
    bool rolls = false;
    for (const LoopRows& loop : model.loops().all) rolls = rolls || loop.rows != loop.residuals;
    if (rolls || model.loops().empty()) continue;
    ++loops;
    const Trajectory motion = simulate_contact(model, mechanism.state.q, mechanism.state.v, 0.02, 2e-3);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    LoopWorkspace<> workspace(model);
    std::vector<double> r(static_cast<std::size_t>(model.loops().residuals));
    for (std::size_t k = 0; k < motion.size(); ++k) {
      loop_residual<double>(model, workspace, motion.q(k), r);
      EXPECT_LE(largest(r), 1e-11) << "seed " << seed << ", step " << k;
    }
  }
  EXPECT_GE(loops, 2);
}

/// Where a body begins inside the floor, it comes out slowly and does not jump.
/// Tangents of a contact are a convention, which jumps for horizontal normals; the motion is none.
TEST(ContactSimulation, ARotatedSceneHasTheRotatedMotion) {
  const auto end_of = [](double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    const SO3<> R{{c, 0, -s}, {0, 1, 0}, {s, 0, c}};  // about y
    Scene scene({.friction = 0.3});
    scene.description.gravity = R * Vec3<>{0, 0, -9.81};
    scene.description.shapes[0].pose.R = R;
    BodyDescription tilting{.name = "tilting", .geometry = InConstructionFrame{{R, {}}}};
    tilting.joint = {
        .kind = JointKind::revolute, .axis = R * Vec3<>{0.3, 1, 0}, .point = R * Vec3<>{0, 0, 1}};
    tilting.inertia = MassProperties{.mass = 3, .Theta = {1, 1, 1, 0, 0, 0}};
    tilting.shapes.push_back(touching(ShapeKind::box, {.friction = 0.3}, 0.5));
    scene.description.bodies.push_back(tilting);
    scene.add("ball", ShapeKind::sphere, 0.1, {.friction = 0.3});
    scene.description.bodies.back().geometry = InConstructionFrame{{R, R * Vec3<>{0.2, 0.1, 0.62}}};
    const Model model = scene.build();
    std::vector<double> v(7);
    v[1 + 4] = 0.5;
    const Trajectory motion = simulate_contact(model, neutral(model), v, 0.4, 2e-3);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    return last(motion, false);
  };
  const std::vector<double> straight = end_of(0.4);
  for (const double angle : {1.0, std::acos(-1.0) / 2, 2.5}) {
    const std::vector<double> turned = end_of(angle);
    for (std::size_t k = 0; k < straight.size(); ++k) EXPECT_NEAR(turned[k], straight[k], 1e-8) << angle;
  }
}

TEST(ContactSimulation, AnOverlapPartsSlowly) {
  const Model model = Scene({.friction = 0.5}).add("ball", ShapeKind::sphere, 0.1, {.friction = 0.5}).build();
  const Trajectory motion = simulate_contact(model, at({0, 0, 0.09}), std::vector<double>(6), 0.5, 1e-2);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  for (std::size_t k = 1; k < motion.size(); ++k) {
    EXPECT_LE(motion.q(k)[6] - motion.q(k - 1)[6], 5 * 0.01 * 1e-2 * (1 + 1e-9));
    EXPECT_LE(std::abs(motion.v(k)[5]), 1e-12);
  }
  EXPECT_NEAR(last(motion, false)[6], 0.1, 1e-9);
}

/// A block on a slide with a stop that throws it back.
Description block_with_stop() {
  Description description{.gravity = {}};
  BodyDescription body{.name = "block"};
  body.joint = {.kind = JointKind::prismatic, .axis = {1, 0, 0}};
  body.inertia = MassProperties{.mass = 2, .Theta = {1, 1, 1, 0, 0, 0}};
  body.joint.dof = {Dof{.upper = 0.5, .hard_stops = true, .restitution = 0.6}};
  description.bodies.push_back(body);
  return description;
}
Trajectory with_stop(const Description& description, const SimulationOptions& options = {}) {
  const std::vector<double> q{0}, v{1};
  return simulate_contact(ModelBuilder(description).build(), q, v, 1, 1e-2, options);
}

TEST(ContactSimulation, AStopReflectsByItsRestitution) {
  const Trajectory motion = with_stop(block_with_stop());
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_NEAR(last(motion, true)[0], -0.6, 1e-12);
}

/// Puts the floor of a scene on a body that slides along x, and lets this body follow a motion.
Description on_a_slide(Scene scene, std::vector<double> coefficients) {
  Description d = std::move(scene.description);
  BodyDescription slide{.name = "slide"};
  slide.joint = {.name = "rail", .kind = JointKind::prismatic, .axis = {1, 0, 0}};
  slide.inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}};
  slide.shapes = std::exchange(d.shapes, {});
  d.bodies.insert(d.bodies.begin(), slide);
  d.motions = {{.of = "rail", .coefficients = std::move(coefficients)}};
  return d;
}
/// The motion until a time in steps of 1 ms, and in smooth phases between exact events.
std::array<Trajectory, 2> both_ways(const Model& model, Span q, Span v, double until) {
  return {simulate_contact(model, q, v, until, 1e-3),
          simulate_contact_exact(model, q, v, until, {.relative = 1e-12, .absolute = 1e-12})};
}
Numbers joined(double first, Numbers rest) {
  rest.insert(rest.begin(), first);
  return rest;
}

/// Friction accelerates the ball, and turns it, until it rolls with 2/7 of the speed of the belt.
TEST(ContactSimulation, ABeltThatFollowsAMotionCarriesABall) {
  const double speed = 1, mu = 0.3, r = 0.1, until = 0.5;
  Scene scene({.friction = mu});
  scene.add("ball", ShapeKind::sphere, r, {.friction = mu});
  const Model model = ModelBuilder(on_a_slide(scene, {0, speed})).build();
  const double rolls = speed / (3.5 * mu * g);
  double tolerance = 1e-4;
  for (const Trajectory& motion :
       both_ways(model, joined(0, at({0, 0, r})), joined(speed, Numbers(6)), until)) {
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_LE(std::ranges::max(motion.certificates), 1e-9);
    EXPECT_NEAR(last(motion, false)[0], speed * until, 1e-12);
    EXPECT_NEAR(last(motion, true)[0], speed, 1e-12);
    EXPECT_NEAR(last(motion, false)[5], mu * g * rolls * rolls / 2 + 2 * speed / 7 * (until - rolls),
                tolerance);
    EXPECT_NEAR(norm(Vec3<>{last(motion, true)[4], last(motion, true)[5], last(motion, true)[6]}),
                2 * speed / 7, tolerance);
    tolerance = 1e-10;
  }
}

TEST(ContactSimulation, AWallThatFollowsAMotionHitsABall) {
  const double speed = 0.8, r = 0.1, distance = 0.3, until = 1, hit = (distance - r) / speed;
  for (const double e : {0.0, 0.6, 1.0}) {
    Scene scene({.friction = 0, .restitution = e}, std::numbers::pi / 2);
    scene.description.gravity = {};
    scene.add("ball", ShapeKind::sphere, r, {.friction = 0});
    const Model model = ModelBuilder(on_a_slide(scene, {0, speed})).build();
    double tolerance = 1e-3;
    for (const Trajectory& motion :
         both_ways(model, joined(0, at({distance, 0, 0})), joined(speed, Numbers(6)), until)) {
      ASSERT_TRUE(motion.complete) << motion.stop_reason;
      EXPECT_NEAR(last(motion, true)[4], (1 + e) * speed, 1e-10) << "restitution " << e;
      EXPECT_NEAR(last(motion, false)[5], distance + (1 + e) * speed * (until - hit), tolerance);
      EXPECT_NEAR(last(motion, false)[0], speed * until, 1e-12);
      tolerance = 1e-10;
    }
  }
}

/// The slider of a slider-crank pushes a ball while it becomes faster, and the ball keeps its largest speed.
TEST(ContactSimulation, ACrankThatFollowsAMotionPushesABall) {
  const double rate = 4, a = 0.1, b = 0.4, r = 0.1;
  Scene scene({.friction = 0}, std::numbers::pi / 2);
  scene.description.gravity = {};
  scene.add("ball", ShapeKind::sphere, r, {.friction = 0});
  Description d = on_a_slide(scene, {0, rate});
  d.motions[0].of = "crank";
  const MassProperties inertia{.mass = 0.5, .Theta = {0.01, 0.01, 0.01}};
  d.bodies.push_back(
      {.name = "wheel", .joint = {.name = "crank", .kind = JointKind::revolute}, .inertia = inertia});
  d.bodies.push_back({.name = "rod",
                      .predecessor = "wheel",
                      .joint = {.name = "pin", .kind = JointKind::revolute, .point = {-a, 0, 0}},
                      .inertia = inertia});
  d.loops = {{.name = "eye", .between = {"rod", "slide"}, .point = {b - a, 0, 0}}};
  const Model model = ModelBuilder(d).build();
  const auto speed_at = [&](double turn) {  // of the slider, whose crank starts at π
    const double s = std::sin(turn), c = std::cos(turn);
    return rate * a * s * (1 - a * c / std::sqrt(b * b - a * a * s * s));
  };
  double largest_speed = 0;
  for (int k = 0; k < 100000; ++k)
    largest_speed = std::max(largest_speed, speed_at(1e-5 * std::numbers::pi * k));
  Numbers q = joined(0, at({r, 0, 0})), v = joined(0, Numbers(6));
  q.insert(q.end(), {0, 0});
  v.insert(v.end(), {0, 0});
  const AssemblyResult start = assemble(model, q, v);
  ASSERT_EQ(start.status, AssemblyStatus::closed);
  v = start.v;
  double tolerance = 1e-4;
  for (const Trajectory& motion : both_ways(model, start.q, v, 0.7)) {
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_NEAR(last(motion, true)[4], largest_speed, tolerance);
    EXPECT_NEAR(last(motion, true)[0], speed_at(rate * 0.7), 1e-9);
    EXPECT_NEAR(last(motion, false)[8], rate * 0.7, 1e-12);
    tolerance = 1e-9;
  }
}

TEST(ContactSimulation, ABodyThatIsCaughtEndsTheMotion) {
  const double r = 0.1, speed = 0.5, distance = 0.1;
  Scene scene({.friction = 0}, std::numbers::pi / 2);
  scene.description.gravity = {};
  scene.add("ball", ShapeKind::sphere, r, {.friction = 0});
  Description d = on_a_slide(scene, {0, speed});
  ShapeDescription wall = touching(ShapeKind::box, {.friction = 0}, 1);
  wall.pose.r = {1 + 2 * r + distance, 0, 0};
  d.shapes = {wall};
  const Model model = ModelBuilder(d).build();
  const Numbers q = joined(0, at({r, 0, 0})), v = joined(speed, Numbers(6));
  const Tolerances tolerances{.relative = 1e-6, .absolute = 1e-6};
  for (const Trajectory& motion :
       {simulate_contact(model, q, v, 1, 1e-3), simulate_contact(model, q, v, 1, tolerances),
        simulate_contact_exact(model, q, v, 1, tolerances)}) {
    EXPECT_FALSE(motion.complete);
    EXPECT_NEAR(motion.t().back(), distance / speed, 2e-3);
    EXPECT_THAT(motion.stop_reason, testing::AnyOf(HasSubstr("block the prescribed motion of \"rail\""),
                                                   HasSubstr("no impulses were found")));
  }
}

TEST(ContactSimulation, RefusesWhatItDoesNotCount) {
  const auto refusal = [](const Description& description, const SimulationOptions& options) {
    try {
      static_cast<void>(with_stop(description, options));
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  SimulationOptions options{.local_coordinates = LocalCoordinates::cayley};
  EXPECT_EQ(refusal(block_with_stop(), options),
            "contact needs local_coordinates = \"exponential\"; got \"cayley\"");
  options = {.coordinates = Coordinates::absolute};
  EXPECT_EQ(refusal(block_with_stop(), options),
            "contact needs coordinates = \"relative\"; got \"absolute\"");
}

}  // namespace
}  // namespace axode::test
