#include "axode/integration/exact/simulate_contact_exact.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "axode/dynamics/momentum/momentum.hpp"
#include "axode/integration/exact/central_load.hpp"
#include "axode/integration/simulation.hpp"
#include "tests/contact/scene.hpp"
#include "tests/support/random_loops.hpp"

/// Motions with contact in smooth phases, whose events have times in closed form.
namespace axode::test {
namespace {

using Kind = Trajectory::ContactEvent::Kind;

constexpr double time_tolerance = 1e-12;
constexpr Tolerances tight{.relative = 1e-12, .absolute = 1e-12};

std::vector<double> times_of(const Trajectory& motion, Kind kind) {
  std::vector<double> times;
  for (const Trajectory::ContactEvent& event : motion.contact_events)
    if (event.kind == kind) times.push_back(event.t);
  return times;
}
void expect_lawful(const Trajectory& motion) {
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  ASSERT_EQ(motion.certificates.size(), motion.size() - 1);
  for (const double certificate : motion.certificates) EXPECT_LE(certificate, 1e-9);
}
/// A drive of one joint by a function of time.
SimulationOptions driven(std::size_t velocity, std::function<double(double)> force) {
  SimulationOptions options;
  options.drive = [velocity, force](double t, std::span<const double>, std::span<const double>,
                                    std::span<double> tau) {
    std::ranges::fill(tau, 0.0);
    tau[velocity] = force(t);
  };
  return options;
}
/// The root of a function that changes its sign between two numbers.
double root(double low, double high, const std::function<double(double)>& f) {
  const bool rises = f(low) < 0;
  for (int k = 0; k < 100; ++k) {
    const double middle = low + (high - low) / 2;
    ((f(middle) < 0) == rises ? low : high) = middle;
  }
  return high;
}

TEST(ExactContact, ABallBouncesAtTheTimesOfItsRestitution) {
  const double e = 0.8, height = 0.5;
  Scene scene({.restitution = e});
  scene.description.contact->threshold = 1e-3;
  const Model model = scene.add("ball", ShapeKind::sphere, 0.1, {.friction = 0}).build();
  const Trajectory motion =
      simulate_contact_exact(model, at({0, 0, 0.1 + height}), std::vector<double>(6), 4, tight);
  expect_lawful(motion);
  double speed = std::sqrt(2 * g * height), t = speed / g;
  const std::vector<double> bounces = times_of(motion, Kind::bounce), closes = times_of(motion, Kind::close);
  ASSERT_GT(bounces.size(), 30u);
  for (const double found : bounces) {
    EXPECT_NEAR(found, t, time_tolerance);
    speed *= e;
    t += 2 * speed / g;
  }
  ASSERT_EQ(closes.size(), 1u);
  EXPECT_NEAR(closes[0], t, time_tolerance);
  EXPECT_NEAR(last(motion, false)[6], 0.1, 1e-14);
  EXPECT_LE(largest(last(motion, true)), 1e-14);
}

/// Without a threshold, infinitely many bounces end at a finite time.
TEST(ExactContact, BouncesBelowRoundingEndAndAreReported) {
  const double e = 0.5, height = 0.5;
  Scene scene({.restitution = e});
  scene.description.contact->threshold = 0;
  const Model model = scene.add("ball", ShapeKind::sphere, 0.1, {.friction = 0}).build();
  const Trajectory motion =
      simulate_contact_exact(model, at({0, 0, 0.1 + height}), std::vector<double>(6), 2, tight);
  expect_lawful(motion);
  ASSERT_FALSE(motion.contact_events.empty());
  EXPECT_TRUE(motion.contact_events.back().shortened);
  const double fall = std::sqrt(2 * height / g);
  EXPECT_NEAR(motion.contact_events.back().t, fall * (1 + 2 * e / (1 - e)), 1e-5);
  EXPECT_LE(largest(last(motion, true)), 1e-12);
}

TEST(ExactContact, ABallSlidesAndThenRolls) {
  const double mu = 0.3, speed = 2;
  const Model model = Scene({.friction = mu}).add("ball", ShapeKind::sphere, 0.1, {.friction = mu}).build();
  const Trajectory motion =
      simulate_contact_exact(model, at({0, 0, 0.1}), std::vector<double>{0, 0, 0, speed, 0, 0}, 1, tight);
  expect_lawful(motion);
  const std::vector<double> sticks = times_of(motion, Kind::stick);
  ASSERT_EQ(sticks.size(), 1u);
  const double t = 2 * speed / (7 * mu * g);
  EXPECT_NEAR(sticks[0], t, time_tolerance);
  const double way = speed * t - mu * g * t * t / 2 + 5.0 / 7 * speed * (1 - t);
  EXPECT_NEAR(last(motion, false)[4], way, 1e-11);
}

/// A ball that slides across its spin: the sliding velocity keeps its direction, and the path is a parabola.
TEST(ExactContact, ABallWithSideSpinRollsAtTheTimeOfItsSlip) {
  const double mu = 0.2, r = 0.1;
  const Model model = Scene({.friction = mu}).add("ball", ShapeKind::sphere, r, {.friction = mu}).build();
  const std::vector<double> v{4, 9, -3, 0.7, 0.4, 0};
  const Trajectory motion = simulate_contact_exact(model, at({0, 0, r}), v, 1, tight);
  expect_lawful(motion);
  const double slip = std::hypot(v[3] - r * v[1], v[4] + r * v[0]);
  const std::vector<double> sticks = times_of(motion, Kind::stick);
  ASSERT_EQ(sticks.size(), 1u);
  EXPECT_NEAR(sticks[0], 2 * slip / (7 * mu * g), time_tolerance);
}

/// A swinging force lets a box slip, stop, stick and slip again.
TEST(ExactContact, ABoxUnderASwingingForceSlipsAndStops) {
  const double mu = 0.4, force = 6, rate = 3, half = 0.1;
  const Model model = Scene({.friction = mu}).add("box", ShapeKind::box, half, {.friction = mu}).build();
  const Trajectory motion =
      simulate_contact_exact(model, at({0, 0, half}), std::vector<double>(6), 1.7, tight,
                             driven(3, [&](double t) { return force * std::sin(rate * t); }));
  expect_lawful(motion);
  const double slip = std::asin(mu * g / force) / rate;
  const double stop = root(slip + 0.1, slip + 1.2, [&](double t) {
    return -force / rate * (std::cos(rate * t) - std::cos(rate * slip)) - mu * g * (t - slip);
  });
  const std::vector<double> slips = times_of(motion, Kind::slip), sticks = times_of(motion, Kind::stick),
                            reversals = times_of(motion, Kind::reverse);
  ASSERT_GE(slips.size(), 4u);
  EXPECT_NEAR(slips[0], slip, time_tolerance);
  ASSERT_GE(sticks.size() + reversals.size(), 4u);
  EXPECT_NEAR(sticks.empty() ? reversals[0] : sticks[0], stop, time_tolerance);
}

/// The four corners of a box, which share its weight, stop together, although their velocities have rounding
/// errors.
TEST(ExactContact, ABoxUnderAnySwingingForceSlipsAndStops) {
  const double mu = 0.4, half = 0.1;
  const Model model = Scene({.friction = mu}).add("box", ShapeKind::box, half, {.friction = mu}).build();
  for (const double rate : {2.0, 4.3})
    for (double force = 4.5; force < 8; force += 0.7) {
      SCOPED_TRACE(std::to_string(force) + " N, " + std::to_string(rate) + " rad/s");
      expect_lawful(simulate_contact_exact(model, at({0, 0, half}), std::vector<double>(6), 1.7, tight,
                                           driven(3, [&](double t) { return force * std::sin(rate * t); })));
    }
}

TEST(ExactContact, ABoxSlidesUpAnInclineAndSticks) {
  const double angle = 20 * std::acos(-1.0) / 180, half = 0.1, speed = 1.5;
  for (const double mu : {0.5, 0.3}) {
    const Model model =
        Scene({.friction = mu}, angle).add("box", ShapeKind::box, half, {.friction = mu}).build();
    const Vec3<> n{std::sin(angle), 0, std::cos(angle)};
    std::vector<double> v{0, 0, 0, -speed, 0, 0};  // body axes
    const Trajectory motion = simulate_contact_exact(model, at(half * n, angle), v, 1, tight);
    expect_lawful(motion);
    const double stop = speed / (g * (std::sin(angle) + mu * std::cos(angle)));
    const bool holds = mu > std::tan(angle);
    const std::vector<double> times = times_of(motion, holds ? Kind::stick : Kind::reverse);
    ASSERT_EQ(times.size(), 4u);
    for (const double t : times) EXPECT_NEAR(t, stop, time_tolerance);
    const double down = g * (std::sin(angle) - mu * std::cos(angle)) * (1 - stop);
    EXPECT_NEAR(last(motion, true)[3], holds ? 0 : down, 1e-12);
  }
}

/// A box is pushed below its centre by a force that grows in time.
TEST(ExactContact, ABoxSlipsWhereTheForceExceedsFriction) {
  const double mu = 0.4, half = 0.1, growth = 5;
  const Model model = Scene({.friction = mu}).add("box", ShapeKind::box, half, {.friction = mu}).build();
  const Trajectory motion = simulate_contact_exact(model, at({0, 0, half}), std::vector<double>(6), 1.2,
                                                   tight, driven(3, [&](double t) { return growth * t; }));
  expect_lawful(motion);
  const double slip = mu * g / growth;
  const std::vector<double> slips = times_of(motion, Kind::slip);
  ASSERT_EQ(slips.size(), 4u);
  for (const double t : slips) EXPECT_NEAR(t, slip, time_tolerance);
  EXPECT_NEAR(last(motion, true)[3], growth * std::pow(1.2 - slip, 2) / 2, 1e-11);
}

/// With much friction the same box tips about an edge.
TEST(ExactContact, ABoxTipsWhereTheForceExceedsItsWeight) {
  const double half = 0.1, growth = 10;
  const Model model = Scene({.friction = 2}).add("box", ShapeKind::box, half, {.friction = 2}).build();
  const auto move = [&](double until) {
    return simulate_contact_exact(model, at({0, 0, half}), std::vector<double>(6), until, tight,
                                  driven(3, [&](double t) { return growth * t; }));
  };
  const Trajectory motion = move(1.1);
  expect_lawful(motion);
  const std::vector<double> opens = times_of(motion, Kind::open);
  ASSERT_EQ(opens.size(), 2u);
  for (const double t : opens) EXPECT_NEAR(t, g / growth, time_tolerance);
  // Motions end a moment later, before the gaps are larger than rounding errors of places.
  for (double moment = 1e-6; moment > 1e-13; moment /= 10) {
    const Trajectory brief = move(g / growth + moment);
    ASSERT_TRUE(brief.complete) << brief.stop_reason;
    for (const double certificate : brief.certificates) EXPECT_LE(certificate, 1e-8);
    EXPECT_LE(times_of(brief, Kind::open).size(), 2u);
  }
}

/// Places of large bodies have larger rounding errors.
TEST(ExactContact, BoxesOfKilometresMoveToTheEnd) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random<double> random(seed);
    const double half = 1e4;
    const Model model = Scene({.friction = 0.5}).add("box", ShapeKind::box, half, {.friction = 0.5}).build();
    std::vector<double> q = at({0, 0, 2 * half});
    q = integrate(model, q, std::vector<double>{random.number(-2, 2), random.number(-2, 2), 1, 0, 0, 0});
    const Trajectory motion =
        simulate_contact_exact(model, q, std::vector<double>(6), 200, {.relative = 1e-7, .absolute = 1e-7});
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_FALSE(motion.contact_events.empty());
  }
}

