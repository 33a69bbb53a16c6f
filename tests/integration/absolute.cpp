#include <gmock/gmock.h>

#include "axode/constraints/absolute/absolute_system.hpp"
#include "axode/constraints/loops.hpp"
#include "axode/dynamics.hpp"
#include "axode/io.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/integration/motions.hpp"

/// Motion in absolute coordinates, with results in the coordinates of the joints.
namespace axode::test {
namespace {

constexpr std::array absolute_kinds{Coordinates::absolute, Coordinates::absolute_SO3xR3,
                                    Coordinates::absolute_by_joint};

SimulationOptions in(Coordinates coordinates, SimulationOptions options = {}) {
  options.coordinates = coordinates;
  return options;
}

double error_of(const Trajectory& motion, const Trajectory& exact) {
  double most = apart(motion.model(), last_q(motion), last_q(exact));
  for (std::size_t c = 0; c < last_v(motion).size(); ++c)
    most = std::max(most, std::abs(last_v(motion)[c] - last_v(exact)[c]));
  return most;
}

TEST(AbsoluteCoordinates, MoveRandomTreesAsTheirJointsDo) {
  int seen = 0, tried = 0;
  for (const Coordinates kind : absolute_kinds)
    for_seeds(20, [&](std::uint64_t seed) {
      ++tried;
      Random<double> random(seed);
      const Model model =
          ModelBuilder(described(random_mechanism(random, {.most_bodies = 6, .always_mass = true}), random))
              .build();
      const State<double> state = random_state(model, random);
      SimulationOptions options = driven_and_damped();
      options.loads = state.wrenches, options.joint_losses = false;
      const Trajectory joints = simulate(model, state.q, state.v, 0.1, {1e-10, 1e-12}, options);
      const Trajectory bodies = simulate(model, state.q, state.v, 0.1, {1e-10, 1e-12}, in(kind, options));
      if (!joints.complete) return;
      ++seen;
      ASSERT_TRUE(bodies.complete) << bodies.stop_reason;
      EXPECT_LT(error_of(bodies, joints),
                1e-5 * (1 + std::abs(last_v(joints).empty() ? 0 : last_v(joints)[0])));
    });
  EXPECT_GT(2 * seen, tried);
}

struct Scheme {
  const char* name;
  double order;
  Trajectory (*run)(const Model&, Span, Span, double, double, const SimulationOptions&);
};
const Scheme schemes[]{
    {"rk4", 4,
     [](const Model& m, Span q, Span v, double t, double h, const SimulationOptions& o) {
       return simulate_fixed(m, q, v, t, h, runge_kutta(4), o);
     }},
    {"RATTLE", 2,
     [](const Model& m, Span q, Span v, double t, double h, const SimulationOptions& o) {
       return simulate_rattle(m, q, v, t, h, 2, o);
     }},
    {"RATTLE, Suzuki", 4,
     [](const Model& m, Span q, Span v, double t, double h, const SimulationOptions& o) {
       return simulate_rattle(m, q, v, t, h, 4, o);
     }},
    {"half-explicit", 3,
     [](const Model& m, Span q, Span v, double t, double h, const SimulationOptions& o) {
       return simulate_half_explicit(m, q, v, t, h, o);
     }},
    {"generalised-alpha", 2,
     [](const Model& m, Span q, Span v, double t, double h, const SimulationOptions& o) {
       return simulate_stiff(m, q, v, t, h, 0.9, o);
     }},
    {"generalised-alpha, index 3", 2,
     [](const Model& m, Span q, Span v, double t, double h, const SimulationOptions& o) {
       return simulate_stiff(m, q, v, t, h, 0.9, o, false);
     }},
};

void expect_orders(const Model& model, Span q, Span v, double until, int steps,
                   const SimulationOptions& options) {
  const Trajectory exact = simulate(model, q, v, until, {1e-12, 1e-13}, options);
  for (const Coordinates kind : absolute_kinds)
    for (const auto& [name, order, run] : schemes) {
      SCOPED_TRACE(std::string(name) + (kind == Coordinates::absolute ? ", SE(3)" : ", SO(3) x R^3"));
      const Trajectory coarse = run(model, q, v, until, until / steps, in(kind, options));
      const Trajectory fine = run(model, q, v, until, until / (2 * steps), in(kind, options));
      ASSERT_TRUE(coarse.complete && fine.complete) << coarse.stop_reason << fine.stop_reason;
      const double error = error_of(fine, exact);
      EXPECT_LT(error, 0.02);
      if (error > 1e-8) {  // above this, rounding has no effect on the order yet
        EXPECT_GT(std::log2(error_of(coarse, exact) / error), order - 0.4) << "error " << error;
      }
    }
}

TEST(AbsoluteCoordinates, SchemesHaveTheirOrdersOnATreeWithDrivesAndDamping) {
  const Model model = test_tree();
  const State<double> state = test_state(model);
  expect_orders(model, state.q, state.v, 0.25, 50, driven_and_damped());
}

TEST(AbsoluteCoordinates, SchemesHaveTheirOrdersWithRotorsOfSeveralVelocities) {
  Random<double> random(5);
  Description tree{.name = "geared", .gravity = {0, 0, -9.81}, .bodies = {}, .frames = {}};
  tree.bodies.push_back(bar("ball", "ground", JointKind::spherical, {0, 0, 1}, {0, 0, 0}, {1, 0.2, 0}));
  tree.bodies.push_back(bar("plate", "ball", JointKind::planar, {0.6, 0, 0.8}, {1, 0.2, 0}, {1.5, 0, 0.3}));
  tree.bodies.push_back(bar("door", "plate", JointKind::revolute, {0, 1, 0}, {1.5, 0, 0.3}, {2, 0, 0}));
  for (BodyDescription& body : tree.bodies)
    body.joint.dof = {{.armature = 0.3}, {.armature = 0.7}, {.armature = 0.1}};
  tree.bodies[2].joint.dof.resize(1);
  const Model model = ModelBuilder(tree).build();
  const State<double> state = random_state(model, random);
  expect_orders(model, state.q, state.v, 0.5, 50, {});
  expect_orders(model, state.q, state.v, 0.5, 50, driven_and_damped());
}

TEST(AbsoluteCoordinates, SchemesHaveTheirOrdersOnMechanismsWithLoops) {
  for (const Description& description : {four_bar(), bricard(), gough()}) {
    SCOPED_TRACE(description.name);
    const Closed mechanism(description);
    expect_orders(mechanism.model, mechanism.at.q, mechanism.at.v, 0.1, 40, driven_and_damped());
  }
}

TEST(AbsoluteCoordinates, JointsAndLoopsHoldInPlacesAndVelocities) {
  const Closed mechanism(gough());
  LoopWorkspace<double> workspace(mechanism.model);
  Numbers r(static_cast<std::size_t>(mechanism.model.loops().residuals));
  for (const Coordinates kind : absolute_kinds)
    for (const auto& [name, order, run] : schemes) {
      SCOPED_TRACE(name);
      const Trajectory motion = run(mechanism.model, mechanism.at.q, mechanism.at.v, 0.02, 2e-3, in(kind));
      loop_residual<double>(mechanism.model, workspace, last_q(motion), r);
      for (const double open : r) EXPECT_NEAR(open, 0, 1e-11);
    }
}

TEST(AbsoluteCoordinates, RattleIsReversible) {
  const Closed mechanism(four_bar());
  for (const Coordinates kind : absolute_kinds)
    expect_way_back(mechanism.model, mechanism.at.q, mechanism.at.v, 1e-9, 0.01, [&](Span q, Span v) {
      return simulate_rattle(mechanism.model, q, v, 0.3, 2e-3, 2, in(kind));
    });
}

TEST(AbsoluteCoordinates, RattleKeepsTheEnergyInABand) {
  const Model model = test_tree({});
  const State<double> state = test_state(model);
  for (const Coordinates kind : absolute_kinds) {
    const Trajectory soon = simulate_rattle(model, state.q, state.v, 2.5, 1e-2, 2, in(kind));
    const Trajectory late = simulate_rattle(model, state.q, state.v, 10, 1e-2, 2, in(kind));
    ASSERT_TRUE(late.complete) << late.stop_reason;
    EXPECT_LT(energy_error(late), 5 * energy_error(soon));
  }
}

/// A mechanism that rolls in motion, with the forces that drive and damp it. The constraints of rolling are
/// constraints on velocities only.
struct Rolling {
  Model model;
  AssemblyResult at;
  SimulationOptions forces;
  double until;

