#include "axode/constraints.hpp"
#include "axode/integration/prescribed/closed_motion.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/integration/motions.hpp"

/// Joints with dry friction stick, slide and turn back. The tests check Coulomb's laws on random trees, the
/// dissipated energy, motions in closed form, orders of methods, and mechanisms with loops.
namespace axode::test {
namespace friction {
namespace {

const SimulationOptions with_losses{.joint_losses = true};
constexpr Tolerances tight{.relative = 1e-11, .absolute = 1e-12};

Model block(double friction, double damping = 0, double stiffness = 0) {
  Description rail{.name = "rail", .gravity = {0, 0, -9.81}};
  rail.bodies.push_back(
      {.name = "block",
       .joint = {.name = "rail",
                 .kind = JointKind::prismatic,
                 .axis = {1, 0, 0},
                 .dof = {{.damping = damping, .friction = friction, .stiffness = stiffness}}},
       .inertia = MassProperties{.mass = 1, .Theta = {.1, .1, .1}}});
  return ModelBuilder(rail).build();
}
SimulationOptions driven(std::function<double(double)> force) {
  SimulationOptions options = with_losses;
  options.drive = [force](double t, Span, Span, std::span<double> tau) { tau[0] = force(t); };
  return options;
}

TEST(Friction, HoldsWhatItCan) {
  const Model model = block(2);
  const SimulationOptions options = driven([](double) { return 1.9; });
  for (const Trajectory& motion :
       {simulate(model, Numbers{0.3}, Numbers{0}, 100, {}, options),
        simulate_fixed(model, Numbers{0.3}, Numbers{0}, 1, 0.01, runge_kutta(4), options),
        simulate_fixed(model, Numbers{0.3}, Numbers{0}, 1, 0.01, runge_kutta(1), options),
        simulate_stiff(model, Numbers{0.3}, Numbers{0}, 1, 0.01, 0.8, options)}) {
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_EQ(last_q(motion)[0], 0.3);
    EXPECT_EQ(motion.v().back(), 0);
    EXPECT_EQ(motion.a().back(), 0);
    EXPECT_LE(motion.steps, 100u);
  }
}

/// With v̇ = -2 m/s² a body at 3 m/s stops after 1.5 s and 2.25 m.
TEST(Friction, StopsWhereItShould) {
  const Trajectory motion =
      simulate_fixed(block(2), Numbers{0}, Numbers{3}, 4, 0.4, runge_kutta(4), with_losses);
  EXPECT_EQ(motion.size(), 12u);  // one of the steps is divided in two
  EXPECT_NEAR(last_q(motion)[0], 2.25, 1e-12);
  Numbers q(1), v(1), a(1);
  for (const auto& [t, v_t] : {std::pair{0.6, 1.8}, {1.4, 0.2}, {1.6, 0.0}, {3.9, 0.0}}) {
    motion.at(t, q, v, a);
    EXPECT_NEAR(v[0], v_t, 1e-12) << t;
    EXPECT_NEAR(a[0], t < 1.5 ? -2 : 0, 1e-9) << t;
  }
}

/// The body stops at the end of a step too, and its velocity there is exactly 0.
TEST(Friction, StopsBetweenSteps) {
  const Trajectory motion =
      simulate_fixed(block(2), Numbers{0}, Numbers{3}, 4, 0.25, runge_kutta(1), with_losses);
  EXPECT_EQ(motion.size(), 17u);
  EXPECT_EQ(motion.v(5)[0], 0.5);
  EXPECT_EQ(motion.v(6)[0], 0);
  EXPECT_EQ(motion.a(6)[0], 0);
}

/// A force 3 sin t acts against a friction of 2 N. The body sticks until sin t = 2/3, slides with v = 3 (cos
/// t_0 - cos t) - 2 (t - t_0) until that is 0, sticks, and then does the same in the other direction.
TEST(Friction, FollowsTheClosedForm) {
  const Model model = block(2);
  const SimulationOptions options = driven([](double t) { return 3 * std::sin(t); });
  const auto slid = [](double t_0, double t) {
    return 3 * std::cos(t_0) * (t - t_0) - 3 * (std::sin(t) - std::sin(t_0)) - (t - t_0) * (t - t_0);
  };
  const double t_0 = std::asin(2.0 / 3);
  double low = 2, high = 4;  // the bounds of a bisection for the time at which it stops
  for (int k = 0; k < 100; ++k) {
    const double t = (low + high) / 2, v = 3 * (std::cos(t_0) - std::cos(t)) - 2 * (t - t_0);
    (v > 0 ? low : high) = t;
  }
  const double stroke = slid(t_0, low);
  const Trajectory motion = simulate(model, Numbers{0}, Numbers{0}, 20, tight, options);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  Numbers q(1), v(1);
  const double pi = std::acos(-1.0);
  for (int k = 0; k < 6; ++k) {  // one half of a period each
    motion.at(k * pi + 0.5 * t_0, q, v);
    EXPECT_NEAR(q[0], k % 2 == 0 ? 0 : stroke, 1e-8) << k;
    EXPECT_EQ(v[0], 0) << k;
    motion.at(k * pi + 2, q, v);
    EXPECT_NEAR(q[0], k % 2 == 0 ? slid(t_0, 2) : stroke - slid(t_0, 2), 1e-8) << k;
  }
}

TEST(Friction, KeepsTheOrdersOfMethods) {
  const Model model = block(0.8, 0.1, 3);
  const SimulationOptions options = driven([](double t) { return 2 * std::sin(1.3 * t); });
  const Trajectory exact = simulate(model, Numbers{0.2}, Numbers{1}, 10, {1e-13, 1e-13}, options);
  ASSERT_TRUE(exact.complete) << exact.stop_reason;
  int rests = 0;
  for (std::size_t k = 1; k < exact.size(); ++k) rests += exact.v(k)[0] == 0 && exact.v(k - 1)[0] != 0;
  EXPECT_GE(rests, 3);
  const auto order = [&](const auto& run) {
    const auto error = [&](int steps) { return std::abs(last_q(run(10.0 / steps))[0] - last_q(exact)[0]); };
    return std::log2(error(100) / error(1600)) / 4;
  };
  for (const int p : {2, 3, 4})
    EXPECT_NEAR(order([&](double h) {
                  return simulate_fixed(model, Numbers{0.2}, Numbers{1}, 10, h, runge_kutta(p), options);
                }),
                p, 0.2);
  EXPECT_NEAR(
      order([&](double h) { return simulate_stiff(model, Numbers{0.2}, Numbers{1}, 10, h, 0.8, options); }),
      2, 0.1);
}

/// A random tree with dry friction in all of its joints.
Description with_friction(Description tree, Random<double>& random, double most = 8) {
  for (BodyDescription& body : tree.bodies) {
    body.joint.dof.resize(static_cast<std::size_t>(traits(body.joint.kind).dof));
    for (Dof& dof : body.joint.dof)
      dof.friction = random.number(0, most),
      dof.damping = random.number(0, 1) < 0.5 ? 0 : random.number(0, 1);
  }
  return tree;
}
struct Rubbing {
  Model model;
  Numbers q, v;
  SimulationOptions options = with_losses;