/// A square table that reaches from x[0] to x[1] and as far along y. Its top is at z = 0.
Scene table(const std::array<double, 2>& x, double friction) {
  Scene scene({});
  ShapeDescription top = touching(ShapeKind::box, {.friction = friction});
  top.name = "table";
  top.size = {x[1] - x[0], x[1] - x[0], 0.2};
  top.pose.r = {(x[0] + x[1]) / 2, 0, -0.1};
  scene.description.shapes = {top};
  return scene;
}

/// A box slides over the edge of a table, corner after corner, and tips where the centre of its load reaches
/// the edge. With friction this centre is μ h before the centre of mass, at the height h.
TEST(ExactContact, ABoxTipsOverTheEdgeOfATable) {
  const double half = 0.1, way = 0.3;
  for (const double mu : {0.0, 0.2}) {
    for (const double yaw : {0.0, 0.3, 0.7}) {
      SCOPED_TRACE(std::to_string(mu) + ", " + std::to_string(yaw));
      const double speed = mu > 0 ? 1.5 : 0.5, left = way - mu * half;
      const Model model = table({-1, 0}, mu).add("box", ShapeKind::box, half, {.friction = mu}).build();
      const std::vector<double> q{0, 0, std::sin(yaw / 2), std::cos(yaw / 2), -way, 0, half},
          v{0, 0, 0, speed * std::cos(yaw), -speed * std::sin(yaw), 0};
      const double tips =
          mu > 0 ? (speed - std::sqrt(speed * speed - 2 * mu * g * left)) / (mu * g) : left / speed;
      const Trajectory motion = simulate_contact_exact(model, q, v, tips + 0.1, tight);
      expect_lawful(motion);
      const std::vector<double> opens = times_of(motion, Kind::open);
      ASSERT_GE(opens.size(), 2u);
      EXPECT_NEAR(opens[0], tips, time_tolerance);
      EXPECT_NEAR(opens[1], tips, time_tolerance);
      const Trajectory steps = simulate_contact(model, q, v, tips + 0.1, 2e-4);
      for (std::size_t c = 0; c < 7; ++c) EXPECT_NEAR(last(motion, false)[c], last(steps, false)[c], 1e-5);
    }
  }
}