  Rolling(Model rolling, const Numbers& v, SimulationOptions acting, double end)
      : model(std::move(rolling)),
        at(assemble(model, neutral(model), v)),
        forces(std::move(acting)),
        until(end) {}
};
/// A sphere whose centre of mass is not its centre.
Description lopsided_sphere() {
  Description d = wheel(true);
  d.name = "lopsided sphere";
  d.bodies[0].inertia =
      MassProperties{.mass = 2, .com = {0.05, -0.03, 0.25}, .Theta = {.072, .08, .09, .003, 0, .002}};
  return d;
}
std::vector<Rolling> what_rolls() {
  SimulationOptions motors;  // for the wheels of the cart
  motors.drive = [](double t, Span, Span v, std::span<double> tau) {
    std::ranges::fill(tau, 0.0);
    tau[6] = 0.01 * std::sin(3 * t) - 1e-4 * v[6], tau[7] = 0.01 * std::cos(3 * t) - 1e-4 * v[7];
  };
  return {
      {ModelBuilder(wheel(false)).build(), {0.4, 6, 0.7, 0, 0, 0}, driven_and_damped(), 0.5},
      {ModelBuilder(lopsided_sphere()).build(), {3, 2, 1, 0, 0, 0}, driven_and_damped(), 0.5},
      {load(AXODE_SOURCE_DIR "/examples/robots/cart.toml"), {0, 0, 1, .3, 0, 0, 0, 0, 0, 0, 0}, motors, 0.1}};
}

/// The largest violation B v of the rows that constrain velocities only.
double rolling_slip(const Trajectory& motion) {
  AbsoluteSystem bodies(motion.model(), BodyGroup::SE3);
  Numbers q, v, slip(static_cast<std::size_t>(bodies.rows(ConstraintLevel::velocity)));
  double most = 0;
  for (std::size_t k = 0; k < motion.size(); ++k) {
    bodies.from_joint_state(motion.q(k), motion.v(k), q, v);
    bodies.set_nonholonomic_rates(q, v, 1, slip);
    most = std::max(most, largest_of(slip));
  }
  return most;
}

TEST(AbsoluteCoordinates, SchemesHaveTheirOrdersOnWhatRolls) {
  for (const Rolling& rolling : what_rolls()) {
    SCOPED_TRACE(rolling.model.name());
    expect_orders(rolling.model, rolling.at.q, rolling.at.v, rolling.until, 50, {});
    expect_orders(rolling.model, rolling.at.q, rolling.at.v, rolling.until, 50, rolling.forces);
  }
}

TEST(AbsoluteCoordinates, RattleComposedToOrderSixKeepsItOnWhatRolls) {
  const Rolling disc = what_rolls()[0];
  const Trajectory exact = simulate(disc.model, disc.at.q, disc.at.v, 0.5, {1e-13, 1e-14}, disc.forces);
  for (const Coordinates kind : absolute_kinds) {
    const auto error = [&](int steps) {
      return error_of(
          simulate_rattle(disc.model, disc.at.q, disc.at.v, 0.5, 0.5 / steps, 6, in(kind, disc.forces)),
          exact);
    };
    EXPECT_NEAR(std::log2(error(20) / error(40)), 6, 0.3);
  }
}

TEST(AbsoluteCoordinates, WhatRollsDoesSoAtTheEndsOfSteps) {
  for (const Rolling& rolling : what_rolls())
    for (const Coordinates kind : absolute_kinds)
      for (const auto& [name, order, run] : schemes) {
        SCOPED_TRACE(rolling.model.name() + ", " + name);
        const Trajectory motion =
            run(rolling.model, rolling.at.q, rolling.at.v, rolling.until, 2e-3, in(kind, rolling.forces));
        ASSERT_TRUE(motion.complete) << motion.stop_reason;
        EXPECT_LT(largest_of(motion.position_residuals), 1e-12);
        if (std::string_view(name) != "generalised-alpha, index 3") {
          EXPECT_LT(largest_of(motion.velocity_residuals), 1e-12);
        } else if (rolling.model.n_bodies() == 1) {  // the joint coordinates of a single body describe its
                                                     // motion completely
          EXPECT_LT(rolling_slip(motion), 1e-12);
        }
      }
}

TEST(AbsoluteCoordinates, RattleIsReversibleWithWhatRolls) {
  for (const Rolling& rolling : what_rolls())
    for (const Coordinates kind : absolute_kinds)
      for (const int order : {2, 4}) {
        SCOPED_TRACE(rolling.model.name());
        expect_way_back(rolling.model, rolling.at.q, rolling.at.v, 1e-11, 0.1, [&](Span q, Span v) {
          return simulate_rattle(rolling.model, q, v, 0.5, 1e-2, order, in(kind));
        });
      }
}

/// The error of the energy does not grow, although the scheme is not symplectic for rolling.
TEST(AbsoluteCoordinates, RattleKeepsTheEnergyOfWhatRollsInABand) {
  const std::vector<Rolling> all = what_rolls();
  for (std::size_t k = 0; k < 2; ++k)
    for (const Coordinates kind : absolute_kinds) {
      SCOPED_TRACE(all[k].model.name());
      const auto error = [&](const auto& run, double until) {
        const Trajectory motion = run(all[k].model, all[k].at.q, all[k].at.v, until, 2e-2, in(kind));
        EXPECT_TRUE(motion.complete) << motion.stop_reason;
        const auto [least, most] = std::ranges::minmax(motion.body_energies);
        return most - least;
      };
      const auto rattle = schemes[1].run, half_explicit = schemes[3].run;
      EXPECT_LT(error(rattle, 80), 1.1 * error(rattle, 10));
      EXPECT_GT(error(half_explicit, 80), 4 * error(half_explicit, 10)) << "drifts";
    }
}

/// An edge mill: a wheel runs round a post that holds its axle, so that the row for its slip along the axle
/// is redundant beside a row of the post. The library must keep the row of the post, because that one
/// constrains positions too.
TEST(AbsoluteCoordinates, PlacesAreHeldWhereWhatRollsRepeatsThem) {
  Description mill = wheel(false, {1, 0.5, -9.81});
  BodyDescription axle{.name = "axle", .joint = {.kind = JointKind::free}};
  axle.inertia = MassProperties{.mass = 2, .com = {0.1, 0.2, .5}, .Theta = {.045, .09, .045, 0, 0, 0}};
  mill.bodies.insert(mill.bodies.begin(), axle);
  mill.bodies[1].predecessor = "axle";
  mill.bodies[1].joint = {.kind = JointKind::revolute, .axis = {0, 1, 0}, .point = {0, 0, .3}};
  mill.loops.push_back(
      {.name = "post", .between = {"ground", "axle"}, .axis = {0, 0, 1}, .point = {0, -1, 0}});
  const Model model = ModelBuilder(mill).build();
  const AssemblyResult at = assemble(model, neutral(model), Numbers{0, 0, 0, 1, 0, 0, 0});
  for (const Coordinates kind : absolute_kinds)
    for (const auto& [name, order, run] : schemes) {
      SCOPED_TRACE(name);
      const Trajectory motion = run(model, at.q, at.v, 2, 1e-2, in(kind));
      ASSERT_TRUE(motion.complete) << motion.stop_reason;
      EXPECT_GT(apart(model, last_q(motion), at.q), 1);
      EXPECT_LT(largest_of(motion.position_residuals), 1e-12);
    }
}

/// The energy error of the N-four-bar with spectral radius 0.95 equals the published one, 1.14e-3 J for h = 1
/// ms.
TEST(AbsoluteCoordinates, TheFourBarsEnergyErrorIsThePublishedOne) {
  Description d{.name = "N-four-bar", .gravity = {0, -9.81, 0}, .bodies = {}, .frames = {}};
  const auto slender = [&](const char* name, const std::string& on, const Vec3<>& p, const Vec3<>& q) {
    d.bodies.push_back(bar(name, on, JointKind::revolute, {0, 0, 1}, p, q));
    const Vec3<> l = q - p;
    d.bodies.back().inertia->Theta = {l.y * l.y / 12, l.x * l.x / 12, 1.0 / 12, 0, 0, 0};
  };
  slender("left", "ground", {0, 0, 0}, {0, 1, 0}), slender("first", "left", {0, 1, 0}, {1, 1, 0});
  slender("second", "first", {1, 1, 0}, {2, 1, 0}), slender("middle", "ground", {1, 0, 0}, {1, 1, 0});
  slender("right", "ground", {2, 0, 0}, {2, 1, 0});
  d.loops = {{.between = {"first", "middle"}, .axis = {0, 0, 1}, .point = {1, 1, 0}},
             {.between = {"second", "right"}, .axis = {0, 0, 1}, .point = {2, 1, 0}}};
  const Model model = ModelBuilder(d).build();
  const AssemblyResult at = assemble(model, neutral(model), Numbers{-1, 1, 0, -1, -1});
  const Trajectory motion =
      simulate_stiff(model, at.q, at.v, 10, 1e-3, 0.95, in(Coordinates::absolute_SO3xR3), false);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  const auto [least, most] = std::ranges::minmax(motion.body_energies);
  EXPECT_NEAR(std::max(most - motion.body_energies[0], motion.body_energies[0] - least), 1.14e-3, 0.005e-3);
}

/// A mechanism ten thousand kilometres from the inertial origin loses no digits.
TEST(AbsoluteCoordinates, DoNotDependOnWhereTheMechanismStands) {
  const auto chain_at = [](const Vec3<>& p) {
    Description d{.name = "chain", .gravity = {0, 0, -9.81}, .bodies = {}, .frames = {}};
    std::string on = "ground";
    for (int k = 0; k < 3; ++k) {
      const std::string name = "link " + std::to_string(k);
      d.bodies.push_back(bar(name, on, JointKind::revolute, {0, 1, 0}, p + Vec3<>{double(k), 0, 0},
                             p + Vec3<>{double(k + 1), 0, 0}));
      on = name;
    }
    return ModelBuilder(d).build();
  };
  const Model near = chain_at({}), far = chain_at({1e7, 2e6, -3e6});
  const Numbers q{0.1, 0.2, 0.3}, v{1, 2, 3};
  for (const Coordinates kind : absolute_kinds)
    for (const auto& [name, order, run] : schemes) {
      SCOPED_TRACE(name);
      const Trajectory here = run(near, q, v, 0.1, 1e-3, in(kind)),
                       there = run(far, q, v, 0.1, 1e-3, in(kind));
      ASSERT_TRUE(there.complete) << there.stop_reason;
      EXPECT_LT(error_of(there, here), 1e-6);
    }
}

/// A disc that is drawn ten kilometres from the inertial origin, at which the frame of its free motion stays.
TEST(AbsoluteCoordinates, DoNotDependOnHowFarAFreeBodyIsFromItsFrame) {
  const Vec3<> center{0, 0, .3}, w{0.4, 6, 0.7};
  const auto disc_at = [&](const Vec3<>& p) {
    Description d = wheel(false);
    d.bodies[0].inertia->com = p + center;
    d.loops[0].point = p, d.loops[0].center = p + center;
    return ModelBuilder(d).build();
  };
  const auto v_at = [&](const Vec3<>& p) {
    const Vec3<> v = cross(w, center) - cross(w, p + center);
    return Numbers{w.x, w.y, w.z, v.x, v.y, v.z};
  };
  /// The position and the orientation of the disc at the end.
  const auto end_of = [&](const Trajectory& motion, const Vec3<>& p) {
    const Span q = last_q(motion);
    const SO3<> R = rotation(Quaternion<>{q[0], q[1], q[2], q[3]});
    return SE3<>{R, Vec3<>{q[4], q[5], q[6]} + R * (p + center) - p};
  };
  const Vec3<> far{1e4, -1e4, 0};
  const Model here = disc_at({}), there = disc_at(far);
  for (const Coordinates kind : absolute_kinds)
    for (const auto& [name, order, run] : schemes) {
      SCOPED_TRACE(name);
      const Trajectory near_by = run(here, neutral(here), v_at({}), 0.5, 1e-2, in(kind)),
                       far_away = run(there, neutral(there), v_at(far), 0.5, 1e-2, in(kind));
      ASSERT_TRUE(near_by.complete && far_away.complete) << near_by.stop_reason << far_away.stop_reason;
      const SE3<> apart = inverse(end_of(near_by, {})) * end_of(far_away, far);
      EXPECT_LT(norm(log_SO3(apart.R)) + norm(apart.r), 1e-6);
    }
}

TEST(AbsoluteCoordinates, MeetEventsAndTellWhatIsBetween) {
  const Closed mechanism(four_bar());
  SimulationOptions options;  // the motion ends before the crank turns back
  options.events = {{.value = [](double, Span, Span v) { return v[0]; }, .terminal = true}};
  const Trajectory joints =
      simulate(mechanism.model, mechanism.at.q, mechanism.at.v, 2, {1e-10, 1e-12}, options);
  ASSERT_EQ(joints.events.size(), 1u);
  for (const Coordinates kind : absolute_kinds) {
    const Trajectory bodies =
        simulate(mechanism.model, mechanism.at.q, mechanism.at.v, 2, {1e-10, 1e-12}, in(kind, options));
    ASSERT_EQ(bodies.events.size(), 1u);
    EXPECT_NEAR(bodies.events[0].t, joints.events[0].t, 1e-7);
    EXPECT_NEAR(last_v(bodies)[0], 0, 1e-9);
  }
}

/// Joints that turn several times in one step. A spring, a drive, a coupled joint and a coupling depend on
/// the angle.
Model turning_joints() {
  Description d{.name = "turning joints", .gravity = {0, 0, 0}};
  const auto add = [&](const char* name, const char* on, JointKind kind, Vec3<> axis, Dof dof = {}) {
    BodyDescription body{.name = name, .predecessor = on};
    body.joint = {.name = name, .kind = kind, .axis = axis, .dof = {dof}};
    body.inertia = MassProperties{.mass = 2, .com = {0, 0, 0}, .Theta = {1, 1, 1}};
    d.bodies.push_back(std::move(body));
  };
  add("rotor", "ground", JointKind::revolute, {0, 0, 1});
  add("wheel on the rotor", "rotor", JointKind::revolute, {0, 0, 1});
  add("swinging rotor", "ground", JointKind::revolute, {0, 1, 0}, {.stiffness = 0.01});
  add("rotor with armature", "ground", JointKind::revolute, {1, 0, 0}, {.armature = 0.5});
  add("screw", "ground", JointKind::helical, {0, 0, 1});
  d.bodies.back().joint.pitch = 0.2;
  add("puck", "ground", JointKind::planar, {0, 0, 1});
  d.bodies.back().joint.dof = {};
  add("follower", "ground", JointKind::revolute, {0, 1, 0});
  d.bodies.back().joint.coupling = Coupling{"rotor", -1.7, 0.3};
  add("rack", "ground", JointKind::prismatic, {1, 0, 0});
  add("pinion", "ground", JointKind::revolute, {0, 1, 0});
  d.bodies.back().joint.coupling = Coupling{"rack", 10, 0};
  add("first gear", "ground", JointKind::revolute, {0, 0, 1});
  add("second gear", "ground", JointKind::revolute, {0, 0, 1});
  d.couplings.push_back({.name = "gears", .terms = {{"first gear", 1.0}, {"second gear", 2.0}}});
  return ModelBuilder(d).build();
}

/// Poses do not contain the number of whole turns. These must be counted along the motion, for steps of any
/// length.
TEST(AbsoluteCoordinates, AnglesCountTheWholeTurnsOfLongSteps) {
  const Model model = turning_joints();
  Numbers q = neutral(model), v(q.size());
  const auto names = velocity_names(model);
  for (std::size_t c = 0; c < v.size(); ++c) {
    if (names[c] == "rotor") v[c] = 2;
    if (names[c] == "rack") v[c] = 0.4;
    if (names[c] == "second gear") v[c] = -1.1;
    if (names[c] == "wheel on the rotor") v[c] = -3.5;
    if (names[c] == "swinging rotor" || names[c] == "puck[0]" || names[c] == "first gear") v[c] = 2.2;
    if (names[c] == "rotor with armature" || names[c] == "screw") v[c] = 1.9;
  }
  const double until = 20, step = 2.5;
  const Trajectory exact = simulate(model, q, v, until, {1e-11, 1e-12});
  ASSERT_NEAR(last_q(exact)[0], 40, 1e-9);
  const auto compare = [&](const Trajectory& motion) {
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    ASSERT_LT(motion.steps, 30u) << "joints are to turn by more than half a turn in a step";
    Numbers q_t(q.size()), v_t(v.size()), q_exact(q), v_exact(v);
    for (double t = 0; t <= until; t += 0.8) {
      motion.at(t, q_t, v_t), exact.at(t, q_exact, v_exact);
      for (std::size_t k = 0; k < q.size(); ++k)
        EXPECT_NEAR(q_t[k], q_exact[k], names[k] == "rotor" ? 1e-8 : 0.6) << names[k] << " at " << t << " s";
    }
  };
  for (const Coordinates kind : absolute_kinds) {
    SCOPED_TRACE(kind == Coordinates::absolute ? "SE(3)" : "SO(3) x R^3");
    for (const auto& [name, order, run] : schemes) {
      SCOPED_TRACE(name);
      compare(run(model, q, v, until, step, in(kind)));
    }
    SCOPED_TRACE("dopri5");
    compare(simulate(model, q, v, until, {}, in(kind)));
  }
}

template <class F> void expect_refused(const F& f, const char* part) {
  try {
    static_cast<void>(f());
    ADD_FAILURE() << "not refused: " << part;
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(part));
  }
}

/// Stiff springs, dampers and drives, whose own motion decays within a small part of a step.
TEST(AbsoluteCoordinates, GeneralizedAlphaTakesStiffJointsInLongSteps) {
  constexpr double stiffness = 1e4, damping = 1e3;
  Description chain{.name = "chain", .gravity = {0, 0, -9.81}, .bodies = {}, .frames = {}};
  for (int k = 0; k < 12; ++k)
    chain.bodies.push_back(bar("link " + std::to_string(k),
                               k == 0 ? "ground" : "link " + std::to_string(k - 1),
                               k % 2 == 0 ? JointKind::revolute : JointKind::spherical, {0, 1, 0},
                               {0.3 * k, 0, 0}, {0.3 * (k + 1), 0, 0}));
  Description held = chain, closed = bricard();
  for (Description* of_springs : {&chain, &closed})
    for (BodyDescription& body : of_springs->bodies)
      body.joint.dof.assign(body.joint.kind == JointKind::spherical ? 3 : 1,
                            {.damping = damping, .stiffness = stiffness});
  for (BodyDescription& body : held.bodies) body.joint.kind = JointKind::revolute;
  SimulationOptions driven, sprung;
  sprung.joint_losses = true;
  driven.drive = [](double t, Span q, Span v, std::span<double> tau) {
    for (std::size_t c = 0; c < tau.size(); ++c) tau[c] = stiffness * (0.1 * t * t - q[c]) - damping * v[c];
  };
  for (const auto& [mechanism, options] :
       {std::pair{&chain, &sprung}, std::pair{&closed, &sprung}, std::pair{&held, &driven}}) {
    SCOPED_TRACE(mechanism->name);
    const Model model = ModelBuilder(*mechanism).build();
    const Numbers q = neutral(model), v(static_cast<std::size_t>(model.nv()));
    const Trajectory exact = simulate_stiff(model, q, v, 0.5, 1e-3, 0.9, *options);
    ASSERT_TRUE(exact.complete) << exact.stop_reason;
    const double moved = apart(model, last_q(exact), q);
    EXPECT_GT(moved, 1e-4);
    for (const Coordinates kind : absolute_kinds)
      for (const bool stabilized : {true, false}) {
        const Trajectory motion = simulate_stiff(model, q, v, 0.5, 1e-2, 0.9, in(kind, *options), stabilized);
        ASSERT_TRUE(motion.complete) << motion.stop_reason;
        EXPECT_LT(motion.evaluations, 20 * motion.steps);
        EXPECT_LT(apart(model, last_q(motion), last_q(exact)), 0.02 * moved);
      }
  }
}

TEST(AbsoluteCoordinates, SchemesSayWhatTheyDoNotTake) {
  const Closed mechanism(four_bar());
  const Model& model = mechanism.model;
  const AssemblyResult& at = mechanism.at;
  const auto run = [&](SimulationOptions options) {
    return [&, options] { return simulate_rattle(model, at.q, at.v, 1, 0.1, 2, options); };
  };
  expect_refused(run({}), "RATTLE needs coordinates = \"absolute\"; got \"relative\"");
  SimulationOptions with_event = in(Coordinates::absolute);
  with_event.events = {{.value = [](double, Span, Span) { return 1.0; }}};
  expect_refused(run(with_event), "events: method \"rattle\" does not support them");
  expect_refused([&] { return simulate_half_explicit(model, at.q, at.v, 1, 0.1); },
                 "the half-explicit method needs coordinates = \"absolute\"");
  const Model tree = test_tree();
  const State<double> state = test_state(tree);
  expect_refused(
      [&] { return simulate_symplectic(tree, state.q, state.v, 1, 0.1, 2, in(Coordinates::absolute)); },
      "method \"midpoint\" needs coordinates = \"relative\"; got \"absolute\"; in absolute coordinates use "
      "rattle");
  expect_refused([&] { return simulate_rattle(model, at.q, at.v, 1, 0.1, 3, in(Coordinates::absolute)); },
                 "order");
  const auto by_cayley = with(LocalCoordinates::cayley, in(Coordinates::absolute));
  expect_refused(run(by_cayley),
                 "RATTLE in absolute coordinates needs local_coordinates = \"exponential\"; got \"cayley\"");
  expect_refused([&] { return simulate_stiff(model, at.q, at.v, 1, 0.1, 0.8, by_cayley); },
                 "generalised-alpha in absolute coordinates");
  expect_refused([&] { return simulate_half_explicit(model, at.q, at.v, 1, 0.1, by_cayley); },
                 "the half-explicit method in absolute coordinates");
}

}  // namespace
}  // namespace axode::test
