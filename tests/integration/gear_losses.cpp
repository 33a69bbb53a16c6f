#include <sstream>

#include "axode/batch.hpp"
#include "axode/constraints.hpp"
#include "axode/io.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/integration/motions.hpp"
#include "tests/support/refused_arguments.hpp"

/// Gears that lose a part of the force that they transmit: the law of their losses on random trees, balance
/// of power, hoists in closed form, loops, and what is refused.
namespace axode::test {
namespace gear_losses {
namespace {

const SimulationOptions with_losses{.joint_losses = true};
constexpr Tolerances tight{.relative = 1e-11, .absolute = 1e-12};

// ------------------------------------------------------------------------------------------ random trees

/// A random tree whose joints of one velocity have gears with losses, dry friction and damping, without
/// springs, under constant drive forces.
struct Geared {
  Model model;
  Numbers q, v, tau;
  SimulationOptions options = with_losses;

  explicit Geared(std::uint64_t seed, double largest_back = 0.9)
      : model(ModelBuilder(drawn(seed, largest_back)).build()), q(neutral(model)), tau(at(model.nv())) {
    Random<double> random(seed + 1);
    const State<double> state = random_state(model, random);
    q = state.q;
    v = state.v;
    for (double& tau_c : tau) tau_c = random.number(-8, 8);
    for (const Gear& gear : model.gears())
      if (random.number(0, 1) < 0.5) v[at(gear.velocity)] = 0;
    options.drive = [this](double, Span, Span, std::span<double> out) {
      std::ranges::copy(tau, out.begin());
    };
  }
  Geared(const Geared&) = delete;