/// A frictionless ball on a fixed ball leaves it where cos θ has fallen to 2/3 of its value at rest.
TEST(ExactContact, ABallLeavesASphereAtTwoThirdsOfItsHeight) {
  const double R = 0.5, r = 0.1, start = 0.3;
  Scene scene({.friction = 0});
  scene.description.shapes[0] = touching(ShapeKind::sphere, {.friction = 0}, R);
  scene.description.shapes[0].name = "dome";
  const Model model = scene.add("ball", ShapeKind::sphere, r, {.friction = 0}).build();
  const Trajectory motion =
      simulate_contact_exact(model, at({(R + r) * std::sin(start), 0, (R + r) * std::cos(start)}),
                             std::vector<double>(6), 0.6, tight);
  expect_lawful(motion);
  const std::vector<double> opens = times_of(motion, Kind::open);
  ASSERT_EQ(opens.size(), 1u);
  std::vector<double> q(7), v(6);
  motion.at(opens[0], q, v);
  EXPECT_NEAR(q[6] / (R + r), 2.0 / 3 * std::cos(start), 1e-10);
}

/// Rolling friction and sliding friction have one cone; a ball that only spins is stopped by drilling friction.
TEST(ExactContact, DrillingFrictionStopsASpin) {
  const double r = 0.1, spin = 20, length = 2e-3;
  const ContactProperties surface{.friction = 0.5, .spin_friction = length};
  const Model model = Scene(surface).add("ball", ShapeKind::sphere, r, surface).build();
  const Trajectory motion =
      simulate_contact_exact(model, at({0, 0, r}), std::vector<double>{0, 0, spin, 0, 0, 0}, 6, tight);
  expect_lawful(motion);
  const std::vector<double> sticks = times_of(motion, Kind::stick);
  ASSERT_EQ(sticks.size(), 1u);
  EXPECT_NEAR(sticks[0], 0.4 * r * r * spin / (length * g), time_tolerance);
}