  Rubbing(std::uint64_t seed, const TreeRecipe& recipe)
      : model([&] {
          Random<double> random(seed);
          const Description tree = described(random_mechanism(random, recipe), random);
          return ModelBuilder(with_friction(with_springs(tree, random), random)).build();
        }()) {
    Random<double> random(seed + 1);
    q = random_configuration(model, seed), v = random_numbers(random, model.nv(), 1);
    for (double& v_c : v)
      if (random.number(0, 1) < 0.5) v_c = 0;
    options.drive = [](double t, Span, Span, std::span<double> tau) {
      for (std::size_t c = 0; c < tau.size(); ++c) tau[c] = 5 * std::sin(4 * t + static_cast<double>(c));
    };
  }
};

/// Expects that the friction of every sliding joint is f against its motion, and that of every resting joint
/// at most f.
void expect_coulomb(const Rubbing& at, const Trajectory& motion, int& sticking, int& sliding) {
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  const Tree<double>& tree = at.model.tree<double>();
  Workspace<> workspace(at.model, cut_tree);
  const std::size_t nv = at.v.size();
  Numbers force(nv), acting(nv), M(nv * nv);
  for (std::size_t k = 0; k < motion.size(); ++k) {
    inverse_dynamics(at.model, workspace, motion.q(k), motion.v(k), motion.a(k), force);
    at.options.drive(motion.t()[k], motion.q(k), motion.v(k), acting);
    add_spring_forces(at.model, workspace, motion.q(k), motion.v(k), acting);
    mass_matrix(at.model, workspace, motion.q(k), M);
    const auto largest = [](Span x) {
      return std::transform_reduce(
          x.begin(), x.end(), 0.0, [](double a, double b) { return std::max(a, b); },
          [](double x_c) { return std::abs(x_c); });
    };
    const double size =  // of the terms of M a, which may cancel each other
        std::max({1.0, largest(force), largest(acting), largest(M) * largest(motion.a(k))});
    for (std::size_t c = 0; c < nv; ++c) {
      const double v_c = motion.v(k)[c], f = tree.friction[c];
      const double friction = force[c] - acting[c] + tree.damping[c] * v_c;
      if (v_c == 0) {
        EXPECT_LE(std::abs(friction), f + 1e-6 * size)
            << k << ' ' << c;  // which slips by 1e-9 of what f does
        sticking += f > 0;
      } else if (std::abs(v_c) > 1e-9) {
        EXPECT_NEAR(friction, v_c > 0 ? -f : f, 1e-8 * size) << k << ' ' << c << ' ' << v_c;
        ++sliding;
      }
    }
  }
}

TEST(Friction, IsCoulombsOnRandomTrees) {
  int sticking = 0, sliding = 0;
  for_seeds(60, [&](std::uint64_t seed) {
    const Rubbing at(seed, {.most_bodies = 6, .always_mass = true});
    expect_coulomb(at, simulate(at.model, at.q, at.v, 0.5, {1e-7, 1e-9}, at.options), sticking, sliding);
    expect_coulomb(at, simulate_fixed(at.model, at.q, at.v, 0.2, 0.002, runge_kutta(4), at.options), sticking,
                   sliding);
  });
  EXPECT_GE(sticking, 1000);
  EXPECT_GE(sliding, 1000);
}

TEST(Friction, IsCoulombsForStiffMethods) {
  int sticking = 0, sliding = 0;
  for_seeds(20, [&](std::uint64_t seed) {
    const Rubbing at(seed, {.most_bodies = 5, .always_mass = true});
    const Trajectory motion = simulate_stiff(at.model, at.q, at.v, 0.2, 0.001, 0.8, at.options);
    expect_coulomb(at, motion, sticking, sliding);
    const Trajectory exact = simulate(at.model, at.q, at.v, 0.2, {1e-9, 1e-11}, at.options);
    EXPECT_LE(apart(at.model, last_q(exact), last_q(motion)), 2e-3);
  });
  EXPECT_GE(sticking, 300);
  EXPECT_GE(sliding, 300);
}

/// The energy that friction takes, Σ f |Δq|. No hinge turns back within a step, and there is no damping.
double lost_to_friction(const Model& model, const Trajectory& motion) {
  double lost = 0;
  for (std::size_t k = 1; k < motion.size(); ++k) {
    const Numbers x = difference(model, Numbers(motion.q(k - 1).begin(), motion.q(k - 1).end()),
                                 Numbers(motion.q(k).begin(), motion.q(k).end()));
    for (std::size_t c = 0; c < x.size(); ++c) lost += model.tree<double>().friction[c] * std::abs(x[c]);
  }
  return lost;
}

TEST(Friction, TakesTheEnergyThatIsMissing) {
  for_seeds(40, [](std::uint64_t seed) {
    Random<double> random(seed);
    Description chain{.name = "chain", .gravity = {0, 0, -9.81}};
    for (int k = 0; k < 5; ++k) {
      BodyDescription body{.name = "link" + std::to_string(k),
                           .predecessor = k == 0 ? "ground" : "link" + std::to_string(k - 1)};
      body.joint = {.kind = random.number(0, 1) < 0.7 ? JointKind::revolute : JointKind::prismatic,
                    .axis = random.vector(),
                    .point = {0.5 * k, 0, 0},
                    .dof = {{.friction = random.number(0, 4), .stiffness = 20}}};
      body.inertia = MassProperties{
          .mass = 1, .com = {0.5 * k + 0.2, 0, 0}, .Theta = {.1, .1, .1}, .in = GivenIn::construction_frame};
      chain.bodies.push_back(std::move(body));
    }
    const Model model = ModelBuilder(chain).build();
    const Trajectory motion =
        simulate(model, Numbers(5, 0.3), random_numbers(random, 5, 2), 3, tight, with_losses);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    Workspace<> workspace(model);
    const auto energy = [&](std::size_t k) {
      return energy_of(model, motion.q(k), motion.v(k)) + elastic_energy(model, workspace, motion.q(k));
    };
    const double lost = energy(0) - energy(motion.size() - 1);
    EXPECT_GT(lost, 1e-3);
    EXPECT_NEAR(lost_to_friction(model, motion), lost, 1e-8 * (1 + std::abs(energy(0))));
  });
}

/// Mechanisms with one degree of freedom stay at rest if the friction of all joints, weighted by their
/// relative velocities, is larger than the force of the weight.
TEST(Friction, HoldsLoopsTogether) {
  for (Description drawn : {four_bar(), bricard()}) {
    SCOPED_TRACE(drawn.name);
    for (BodyDescription& body : drawn.bodies) body.joint.dof = {{.friction = 1}};
    const Model weak = ModelBuilder(drawn).build();
    const Numbers q(static_cast<std::size_t>(weak.nq())), rest(q.size());
    LoopWorkspace<double> closed(weak);
    Numbers a(q.size());
    ASSERT_TRUE(forward_dynamics(weak, closed, Span(q), rest, rest, a).ok());
    Workspace<> workspace(weak, cut_tree);  // of the cut tree; a is the direction in which its weight moves
                                            // the mechanism
    Numbers g(q.size());
    inverse_dynamics(weak, workspace, Span(q), rest, rest, g);
    double power = 0, resisting = 0;
    for (std::size_t c = 0; c < a.size(); ++c) power -= g[c] * a[c], resisting += std::abs(a[c]);
    ASSERT_GT(power, 0);
    for (const double part : {0.999, 1.001}) {
      for (BodyDescription& body : drawn.bodies) body.joint.dof[0].friction = part * power / resisting;
      const Model model = ModelBuilder(drawn).build();
      const Trajectory motion = simulate(model, q, rest, 0.3, tight, with_losses);
      ASSERT_TRUE(motion.complete) << motion.stop_reason;
      EXPECT_EQ(apart(model, q, last_q(motion)) == 0, part > 1) << part;
      const Trajectory stiff = simulate_stiff(model, q, rest, 0.3, 0.01, 0.8, with_losses);
      ASSERT_TRUE(stiff.complete) << stiff.stop_reason;
      EXPECT_NEAR(apart(model, last_q(stiff), last_q(motion)), 0, part > 1 ? 0 : 1e-4);
    }
  }
}

/// The friction of sticking joints is found from the response of the accelerations to forces, with the loops
/// closed.
TEST(Friction, KnowsHowLoopsRespond) {
  for (const Description& drawn : {four_bar(), bricard(), gough()}) {
    SCOPED_TRACE(drawn.name);
    const Model model = ModelBuilder(drawn).build();
    Random<double> random(1);
    const AssemblyResult at =
        assemble(model, integrate(model, neutral(model), random_numbers(random, model.nv(), 0.1)),
                 random_numbers(random, model.nv()));
    ASSERT_EQ(at.status, AssemblyStatus::closed);
    ClosedMotion motion(model);
    motion.check(neutral(model), Numbers(at.v.size()));
    Numbers tau(at.v.size()), a(tau.size()), pushed(tau.size()), response(tau.size());
    ASSERT_TRUE(motion.accelerate(at.q, at.v, tau, {}, a).ok());
    for (std::size_t c = 0; c < tau.size(); ++c) {
      tau[c] = 1;
      ASSERT_TRUE(motion.accelerate(at.q, at.v, tau, {}, pushed).ok());
      tau[c] = 0;
      motion.factorize(at.q);
      motion.unit_force_response(static_cast<int>(c), response);
      EXPECT_LT((vector(response) - (vector(pushed) - vector(a))).norm(), 1e-9 * (1 + vector(pushed).norm()));
    }
  }
}

TEST(Friction, TakesTheEnergyThatIsMissingInLoops) {
  for (Description drawn : {four_bar(), bricard()}) {
    SCOPED_TRACE(drawn.name);
    for (BodyDescription& body : drawn.bodies) body.joint.dof = {{.friction = 0.7}};
    const Model model = ModelBuilder(drawn).build();
    const Numbers q(static_cast<std::size_t>(model.nq())), v(q.size());
    for (const bool fixed : {false, true}) {
      const Trajectory motion = fixed ? simulate_fixed(model, q, v, 5, 0.001, runge_kutta(4), with_losses)
                                      : simulate(model, q, v, 5, tight, with_losses);
      ASSERT_TRUE(motion.complete) << motion.stop_reason;
      const auto energy = [&](std::size_t k) { return energy_of(model, motion.q(k), motion.v(k)); };
      const double lost = energy(0) - energy(motion.size() - 1);
      EXPECT_GT(lost, 0.1);
      EXPECT_NEAR(lost_to_friction(model, motion), lost, 1e-7);
      EXPECT_EQ(motion.v(motion.size() - 1)[0], 0);  // it has come to rest
    }
  }
}

TEST(Friction, MeetsEventsOnTheWay) {
  const Model model = block(2);
  SimulationOptions options = driven([](double t) { return 3 * std::sin(t); });
  options.events.push_back({.value = [](double, Span q, Span) { return q[0] - 0.5; }, .direction = 1});
  const Trajectory motion = simulate(model, Numbers{0}, Numbers{0}, 20, {}, options);
  EXPECT_GE(motion.events.size(), 3u);
  options.events[0].terminal = true;
  const Trajectory ended = simulate(model, Numbers{0}, Numbers{0}, 20, {}, options);
  EXPECT_NEAR(last_q(ended)[0], 0.5, 1e-12);
}

TEST(Friction, CreepsInAbsoluteCoordinates) {
  const Model model = block(2);
  SimulationOptions options = driven([](double) { return 1.9; });
  options.coordinates = Coordinates::absolute;
  const auto crept = [&](double step) {
    const Trajectory motion = simulate_fixed(model, Numbers{0}, Numbers{0}, 1, step, runge_kutta(4), options);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    return last_q(motion)[0];
  };
  EXPECT_GT(crept(0.01), 0);
  EXPECT_LT(crept(0.01), 0.02);
  EXPECT_LT(crept(0.005), 0.7 * crept(0.01));
}

}  // namespace
}  // namespace friction
}  // namespace axode::test