  static std::size_t at(int c) { return static_cast<std::size_t>(c); }
  static Description drawn(std::uint64_t seed, double largest_back) {
    Random<double> random(seed);
    const TreeRecipe recipe{.most_bodies = 6, .always_mass = true, .springs = 0};
    Description tree = described(random_mechanism(random, recipe), random);
    for (BodyDescription& body : tree.bodies) {
      if (!has_one_velocity(body.joint.kind) || body.joint.coupling) continue;
      body.joint.dof = {{.damping = random.number(0, 0.2),
                         .friction = random.number(0, 1) < 0.3 ? random.number(0, 2) : 0,
                         .armature = random.number(0, 1) < 0.8 ? random.number(0.1, 3) : 0,
                         .gear_loss = random.number(0, 1)}};
      Dof& dof = body.joint.dof[0];
      const double most = dof.armature > 0 ? largest_back : 0.9;
      if (random.number(0, 1) < 0.7) dof.gear_loss_back = random.number(0, most);
    }
    return tree;
  }
};

/// The force F that each gear transmits at a state of a motion, from inverse dynamics without losses.
Numbers transmitted(const Model& model, Span q, Span v, Span a) {
  Workspace<> workspace(model, cut_tree);
  Numbers force(v.size()), out;
  inverse_dynamics(model, workspace, q, v, a, force);
  for (const Gear& gear : model.gears())
    out.push_back(force[Geared::at(gear.velocity)] - gear.rotor * a[Geared::at(gear.velocity)]);
  return out;
}

/// Expects the law of gears and of dry friction at all states of a motion.
void expect_law(const Geared& at, const Trajectory& motion, int& sticking, int& moving, int& starting) {
  const Tree<double>& tree = at.model.tree<double>();
  for (std::size_t k = 0; k < motion.size(); ++k) {
    const Numbers F = transmitted(at.model, motion.q(k), motion.v(k), motion.a(k));
    for (std::size_t g = 0; g < F.size(); ++g) {
      const Gear& gear = at.model.gears()[g];
      const std::size_t c = Geared::at(gear.velocity);
      const double v_c = motion.v(k)[c], a_c = motion.a(k)[c];
      const double inertia = gear.rotor * a_c, lost = at.tau[c] - tree.damping[c] * v_c - inertia - F[g];
      const double size = 1 + std::abs(F[g]) + std::abs(inertia) + std::abs(at.tau[c]);
      const auto bound = [&](double direction) {
        return tree.friction[c] + (direction * F[g] > 0 ? gear.loss : gear.loss_back) * std::abs(F[g]);
      };
      if (v_c != 0) {
        if (std::abs(v_c) < 1e-9) continue;
        EXPECT_NEAR(lost, v_c > 0 ? bound(1) : -bound(-1), 1e-8 * size) << k << ' ' << g;
        ++moving;
      } else if (a_c != 0) {
        EXPECT_NEAR(lost, a_c > 0 ? bound(1) : -bound(-1), 1e-8 * size) << k << ' ' << g;
        ++starting;
      } else {
        EXPECT_LE(lost, bound(1) + 1e-6 * size) << k << ' ' << g;
        EXPECT_GE(lost, -bound(-1) - 1e-6 * size) << k << ' ' << g;
        ++sticking;
      }
    }
  }
}

TEST(GearLosses, ObeyTheirLawOnRandomTrees) {
  int sticking = 0, moving = 0, starting = 0;
  for_seeds(40, [&](std::uint64_t seed) {
    const Geared at(seed);
    const Trajectory motion = simulate(at.model, at.q, at.v, 0.2, {1e-7, 1e-9}, at.options);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    expect_law(at, motion, sticking, moving, starting);
    expect_law(at, simulate_fixed(at.model, at.q, at.v, 0.05, 0.002, runge_kutta(4), at.options), sticking,
               moving, starting);
  });
  EXPECT_GE(sticking, 150);
  EXPECT_GE(moving, 1000);
  EXPECT_GE(starting, 10);
}

/// Gears that lock themselves obey their law too, or their motion ends with a sentence that names one.
TEST(GearLosses, MayLockThemselves) {
  int sticking = 0, moving = 0, starting = 0, refused = 0;
  for_seeds(40, [&](std::uint64_t seed) {
    const Geared at(seed, 2);
    const Trajectory motion = simulate(at.model, at.q, at.v, 0.1, {1e-7, 1e-9}, at.options);
    if (!motion.complete) {
      EXPECT_NE(motion.stop_reason.find("locks itself so strongly"), std::string::npos) << motion.stop_reason;
      ++refused;
    }
    expect_law(at, motion, sticking, moving, starting);
  });
  EXPECT_GE(sticking, 50);
  EXPECT_GE(moving, 200);
  EXPECT_GE(refused, 1);
}

TEST(GearLosses, AreThoseOfStiffMethods) {
  for_seeds(10, [&](std::uint64_t seed) {
    const Geared at(seed);
    const Trajectory exact = simulate(at.model, at.q, at.v, 0.1, {1e-9, 1e-11}, at.options);
    const Trajectory stiff = simulate_stiff(at.model, at.q, at.v, 0.1, 0.0005, 0.8, at.options);
    ASSERT_TRUE(exact.complete && stiff.complete) << exact.stop_reason << stiff.stop_reason;
    EXPECT_LE(apart(at.model, last_q(exact), last_q(stiff)), 1e-3);
  });
}

/// Forward dynamics is the inverse of inverse dynamics, in every representation and scalar.
TEST(GearLosses, HaveForwardAndInverseDynamics) {
  for_seeds(40, [](std::uint64_t seed) {
    const Geared at(seed, 1);
    Random<double> random(seed + 2);
    const Numbers a = random_numbers(random, at.model.nv());
    const Loads<> loads{.joint_losses = true};
    Workspace<> workspace(at.model, cut_tree);
    Numbers tau(a.size()), plain(a.size()), back(a.size());
    inverse_dynamics(at.model, workspace, at.q, at.v, a, tau, loads);
    const auto expect = [&](auto rep) {
      using Rep = decltype(rep);
      inverse_dynamics<Rep>(at.model, workspace, at.q, at.v, a, plain, loads);
      const Solvability found = forward_dynamics<Rep>(at.model, workspace, at.q, at.v, tau, back, loads);
      ASSERT_TRUE(found.ok()) << to_string(at.model, found);
      for (std::size_t c = 0; c < a.size(); ++c) {
        EXPECT_NEAR(plain[c], tau[c], 1e-11 * (1 + std::abs(tau[c])));
        EXPECT_NEAR(back[c], a[c], 1e-8);
      }
    };
    expect(Fast{});
    expect(BodyFixed{});
    expect(Spatial{});
    expect(Mixed{});
    Numbers shared = a;
    inverse_dynamics(at.model, workspace, at.q, at.v, shared, shared, loads);
    EXPECT_EQ(shared, tau);
    shared = tau;
    ASSERT_TRUE(forward_dynamics(at.model, workspace, at.q, at.v, shared, shared, loads).ok());
    for (std::size_t c = 0; c < a.size(); ++c) EXPECT_NEAR(shared[c], a[c], 1e-8);
    LoopWorkspace<> loops(at.model);  // a tree is a mechanism with loops that has none
    ASSERT_TRUE(forward_dynamics(at.model, loops, at.q, at.v, tau, back, {}, loads).ok());
    for (std::size_t c = 0; c < a.size(); ++c) EXPECT_NEAR(back[c], a[c], 1e-8);
  });
}

/// Kinetic and potential energy change by the power of the drives minus the losses, by Simpson's rule.
TEST(GearLosses, BalancePower) {
  Description arm = two_links();
  for (BodyDescription& body : arm.bodies)
    body.joint.dof = {
        {.damping = 0.4, .friction = 0.6, .armature = 2, .gear_loss = 0.3, .gear_loss_back = 0.5}};
  const Model model = ModelBuilder(arm).build();
  for (const Numbers& tau : {Numbers{30, -120}, {-200, 20}, {-400, -90}}) {
    SimulationOptions options = with_losses;
    options.drive = [&](double, Span, Span, std::span<double> out) { std::ranges::copy(tau, out.begin()); };
    const Trajectory motion =
        simulate_fixed(model, Numbers{0.3, 0.4}, Numbers{6, -7}, 0.064, 0.001, runge_kutta(4), options);
    ASSERT_TRUE(motion.complete);
    ASSERT_EQ(motion.size(), 65u);
    double work = 0, lost = 0;
    for (std::size_t k = 0; k < motion.size(); ++k) {
      const double weight = (k == 0 || k == 64 ? 1 : k % 2 == 1 ? 4 : 2) * 0.001 / 3;
      const Numbers F = transmitted(model, motion.q(k), motion.v(k), motion.a(k));
      for (std::size_t c = 0; c < 2; ++c) {
        const double v = motion.v(k)[c];
        work += weight * tau[c] * v;
        lost += weight * (0.4 * v * v + (0.6 + (F[c] * v > 0 ? 0.3 : 0.5) * std::abs(F[c])) * std::abs(v));
      }
    }
    const double change =
        energy_of(model, last_q(motion), last_v(motion)) - energy_of(model, motion.q(0), motion.v(0));
    EXPECT_NEAR(change, work - lost, 1e-7 * lost);
    EXPECT_GT(lost, 1);
  }
}

/// With a loss that is next to nothing, dry friction is found by the equations of gears.
TEST(GearLosses, LeaveDryFrictionAsItIs) {
  for_seeds(15, [](std::uint64_t seed) {
    Description drawn = Geared::drawn(seed, 0.9);
    const auto with = [&](double loss) {
      for (BodyDescription& body : drawn.bodies)
        for (Dof& dof : body.joint.dof) {
          dof.gear_loss = has_one_velocity(body.joint.kind) && !body.joint.coupling ? loss : 0;
          dof.gear_loss_back = {};
          dof.friction = 1;
        }
      return ModelBuilder(drawn).build();
    };
    const Model dry = with(0), geared = with(1e-15);
    const Geared at(seed);
    SimulationOptions options = at.options;
    const Trajectory one = simulate(dry, at.q, at.v, 0.1, tight, options);
    const Trajectory other = simulate(geared, at.q, at.v, 0.1, tight, options);
    ASSERT_TRUE(one.complete && other.complete);
    EXPECT_LE(apart(dry, last_q(one), last_q(other)), 1e-8);
  });
}

// ---------------------------------------------------------------------------------------------- hoists

/// A load of 2 kg on a vertical slide with a gear, whose rotor has an inertia of 0.5 kg.
Model hoist(double loss, double friction = 0, std::optional<double> loss_back = {}) {
  Description d{.name = "hoist", .gravity = {0, 0, -10}};
  d.bodies.push_back(
      {.name = "load",
       .joint =
           {.name = "slide",
            .kind = JointKind::prismatic,
            .axis = {0, 0, 1},
            .dof = {{.friction = friction, .armature = 0.5, .gear_loss = loss, .gear_loss_back = loss_back}}},
       .inertia = MassProperties{.mass = 2, .Theta = {1, 1, 1}}});
  return ModelBuilder(d).build();
}
SimulationOptions driven(double force) {
  SimulationOptions options = with_losses;
  options.drive = [force](double, Span, Span, std::span<double> tau) { tau[0] = force; };
  return options;
}

TEST(GearLosses, HoldALoadIfTheyLockThemselves) {
  for (const double loss : {1.0, 1.1, 1.24}) {
    const Trajectory motion = simulate(hoist(loss), Numbers{0.7}, Numbers{0}, 5, {}, with_losses);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_EQ(last_q(motion)[0], 0.7);
    EXPECT_EQ(motion.a().back(), 0);
  }
  // Below, the load drives the rotor back: (2 + 0.5/(1 - κ)) a = -20.
  const Trajectory falls = simulate(hoist(0.5), Numbers{0.7}, Numbers{0}, 1, tight, with_losses);
  EXPECT_NEAR(last_q(falls)[0], 0.7 - 0.5 * 20 / 3, 1e-10);
  // The drive has to push the load of a gear that locks
  // itself down: F = (τ + 0.5 a)/(1 - κ) holds 2 (10 + a).
  const Trajectory lowered = simulate(hoist(1.1), Numbers{0.7}, Numbers{0}, 1, tight, driven(-3));
  const double a = -(3 - 2 * 10 * 0.1) / (0.5 - 2 * 0.1);
  EXPECT_NEAR(last_q(lowered)[0], 0.7 + a / 2, 1e-10);
}

/// A load that is thrown upwards stops, and stays or falls back.
TEST(GearLosses, StopWhereTheyShould) {
  for (const double loss : {0.5, 1.1}) {
    // On the way up the rotor drives if 2 (10 + a) = -0.5 a/(1 + κ) > 0.
    const double up = -20 / (2 + 0.5 / (1 + loss)), t_1 = -3 / up, top = 1.5 * t_1;
    const double down = loss < 1 ? -20 / (2 + 0.5 / (1 - loss)) : 0;
    const double until = t_1 + 0.5;
    for (const Trajectory& motion :
         {simulate(hoist(loss), Numbers{0}, Numbers{3}, until, tight, with_losses),
          simulate_fixed(hoist(loss), Numbers{0}, Numbers{3}, until, 0.06, runge_kutta(4), with_losses),
          simulate_stiff(hoist(loss), Numbers{0}, Numbers{3}, until, 0.001, 1, with_losses)}) {
      ASSERT_TRUE(motion.complete) << motion.stop_reason;
      EXPECT_NEAR(last_q(motion)[0], top + down * 0.125, 1e-9);
      EXPECT_NEAR(last_v(motion)[0], down * 0.5, 1e-9);
    }
  }
}

/// From 1 + 0.5/2 on there are states without an acceleration, and others with two.
TEST(GearLosses, RefuseStatesWithoutOneAnswer) {
  const Model model = hoist(1.26);
  Workspace<> workspace(model);
  Numbers a(1);
  for (const double speed : {-1.0, 1.0}) {
    const Solvability found =
        forward_dynamics(model, workspace, Numbers{0}, Numbers{speed}, Numbers{0}, a, {.joint_losses = true});
    EXPECT_FALSE(found.ok());
    EXPECT_EQ(found.locked_body, 1);
    EXPECT_TRUE(std::isnan(a[0]));
    EXPECT_NE(to_string(model, found).find("gear of joint \"slide\" locks itself so strongly"),
              std::string::npos);
  }
  EXPECT_TRUE(forward_dynamics(hoist(1.24), *std::make_unique<Workspace<>>(hoist(1.24), cut_tree), Numbers{0},
                               Numbers{1}, Numbers{0}, a, {.joint_losses = true})
                  .ok());
  // The loss while the drive drives does not count.
  for (const auto& [loss, loss_back, has_one_answer] : {std::tuple(10.0, 1.24, true), {0.1, 1.26, false}}) {
    const Model other = hoist(loss, 0, loss_back);
    Workspace<> scratch(other);
    EXPECT_EQ(
        forward_dynamics(other, scratch, Numbers{0}, Numbers{1}, Numbers{0}, a, {.joint_losses = true}).ok(),
        has_one_answer);
  }
  const Trajectory motion = simulate(model, Numbers{0}, Numbers{1}, 1, {}, with_losses);
  EXPECT_FALSE(motion.complete);
  EXPECT_NE(motion.stop_reason.find("locks itself so strongly"), std::string::npos);
}

TEST(GearLosses, AreCountedByRollouts) {
  const Model model = hoist(0.5, 1);
  const Numbers q{0}, v{3}, tau(50, 0.0);
  Numbers q_out(51), v_out(51);
  static_cast<void>(
      batch::rollout<double>(model, Span(q), v, tau, 0.02, q_out, v_out, runge_kutta(4), 1, {}, true));
  const Trajectory motion = simulate_fixed(model, q, v, 1, 0.02, runge_kutta(4), with_losses);
  EXPECT_NEAR(q_out.back(), last_q(motion)[0], 1e-12);
  EXPECT_NEAR(v_out.back(), last_v(motion)[0], 1e-12);
}

// ----------------------------------------------------------------------------------------------- loops

/// In a four-bar linkage whose crank has a gear, inverse and forward dynamics belong together, and motions of
/// explicit and implicit methods begin with the same acceleration.
TEST(GearLosses, ActInLoops) {
  Description drawn = four_bar();
  drawn.bodies[0].joint.dof = {{.armature = 0.7, .gear_loss = 0.4}};
  const Model model = ModelBuilder(drawn).build();
  LoopWorkspace<> loops(model);
  const Loads<> loads{.joint_losses = true};
  const std::vector<int> crank{model.gears()[0].velocity};
  const auto c = Geared::at(crank[0]);
  for (const double speed : {-1.0, 1.5})
    for (const double torque : {-20.0, 4.0, 40.0}) {
      Numbers v(Geared::at(model.nv())), lead(v);
      lead[c] = speed;
      const AssemblyResult at = assemble(model, neutral(model), lead);
      ASSERT_EQ(at.status, AssemblyStatus::closed);
      Numbers tau(v), a(v), back(v), lambda(static_cast<std::size_t>(model.loops().rows)), other(lambda);
      tau[c] = torque;
      ASSERT_TRUE(forward_dynamics(model, loops, at.q, at.v, tau, a, lambda, loads).ok());
      EXPECT_LE(
          inverse_dynamics(model, loops, at.q, at.v, a, std::span(back), std::span(other), crank, loads),
          1e-12);
      for (std::size_t k = 0; k < v.size(); ++k) EXPECT_NEAR(back[k], tau[k], 1e-9);
      SimulationOptions options = with_losses;
      options.drive = [&](double, Span, Span, std::span<double> out) {
        std::ranges::fill(out, 0.0);
        out[c] = torque;
      };
      const Trajectory motion = simulate(model, at.q, at.v, 0.1, tight, options);
      ASSERT_TRUE(motion.complete) << motion.stop_reason;
      EXPECT_NEAR(motion.a(0)[c], a[c], 1e-10);
      const Trajectory stiff = simulate_stiff(model, at.q, at.v, 0.1, 0.002, 0.9, options);
      ASSERT_TRUE(stiff.complete) << stiff.stop_reason;
      EXPECT_NEAR(apart(model, last_q(motion), last_q(stiff)), 0, 1e-4);
    }
  Numbers rest(Geared::at(model.nv())), out(rest);
  const std::vector<int> other_drive{1};
  EXPECT_THROW(static_cast<void>(inverse_dynamics(model, loops, neutral(model), rest, rest, std::span(out),
                                                  {}, other_drive, loads)),
               std::invalid_argument);
}

/// The crank of a four-bar linkage at rest sticks if its drive force τ is T (1 - κ_b) to T (1 + κ), where T
/// holds the linkage without losses. A second gear without a drive force holds nothing, but makes the forces
/// of sticking joints indeterminate.
TEST(GearLosses, HoldLoops) {
  Description drawn = four_bar();
  for (const int k : {0, 2})
    drawn.bodies[Geared::at(k)].joint.dof = {{.gear_loss = 0.4, .gear_loss_back = 0.3}};
  const Model model = ModelBuilder(drawn).build();
  LoopWorkspace<> loops(model);
  const Numbers q = neutral(model), rest(Geared::at(model.nv()));
  const std::vector<int> crank{model.gears()[0].velocity};
  Numbers T(rest);
  ASSERT_LE(inverse_dynamics(model, loops, q, rest, rest, std::span(T), {}, crank), 1e-12);
  for (const auto& [part, sticks] : {std::pair{0.69, false}, {0.71, true}, {1.39, true}, {1.41, false}}) {
    SimulationOptions options = with_losses;
    options.drive = [&, part = part](double, Span, Span, std::span<double> out) {
      for (std::size_t c = 0; c < out.size(); ++c) out[c] = part * T[c];
    };
    const Trajectory motion = simulate(model, q, rest, 0.05, tight, options);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    constexpr double by_closing = 1e-15;  // the loops are closed again after each step
    EXPECT_EQ(apart(model, q, last_q(motion)) <= by_closing, sticks) << part;
  }
}

/// One joint follows a motion, and the gear of the other has losses.
TEST(GearLosses, ActBesidePrescribedMotions) {
  Description arm = two_links();
  arm.bodies[1].joint.dof = {{.armature = 2, .gear_loss = 0.3}};
  arm.motions.push_back({.of = "shoulder", .coefficients = {0.2, 1, -2}});
  const Model model = ModelBuilder(arm).build();
  const Numbers q{0.2, 0.5}, v{1, -1}, tau{0, -40};
  SimulationOptions options = with_losses;
  options.drive = [&](double, Span, Span, std::span<double> out) { std::ranges::copy(tau, out.begin()); };
  const Trajectory motion = simulate(model, q, v, 0.2, tight, options);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_NEAR(last_q(motion)[0], 0.2 + 0.2 - 2 * 0.04, 1e-10);
  const DynamicsAtTime found = forward_dynamics_at(model, 0, q, v, tau, {.joint_losses = true});
  ASSERT_TRUE(found.solvability.ok());
  for (std::size_t c = 0; c < 2; ++c) EXPECT_NEAR(found.a[c], motion.a(0)[c], 1e-10);
  const double F = transmitted(model, q, v, found.a)[0];
  EXPECT_NEAR(-40, 2 * found.a[1] + F - 0.3 * std::abs(F), 1e-10);  // the elbow moves backwards
  arm.motions[0].of = "elbow";
  EXPECT_THROW(simulate(ModelBuilder(arm).build(), q, v, 0.2, tight, options), std::invalid_argument);
}

// ------------------------------------------------------------------------------------- drawings and refusals

TEST(GearLosses, StandInDrawings) {
  const std::string text =
      "format = \"axode drawing 1\"\n[[body]]\nname = \"a\"\nmass = 1\ncom = [0, 0, 0]\ninertia = [1, 1, 1]\n"
      "joint = { name = \"hinge\", kind = \"revolute\", axis = \"z\", point = [0, 0, 0], armature = 0.1, "
      "gear_loss = 0.25, gear_loss_back = 1.5 }\n";
  const Description read = read_drawing_text(text, "gear");
  std::ostringstream written;
  write_drawing(ModelBuilder(read).build(), written);
  for (const Description& d : {read, read_drawing_text(written.str(), "again")}) {
    const Dof& dof = d.bodies[0].joint.dof.at(0);
    EXPECT_EQ(dof.gear_loss, 0.25);
    EXPECT_EQ(dof.gear_loss_back, 1.5);
  }
  const Model model = ModelBuilder(read).build();
  ASSERT_EQ(model.gears().size(), 1u);
  EXPECT_EQ(model.gears()[0].rotor, 0.1);
  EXPECT_EQ(model.gears()[0].loss, 0.25);
  EXPECT_EQ(model.gears()[0].loss_back, 1.5);
  std::ostringstream urdf, mjcf;
  for (const std::vector<Fault>& warnings : {write_urdf(model, urdf), write_mjcf(model, mjcf)})
    EXPECT_TRUE(std::ranges::any_of(warnings, [](const Fault& fault) {
      return fault.element == "joint \"hinge\"" &&
             fault.message.find("has a gear with losses") != std::string::npos;
    }));
}

TEST(GearLosses, AreRefusedWhereTheyAreNotCounted) {
  const Model model = hoist(0.5);
  const Numbers q{0}, v{1};
  const auto expect = [](const std::string& message) {
    EXPECT_NE(message.find("gear of joint \"slide\""), std::string::npos) << message;
  };
  SimulationOptions absolute = with_losses;
  absolute.coordinates = Coordinates::absolute;
  expect(message_of([&] { simulate(model, q, v, 1, {}, absolute); }));
  expect(message_of([&] { simulate_symplectic(model, q, v, 1, 0.1, 2, with_losses); }));
  expect(message_of([&] { simulate_momenta(model, q, v, 1, 0.1, runge_kutta(4), with_losses); }));
  expect(message_of([&] { simulate_contact(model, q, v, 1, 0.1, with_losses); }));
  Description sprung = model.description();
  sprung.bodies[0].joint.dof[0].stiffness = 1;
  const Model with_spring = ModelBuilder(sprung).build();
  Workspace<> workspace(with_spring);
  Numbers out(1);
  const std::string springs = message_of([&] {
    inverse_dynamics(with_spring, workspace, q, v, Numbers{0}, std::span(out), {.joint_losses = true});
  });
  EXPECT_NE(springs.find("has springs, whose forces in tau would not pass through the gears"),
            std::string::npos);
  // Simulations count both: the spring acts on the load, (2 + 0.5/(1 + κ)) a = -20 - q on the way up.
  const Trajectory motion = simulate(with_spring, Numbers{0.4}, Numbers{1}, 0.01, {}, with_losses);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_NEAR(motion.a(0)[0], -20.4 / (2 + 0.5 / 1.5), 1e-12);
}

/// A drive along a line pushes the load, and one on the joint pushes the rotor.
TEST(GearLosses, LieBetweenTheDrivesOfAJointAndTheJoint) {
  for (const bool line : {true, false}) {
    Description d = hoist(0.5).description();
    DriveDescription drive{.kind = DriveKind::pid, .parameters = {{"kp", 10}}};
    if (line)
      drive.line = {.between = {"ground", "load"}, .points = {Vec3<>{0, 0, -1}, Vec3<>{}}};
    else
      drive.joints = {{"slide", 1}};
    drive.input.values = {line ? 2.0 : 1.0};
    d.drives.push_back(drive);
    const Trajectory motion =
        simulate(ModelBuilder(d).build(), Numbers{0}, Numbers{1}, 0.01, {}, with_losses);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    // 2 (10 + a) = F + 10 or F, and 1.5 F = -0.5 a or 10 - 0.5 a, with F > 0.
    EXPECT_NEAR(motion.a(0)[0], line ? -10 / (2 + 0.5 / 1.5) : (10 / 1.5 - 20) / (2 + 0.5 / 1.5), 1e-12);
  }
}

}  // namespace
}  // namespace gear_losses
}  // namespace axode::test