Model slider(const Dof& dof) {
  Description d;
  BodyDescription body{.name = "slider"};
  body.joint = {.kind = JointKind::prismatic, .axis = {0, 0, 1}, .dof = {dof}};
  body.inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1, 0, 0, 0}};
  d.bodies.push_back(body);
  d.contact = ContactDescription{.threshold = 1e-2};
  return ModelBuilder(d).build();
}

TEST(ExactContact, ASliderBouncesOnItsStop) {
  const double e = 0.7, height = 0.3;
  const Model model = slider({.lower = 0, .hard_stops = true, .restitution = e});
  const Trajectory motion =
      simulate_contact_exact(model, std::vector<double>{height}, std::vector<double>{0}, 2, tight);
  expect_lawful(motion);
  double speed = std::sqrt(2 * g * height), t = speed / g;
  const std::vector<double> bounces = times_of(motion, Kind::bounce);
  ASSERT_GT(bounces.size(), 10u);
  for (const double found : bounces) {
    EXPECT_NEAR(found, t, time_tolerance);
    speed *= e;
    t += 2 * speed / g;
  }
  EXPECT_EQ(last(motion, true)[0], 0);
}

/// Dry friction holds a slider against its weight until a force that swings makes it slide.
TEST(ExactContact, ADryJointSlidesAndStops) {
  const double friction = 8, force = 8, rate = 4;
  const Model model = slider({.friction = friction});
  SimulationOptions options = driven(0, [&](double t) { return g + force * (t + std::sin(rate * t)); });
  options.joint_losses = true;
  const Trajectory motion =
      simulate_contact_exact(model, std::vector<double>{0}, std::vector<double>{0}, 1.5, tight, options);
  expect_lawful(motion);
  const auto push = [&](double t) { return force * (t + std::sin(rate * t)) - friction; };
  const double slip = root(0, 0.7, push);
  const auto speed = [&](double t) {
    const auto integral = [&](double s) {
      return force * (s * s / 2 - std::cos(rate * s) / rate) - friction * s;
    };
    return integral(t) - integral(slip);
  };
  const std::vector<double> slips = times_of(motion, Kind::slip), sticks = times_of(motion, Kind::stick);
  ASSERT_GE(slips.size(), 1u);
  EXPECT_NEAR(slips[0], slip, time_tolerance);
  ASSERT_GE(sticks.size(), 1u);
  EXPECT_NEAR(sticks[0], root(slip + 0.2, slip + 1, speed), time_tolerance);
}

TEST(ExactContact, FrictionTakesTheEnergyOfItsWay) {
  const double mu = 0.4, speed = 1.7, half = 0.1;
  const Model model = Scene({.friction = mu}).add("box", ShapeKind::box, half, {.friction = mu}).build();
  const Trajectory motion =
      simulate_contact_exact(model, at({0, 0, half}), std::vector<double>{0, 0, 0, speed, 0, 0}, 1, tight);
  expect_lawful(motion);
  for (std::size_t k = 0; k < motion.size(); ++k) {
    const double way = motion.q(k)[4];
    EXPECT_NEAR(energy_at(model, motion, 0) - energy_at(model, motion, k), mu * g * way, 1e-11);
  }
  EXPECT_NEAR(last(motion, false)[4], speed * speed / (2 * mu * g), 1e-11);
}

/// A capsule that bounces without losses keeps its energy, whichever of its ends touches.
TEST(ExactContact, ElasticImpactsKeepTheEnergy) {
  Scene scene({.restitution = 1});
  scene.add("rod", ShapeKind::capsule, 0.05, {.friction = 0});
  scene.description.bodies[0].shapes[0].length = 0.4;
  const Model model = scene.build();
  const Trajectory motion =
      simulate_contact_exact(model, at({0, 0, 0.6}, 0.5), std::vector<double>(6), 2, tight);
  expect_lawful(motion);
  EXPECT_GT(times_of(motion, Kind::bounce).size(), 4u);
  for (std::size_t k = 0; k < motion.size(); ++k)
    EXPECT_NEAR(energy_at(model, motion, k), energy_at(model, motion, 0), 1e-9);
}

TEST(ExactContact, TwoBallsLandTogetherAndKeepTheirTimes) {
  const double e = 0.5, height = 0.2;
  Scene scene({.friction = 0.3, .restitution = e});
  scene.add("a", ShapeKind::sphere, 0.1, {.friction = 0.3})
      .add("b", ShapeKind::sphere, 0.15, {.friction = 0.3});
  const Model model = scene.build();
  std::vector<double> q = at({0, 0, 0.1 + height}), other = at({1, 0, 0.15 + height});
  q.insert(q.end(), other.begin(), other.end());
  const Trajectory motion = simulate_contact_exact(model, q, std::vector<double>(12), 0.5, tight);
  expect_lawful(motion);
  const std::vector<double> bounces = times_of(motion, Kind::bounce);
  ASSERT_EQ(bounces.size(), 4u);
  const double fall = std::sqrt(2 * height / g);
  for (const std::size_t k : {0u, 1u}) EXPECT_NEAR(bounces[k], fall, time_tolerance);
  for (const std::size_t k : {2u, 3u}) EXPECT_NEAR(bounces[k], 2 * fall, time_tolerance);
}

/// An eccentric ball rolls, slides and hops. Short steps of the other method come to the same motion.
TEST(ExactContact, AgreesWithShortStepsOfTheSteppingMethod) {
  const double mu = 0.15;
  Scene scene({.friction = mu});
  scene.add("ball", ShapeKind::sphere, 0.1, {.friction = mu});
  scene.description.bodies[0].inertia->com = {0.03, 0, 0};
  const Model model = scene.build();
  const std::vector<double> v{0, 3, 0, 0.6, 0.2, 0};
  const Trajectory motion = simulate_contact_exact(model, at({0, 0, 0.1}), v, 0.8, tight);
  expect_lawful(motion);
  EXPECT_FALSE(motion.contact_events.empty());
  const Trajectory steps = simulate_contact(model, at({0, 0, 0.1}), v, 0.8, 2e-4);
  for (std::size_t c = 0; c < 7; ++c) EXPECT_NEAR(last(motion, false)[c], last(steps, false)[c], 2e-4);
}

/// A terminal event of the caller ends a motion with the accelerations and forces of contact at this time.
TEST(ExactContact, AnEventOfTheCallerEndsTheMotion) {
  const double mu = 0.4, half = 0.1;
  const Model model = Scene({.friction = mu}).add("box", ShapeKind::box, half, {.friction = mu}).build();
  SimulationOptions options;
  options.events.push_back(
      {.value = [](double, std::span<const double> q, std::span<const double>) { return q[4] - 0.2; },
       .terminal = true});
  const Trajectory motion = simulate_contact_exact(model, at({0, 0, half}),
                                                   std::vector<double>{0, 0, 0, 2, 0, 0}, 1, tight, options);
  expect_lawful(motion);
  const std::size_t k = motion.size() - 1;
  EXPECT_NEAR(motion.q(k)[4], 0.2, 1e-12);
  EXPECT_NEAR(motion.a(k)[3], -mu * g, 1e-11);
  double pressed = 0;
  for (const ContactForce& contact : motion.contacts(k)) pressed += contact.force.z;
  EXPECT_NEAR(pressed, g, 1e-10);
}

TEST(ExactContact, RefusesOverlapAndCompliance) {
  const Model model = Scene({.friction = 0.5}).add("ball", ShapeKind::sphere, 0.1, {.friction = 0.5}).build();
  const Trajectory motion = simulate_contact_exact(model, at({0, 0, 0.09}), std::vector<double>(6), 1, tight);
  EXPECT_FALSE(motion.complete);
  EXPECT_NE(motion.stop_reason.find("overlap by 0.01"), std::string::npos) << motion.stop_reason;
  const ContactProperties soft{.friction = 0.5, .stiffness = 1e5};
  const Model compliant = Scene({.friction = 0.5}).add("ball", ShapeKind::sphere, 0.1, soft).build();
  EXPECT_THROW(
      static_cast<void>(simulate_contact_exact(compliant, at({0, 0, 0.2}), std::vector<double>(6), 1)),
      std::invalid_argument);
}

/// A mechanism that floats freely, under gravity and with hard stops that it meets, keeps the momentum about
/// its centre of mass, because stops push on two bodies.
TEST(ExactContact, AFloatingTreeWithStopsKeepsItsMomentum) {
  std::size_t met = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Random<double> random(seed);
    const Model model = floating_tree_with_stops(random, 0.3);
    if (model.n_bodies() < 2) continue;
    const std::vector<double> q = neutral(model), v = random_numbers(random, model.nv());
    const Trajectory motion =
        simulate_contact_exact(model, q, v, 0.5, {.relative = 1e-10, .absolute = 1e-11});
    expect_lawful(motion);
    met += motion.contact_events.size();
    Workspace<> workspace(model);
    const auto momentum = [&](std::size_t k) {
      return centroidal_momentum<double>(model, workspace, motion.q(k), motion.v(k));
    };
    const auto first = momentum(0), end = momentum(motion.size() - 1);
    const double size = 1 + norm(first.l) + norm(first.p);
    EXPECT_LE(norm(end.l - first.l), 1e-8 * size) << "seed " << seed;
    const ContactSystem system(model);
    for (const JointStop& stop : system.stops())
      EXPECT_GE(stop.room(motion.q(motion.size() - 1).data()), -1e-12);
  }
  EXPECT_GE(met, 5u) << "events at stops";
}

/// Without contact the exact mode is the method of simulate(), and loops stay closed.
TEST(ExactContact, LoopsMoveAsWithoutContact) {
  int loops = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random<double> random(seed);
    const ClosedMechanism mechanism =
        closed_mechanism(random, {.most_bodies = 6, .couplings = false, .springs = 0});
    const Model& model = mechanism.model;
    if (model.loops().empty()) continue;
    const auto& [q, v] = std::pair(mechanism.state.q, mechanism.state.v);
    const Tolerances tolerances{.relative = 1e-10, .absolute = 1e-11};
    const Trajectory free = simulate(model, q, v, 0.2, tolerances);
    const Trajectory motion = simulate_contact_exact(model, q, v, 0.2, tolerances);
    if (!free.complete) continue;
    ++loops;
    ASSERT_TRUE(motion.complete) << "seed " << seed << ": " << motion.stop_reason;
    const std::vector<double> found = last(motion, false), expected = last(free, false);
    for (const double d : difference(model, expected, found)) EXPECT_NEAR(d, 0, 1e-6) << "seed " << seed;
  }
  EXPECT_GE(loops, 3);
}

/// A box that slides and spins on four points, whose shares of the load decide its motion.
TEST(ExactContact, PointsShareALoadAsEqualSpringsDoWhileTheySlideInDifferentDirections) {
  const auto box = [](double friction, const ContactProperties& side) {
    Scene scene({.friction = friction});
    scene.add("box", ShapeKind::box, 0.1, side);
    return scene.build();
  };
  for (const double friction : {0.3, 0.45, 0.6}) {
    const Model rigid = box(friction, {.friction = friction});
    constexpr double stiffness = 1e5;
    const Model soft =
        box(friction, {.friction = friction, .stiffness = stiffness, .exponent = 1, .damping = 20});
    const std::vector<double> v{0, 0, 6, 1.5, 0.3, 0};
    const Trajectory motion = simulate_contact_exact(rigid, at({0, 0, 0.1}), v, 0.3, tight);
    expect_lawful(motion);
    std::vector<double> pressed = at({0, 0, 0.1});
    const double weight = rigid.body(1).M.m * norm(rigid.gravity());
    pressed[6] -= weight / (4 * stiffness);
    const Trajectory on_springs = simulate_contact(soft, pressed, v, 0.3, 1e-4);
    ASSERT_TRUE(on_springs.complete) << on_springs.stop_reason;
    const std::vector<double> apart = difference(rigid, last(motion, false), last(on_springs, false));
    for (const double d : apart) EXPECT_NEAR(d, 0, 1e-4);
    EXPECT_GT(last(motion, false)[2], 0.1);  // it has turned
  }
}

/// A box under forces above its centre that turn while it slides, stops and begins to slide.
TEST(ExactContact, ABoxUnderForcesThatTurnMovesToTheEnd) {
  Scene scene({.friction = 0.4});
  const Model model = scene.add("box", ShapeKind::box, 0.1, {.friction = 0.4}).build();
  std::size_t events = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Random<double> random(seed);
    std::array<std::array<double, 3>, 6> waves;
    for (std::array<double, 3>& it : waves)
      it = {random.number(0.5, 3), random.number(1, 12), random.number(0, 6)};
    const double m = model.body(1).M.m;
    SimulationOptions options;
    options.drive = [&](double t, std::span<const double>, std::span<const double>, std::span<double> tau) {
      std::array<double, 2> f{};
      for (std::size_t k = 0; k < waves.size(); ++k)
        f[k % 2] += m * waves[k][0] * std::sin(waves[k][1] * t + waves[k][2]);
      const std::array<double, 6> wrench{-0.05 * f[1], 0.05 * f[0], 0, f[0], f[1], 0};
      std::ranges::copy(wrench, tau.begin());
    };
    const Trajectory motion = simulate_contact_exact(model, at({0, 0, 0.1}), std::vector<double>(6), 1,
                                                     {.relative = 1e-8, .absolute = 1e-8}, options);
    expect_lawful(motion);
    events += motion.contact_events.size();
  }
  EXPECT_GE(events, 20U);
}

/// Adds a body to a scene, throws it in a random way, and checks that it moves to the end and gains no energy.
/// Returns whether impacts without end were cut short.
bool throw_body(Random<double>& random, Scene& scene, ShapeKind kind, double friction) {
  scene.add("body", kind, 0.1, {.friction = friction, .restitution = random.number(0, 0.5)});
  BodyDescription& body = scene.description.bodies.back();
  body.shapes[0].size.x *= 1.5;
  body.shapes[0].length = 0.3;
  body.shapes[0].pose.r = {0, random.number(0, 0.05), 0};
  const Model model = scene.build();
  std::vector<double> q = at({0, 0, 0.5});
  q = integrate(model, q, std::vector<double>{random.number(-2, 2), random.number(-2, 2), 1, 0, 0, 0});
  const Trajectory motion = simulate_contact_exact(model, q, random_numbers(random, 6, 2), 1.5,
                                                   {.relative = 1e-10, .absolute = 1e-10});
  EXPECT_TRUE(motion.complete) << motion.stop_reason;
  for (const double certificate : motion.certificates) EXPECT_LE(certificate, 1e-6);
  double before = energy_at(model, motion, 0);
  for (std::size_t k = 1; k < motion.size(); ++k) {
    const double now = energy_at(model, motion, k);
    EXPECT_LE(now, before + 1e-8) << motion.t()[k];
    before = now;
  }
  return std::ranges::any_of(motion.contact_events, &Trajectory::ContactEvent::shortened);
}

/// Bodies that are thrown land, rock and roll without end. Rocking takes infinitely many impacts in a finite
/// time, of which the last ones are left out.
TEST(ExactContact, BodiesThatAreThrownMoveToTheEnd) {
  int rocked = 0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random<double> random(seed);
    const double friction = random.number(0, 1);
    Scene scene({.friction = friction}, seed % 2 == 0 ? 0 : random.number(0, 0.3));
    const ShapeKind kind =
        std::array{ShapeKind::box, ShapeKind::box, ShapeKind::sphere, ShapeKind::capsule}[seed % 4];
    rocked += throw_body(random, scene, kind, friction) ? 1 : 0;
  }
  EXPECT_GE(rocked, 3);
}

/// Boxes that are thrown on a small table slide and tip over its edges and corners.
TEST(ExactContact, BoxesThatAreThrownOnATableMoveToTheEnd) {
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random<double> random(seed);
    const double friction = random.number(0, 1);
    Scene scene = table({-0.15, 0.15}, friction);
    throw_body(random, scene, ShapeKind::box, friction);
  }
}

/// The sliding velocity of a ball whose centre of mass is aside falls to 1e-6 m/s and turns to another
/// direction within a microsecond. A step that ends there must be as accurate as any other: friction makes no
/// energy.
TEST(ExactContact, ASlideThatTurnsNearRestIsAccurate) {
  Scene scene({.friction = 0.803134});
  scene.description.shapes[0].pose.R = exp_SO3(Vec3<>{0.209447, 0, 0});
  scene.add("ball", ShapeKind::sphere, 0.1, {.friction = 0.803134});
  scene.description.bodies.back().inertia =
      MassProperties{.mass = 1, .com = {0, 0.042219, 0}, .Theta = {0.006, 0.007, 0.008, 0, 0, 0}};
  const Model model = scene.build();
  const std::vector<double> q{
      -0.5373824286047505, 0.33943825733827804, 0.65129843765360151, -0.41450227983931648, 0, 0, 0.5};
  const std::vector<double> v{1.0198393431214265, -0.19183049175234679, 1.0333814302999693,
                              1.1100378726531672, 0.01374770068525244,  -0.64361647471089034};
  for (const double tolerance : {1e-8, 1e-10}) {
    const Trajectory motion =
        simulate_contact_exact(model, q, v, 1.5, {.relative = tolerance, .absolute = tolerance});
    expect_lawful(motion);
    for (std::size_t k = 1; k < motion.size(); ++k)
      EXPECT_LE(energy_at(model, motion, k), energy_at(model, motion, k - 1) + 0.1 * tolerance)
          << motion.t()[k];
  }
}

/// The gap of the rim of a cylinder that tumbles is no polynomial over a long step after a small bounce.
TEST(ExactContact, AFlightThatIsShorterThanAStepIsFound) {
  Scene scene({.friction = 0.144});
  scene.description.shapes[0].pose.R = exp_SO3(Vec3<>{0.0691702, 0, 0});
  scene.add("cylinder", ShapeKind::cylinder, 0.1, {.friction = 0.144, .restitution = 0.0353});
  BodyDescription& body = scene.description.bodies.back();
  body.shapes[0].length = 0.3;
  body.inertia =
      MassProperties{.mass = 1, .com = {0.0327147, 0.0420988, 0}, .Theta = {0.006, 0.007, 0.008, 0, 0, 0}};
  const Model model = scene.build();
  const std::vector<double> v{0, 0, 0.50769461, 0.065708775, 0.22804059, 1.96057752};
  const Trajectory motion =
      simulate_contact_exact(model, at({0, 0, 0.35}), v, 0.7, {.relative = 1e-9, .absolute = 1e-9});
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  for (std::size_t k = 0; k < motion.size(); ++k)
    for (const ContactForce& at_step : motion.contacts(k)) EXPECT_GE(at_step.gap, -1e-9) << motion.t()[k];
}

/// Two supports share a load in any way; of all ways the even one has the largest reserve.
TEST(CentralLoad, SharesALoadEvenly) {
  std::vector<LoadCondition> conditions(2);
  conditions[1].normal = 1;
  Eigen::VectorXd lambda{{3.0, -1.0}};
  EXPECT_NEAR(maximise_reserve(conditions, Eigen::MatrixXd{{1.0}, {-1.0}}, 10, lambda), 1, 1e-12);
  EXPECT_NEAR(lambda[0], 1, 1e-12);
}

/// Two cones with opposite loads along a line: the reserve of the cones is found, and negative if none holds.
TEST(CentralLoad, FindsTheReserveOfCones) {
  std::vector<LoadCondition> conditions(2);
  for (int k = 0; k < 2; ++k) {
    conditions[static_cast<std::size_t>(k)].normal = 2 * k;
    conditions[static_cast<std::size_t>(k)].tangent = {2 * k + 1};
    conditions[static_cast<std::size_t>(k)].factors = Eigen::VectorXd::Constant(1, 2.0);  // μ = 1/2
  }
  const Eigen::MatrixXd basis{{0.0}, {1.0}, {0.0}, {-1.0}};
  for (const double push : {0.8, 1.2}) {  // both hold push/2 with the normal forces 1
    Eigen::VectorXd lambda{{1.0, push + 3, 1.0, -3.0}};
    EXPECT_NEAR(maximise_reserve(conditions, basis, 10, lambda), 1 - push, 1e-12);
  }
}

}  // namespace
}  // namespace axode::test
