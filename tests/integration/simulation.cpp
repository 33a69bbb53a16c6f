#include <numbers>

#include "axode/constraints/assembly.hpp"
#include "axode/dynamics.hpp"
#include "axode/integration/methods.hpp"
#include "axode/io.hpp"
#include "axode/kinematics.hpp"
#include "tests/integration/motions.hpp"
#include "tests/support/refused_arguments.hpp"

/// Motions under forces: the orders of the schemes, the quantities that they conserve, dense output, events,
/// and refused arguments.
namespace axode::test {
namespace {

TEST(Simulation, HasTheOrdersOfItsMethodsOnTheGroup) {
  const Model model = test_tree();
  const State<double> at = test_state(model);
  SimulationOptions options;
  options.drive = [](double t, Span, Span, std::span<double> tau) {
    for (std::size_t c = 0; c < tau.size(); ++c) tau[c] = std::sin(3 * t + static_cast<double>(c));
  };
  const double until = 0.5;
  const Trajectory exact =
      simulate(model, at.q, at.v, until, {.relative = 1e-13, .absolute = 1e-13}, options);
  ASSERT_TRUE(exact.complete) << exact.stop_reason;
  for (const LocalCoordinates coordinates : both_local_coordinates)
    for (int order = 1; order <= 5; ++order) {
      SCOPED_TRACE(order);
      const int n = order == 1 ? 400 : order == 5 ? 40 : 80;
      const auto error = [&](int steps) {
        const Trajectory motion = simulate_fixed(model, at.q, at.v, until, until / steps, runge_kutta(order),
                                                 with(coordinates, options));
        EXPECT_EQ(motion.steps, static_cast<std::size_t>(steps));
        return apart(model, last_q(exact), last_q(motion));
      };
      EXPECT_NEAR(std::log2(error(n) / error(2 * n)), order, order == 5 ? 0.9 : 0.35);
    }
}

TEST(Simulation, OfStiffSystemsIsOfSecondOrderOnTheGroup) {
  const Model model = test_tree();
  const State<double> at = test_state(model);
  const SimulationOptions options = driven_and_damped();
  const Trajectory exact = simulate(model, at.q, at.v, 0.5, {.relative = 1e-12, .absolute = 1e-12}, options);
  for (const LocalCoordinates coordinates : both_local_coordinates)
    for (const double rho : {1.0, 0.8, 0.3}) {
      SCOPED_TRACE(rho);
      const auto error = [&](int steps) {
        const Trajectory motion =
            simulate_stiff(model, at.q, at.v, 0.5, 0.5 / steps, rho, with(coordinates, options));
        EXPECT_TRUE(motion.complete) << motion.stop_reason;
        return apart(model, last_q(exact), last_q(motion));
      };
      EXPECT_NEAR(std::log2(error(100) / error(200)), 2, 0.15);
    }
}

/// A body that turns about a fixed axis turns exactly with exp. A step by
/// cay of an explicit method turns it by 2 atan(h ω/2). The midpoint rule
/// (D14.9) reads v (1 + (h v/4)²) = ω there, and turns it by 4 atan(h v/4).
TEST(Simulation, WithCayleysMapErrsInATurnAboutAFixedAxis) {
  Description description{.name = "rotor", .gravity = {}, .bodies = {}, .frames = {}};
  description.bodies.push_back({.name = "rotor",
                                .joint = {.kind = JointKind::spherical},
                                .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 2}}});
  const Model model = ModelBuilder(description).build();
  const Numbers q{0, 0, 0, 1}, w{0, 0, 3};
  const double h = 0.1;
  double v = w[2];
  for (int iteration = 0; iteration < 30; ++iteration) v = w[2] / (1 + h * v / 4 * (h * v / 4));
  for (const LocalCoordinates coordinates : both_local_coordinates) {
    const bool by_exp = coordinates == LocalCoordinates::exponential;
    const auto turn = [&](const Trajectory& motion) { return difference(model, q, last_q(motion))[2]; };
    EXPECT_NEAR(turn(simulate_fixed(model, q, w, 1, h, runge_kutta(1), with(coordinates))),
                by_exp ? 3 : 20 * std::atan(h * w[2] / 2), 1e-12);
    EXPECT_NEAR(turn(simulate_symplectic(model, q, w, 1, h, 2, with(coordinates))),
                by_exp ? 3 : 40 * std::atan(h * v / 4), 1e-12);
  }
}

TEST(Simulation, IsTheSameWhereverTheSceneStands) {
  int moved = 0;
  for_seeds(40, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const Mechanism drawn = random_mechanism(random, {.most_bodies = 6, .always_mass = true});
    const SE3<> D{random.rotation(), random.vector(3)};
    const auto built = [&](const Mechanism& scene) {
      Random<double> of_telling(seed);
      return ModelBuilder(described(scene, of_telling)).build();
    };
    const Model here = built(drawn), there = built(displaced(D, drawn));
    State<double> at = random_state(here, random);
    std::erase_if(at.wrenches, [](const AppliedWrench<>& load) {
      return load.frame == 0 || load.representation != Representation::body;
    });
    const SimulationOptions options{.loads = at.wrenches, .joint_losses = true};
    const auto compare = [&](const char* method, double bound, const auto& run) {
      SCOPED_TRACE(method);
      const Trajectory one = run(here), other = run(there);
      ASSERT_EQ(one.complete, other.complete);
      if (!one.complete || one.t().empty()) return;
      ++moved;
      EXPECT_LE(apart(here, last_q(one), last_q(other)), bound);
      double away = 0, size = 1;
      for (std::size_t c = 0; c < at.v.size(); ++c) {
        away = std::max(away, std::abs(last_v(one)[c] - last_v(other)[c]));
        size = std::max(size, std::abs(last_v(one)[c]));
      }
      EXPECT_LE(away, bound * size);
    };
    const double until = 0.02, h = 2e-3;
    compare("rk4", 1e-10, [&](const Model& model) {
      return simulate_fixed(model, at.q, at.v, until, h, runge_kutta(4), options);
    });
    compare("generalized_alpha", 1e-9,
            [&](const Model& model) { return simulate_stiff(model, at.q, at.v, until, h, 0.8, options); });
    SimulationOptions smooth = options;
    smooth.joint_losses = false;
    compare("suzuki4", 1e-9,
            [&](const Model& model) { return simulate_symplectic(model, at.q, at.v, until, h, 4, smooth); });
    compare("rk4_momenta", 1e-9, [&](const Model& model) {
      return simulate_momenta(model, at.q, at.v, until, h, runge_kutta(4), smooth);
    });
  });
  EXPECT_GT(moved, 0);
}

TEST(Simulation, OfAStiffSpringIsQuietWhereTheMotionIs) {
  // A spring of 1e8 N m/rad at the first of two hinges balances the weight at the start. Explicit methods
  // would need steps of 0.07 ms.
  const Model model = ModelBuilder(two_links()).build();
  const double stiffness = 1e8;
  Workspace<> workspace(model);
  Numbers weight(2);
  gravity_torques(model, workspace, Numbers{0, 0}, weight);
  SimulationOptions options;
  options.drive = [&](double, Span q, Span, std::span<double> tau) {
    tau[0] = weight[0] - stiffness * q[0], tau[1] = 0;
  };
  const auto elbow = [&](double step) {
    const Trajectory motion = simulate_stiff(model, Numbers{0, 0}, Numbers{0, 0}, 0.5, step, 0.8, options);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_LE(std::abs(last_q(motion)[0]), 1e-5);
    EXPECT_LE(motion.evaluations, 12 * motion.steps);
    return last_q(motion)[1];
  };
  const double coarse = elbow(2e-3), middle = elbow(1e-3), fine = elbow(5e-4);
  EXPECT_NEAR(std::log2((coarse - middle) / (middle - fine)), 2, 0.3);
}

TEST(Simulation, KeepsEnergyAndMomentumAsFarAsItsToleranceGoes) {
  for_seeds(30, [&](std::uint64_t seed) {
    const Mover subject(seed);
    const auto energy = [&](Span q, Span v) {
      Workspace<> workspace(subject.model);
      return kinetic_energy(subject.model, workspace, q, v) + potential_energy(subject.model, workspace, q);
    };
    const Trajectory motion = simulate(subject.model, subject.state.q, subject.state.v, 0.2,
                                       {.relative = 1e-10, .absolute = 1e-12});
    if (!motion.complete) return;  // some joints move no mass
    const double before = energy(motion.q(0), motion.v(0)), after = energy(last_q(motion), last_v(motion));
    Workspace<> workspace(subject.model);
    const double scale = std::max(
        {1.0, std::abs(before), kinetic_energy(subject.model, workspace, last_q(motion), last_v(motion))});
    EXPECT_NEAR(before, after, 1e-6 * scale);
  });
}

TEST(Simulation, InBetweenIsAsGoodAsTheSteps) {
  const Model model = test_tree();
  const State<double> at = test_state(model);
  const auto worst = [&](double step) {
    const Trajectory coarse = simulate_fixed(model, at.q, at.v, 0.4, step, runge_kutta(5));
    const Trajectory exact =
        simulate(model, at.q, at.v, 0.4, {.relative = 1e-13, .absolute = 1e-13, .largest_step = 1e-3});
    double error = 0;
    Numbers q(at.q.size()), v(at.v.size()), q_exact(q.size()), v_exact(v.size());
    for (const double t : {0.013, 0.1377, 0.211, 0.3993}) {
      coarse.at(t, q, v), exact.at(t, q_exact, v_exact);
      double dv = 0;
      for (std::size_t c = 0; c < v.size(); ++c) dv = std::max(dv, std::abs(v[c] - v_exact[c]));
      error = std::max({error, apart(model, q, q_exact), 0.01 * dv});
    }
    return error;
  };
  const double coarse = worst(0.02), fine = worst(0.01);
  EXPECT_LE(fine, coarse / 14);  // the order is four at least
  EXPECT_LE(fine, 1e-5);
}

/// Bodies that turn by more than half a turn in one step, or by several turns. With Θ_z = Θ_x their twists
/// are constant.
struct FastBodies {
  Model model;
  Numbers q, v;

  explicit FastBodies(double Theta_z = 1)
      : model([&] {
          Description d{.name = "fast bodies", .gravity = {0, 0, 0}};
          for (const auto& [name, kind] : {std::pair{"ball", JointKind::spherical},
                                           {"satellite", JointKind::free},
                                           {"puck", JointKind::planar},
                                           {"rotor", JointKind::revolute}}) {
            BodyDescription body{.name = name, .predecessor = "ground"};
            body.joint = {.name = name, .kind = kind};
            body.inertia = MassProperties{.mass = 2, .com = {0, 0, 0}, .Theta = {1, 1, Theta_z}};
            d.bodies.push_back(std::move(body));
          }
          return ModelBuilder(d).build();
        }()) {
    q = neutral(model);
    v = {0.3, -0.4, 20, /**/ 1, 2, -15, 0.05, 0.1, -0.75, /**/ 12, 0, 0, /**/ 25};
  }
};

/// Compares a motion with an exact one, at the ends of its steps and between them, up to the end of the
/// shorter one: with such long steps compositions of high order may not converge.
void expect_to_follow(const Trajectory& motion, const Trajectory& exact, double tolerance) {
  ASSERT_GT(motion.size(), 4U) << motion.stop_reason;
  const Model& model = motion.model();
  const double energy = energy_of(model, exact.q(0), exact.v(0));
  Numbers q(exact.q(0).size()), v(exact.v(0).size()), a(v), q_exact(q), v_exact(v), a_exact(v);
  double longest = 0;
  for (std::size_t k = 0; k + 1 < motion.size(); ++k) {
    const double h = motion.t()[k + 1] - motion.t()[k];
    longest = std::max(longest, h);
    for (const double s : {0.0, 0.1, 0.35, 0.5, 0.8}) {
      const double t = motion.t()[k] + s * h;
      motion.at(t, q, v, a), exact.at(t, q_exact, v_exact, a_exact);
      EXPECT_LT(apart(model, q, q_exact), tolerance) << t << " s";
      for (std::size_t c = 0; c < v.size(); ++c) {
        EXPECT_NEAR(v[c], v_exact[c], 10 * tolerance)
            << "v of " << velocity_names(model)[c] << ", " << t << " s";
        EXPECT_NEAR(a[c], a_exact[c], 100 * tolerance)
            << "a of " << velocity_names(model)[c] << ", " << t << " s";
      }
      EXPECT_NEAR(energy_of(model, q, v), energy, 10 * tolerance * energy);
    }
  }
  EXPECT_GT(20 * longest, std::numbers::pi) << "no step turns the ball by more than half a turn";
}

TEST(Simulation, InBetweenFollowsBodiesThatTurnFast) {
  const FastBodies fast;
  const auto& [model, q, v] = fast;
  const Trajectory exact = simulate(model, q, v, 2, {1e-13, 1e-13, 0, 0.02});
  for (const auto& [name, method] : methods)
    for (const auto& [kind, coordinates] : coordinate_kinds) {
      if (method.adapts && method.touches) continue;  // its steps are limited to a fiftieth of the motion
      SCOPED_TRACE(testing::Message() << name << ", " << kind);
      SimulationOptions options;
      options.coordinates = coordinates;
      Trajectory motion(model);
      try {
        motion = method.simulate({model, q, v, 2, method.adapts ? 0 : 0.17, {}, 0.8, options});
      } catch (const std::invalid_argument&) {
        continue;  // this scheme computes in other coordinates
      }
      expect_to_follow(motion, exact, 1e-7);
    }
}

TEST(Simulation, InBetweenFollowsBodiesThatTurnFastAndNutate) {
  const FastBodies fast(1.01);
  Numbers v = fast.v;
  v[0] = 0.03, v[1] = 0.04;
  std::fill_n(v.begin() + 3, 2, 0.0), std::fill_n(v.begin() + 6, 2, 0.0);
  const Trajectory exact = simulate(fast.model, fast.q, v, 4, {1e-13, 1e-13, 0, 0.02});
  expect_to_follow(simulate(fast.model, fast.q, v, 4, {1e-5, 1e-6}), exact, 1e-3);
}

/// Events that depend on the orientation of a fast body occur many times in one step.
TEST(Simulation, MeetsEventsOfBodiesThatTurnFast) {
  const FastBodies fast;
  const Model& model = fast.model;
  Workspace<> workspace(model);
  std::vector<SE3<>> C(static_cast<std::size_t>(model.n_frames()));
  for (const auto& [kind, coordinates] : coordinate_kinds) {
    SCOPED_TRACE(kind);
    SimulationOptions options;
    options.coordinates = coordinates;
    for (int body = 1; body <= 4; ++body)
      options.events.push_back({.value = [&, body](double, Span q_t, Span) {
        poses<double>(model, workspace, q_t, C);
        return C[static_cast<std::size_t>(body)].R.x.y;
      }});
    const double until = 4;
    const Trajectory motion = simulate(model, fast.q, fast.v, until, {}, options);
    std::array<int, 4> met{};
    for (const Trajectory::EventOccurrence& one : motion.events) ++met[one.event];
    const std::array<double, 4> spin{20, 15, 12, 25};
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_NEAR(met[k], spin[k] * until / std::numbers::pi, 1.5) << "body " << k + 1;
  }
}

/// Two four-bars side by side that can move in three ways in the flat configuration, through which they swing
/// ten times.
TEST(Simulation, PassesWhereBranchesMeetAsWellAsItsToleranceSays) {
  const Model model = load(AXODE_SOURCE_DIR "/examples/robots/n_four_bar.toml");
  for (const double speed : {0.9, 0.97, 1.0, 1.1, 1.3, 1.5}) {
    SCOPED_TRACE(speed);
    const AssemblyResult at = assemble(model, neutral(model), Numbers{-speed, speed, 0, -speed, -speed});
    const Trajectory motion = simulate(model, at.q, at.v, 10, {1e-10, 1e-12});
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_LT(energy_error(motion), 2e-7);
    EXPECT_LT(motion.steps, 1100U);
    EXPECT_GT(motion.uncontrolled, 0U);
  }
}

TEST(Simulation, ControlsTheErrorsOfStepsWhereNoBranchesMeet) {
  const Model model = load(AXODE_SOURCE_DIR "/examples/robots/four_bar.toml");
  const AssemblyResult at = assemble(model, neutral(model), Numbers{});
  const Trajectory motion = simulate(model, at.q, at.v, 1);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_EQ(motion.uncontrolled, 0U);
}

/// A model with a body of 1 kg that slides along an axis.
Model slide(const Vec3<>& axis) {
  return ModelBuilder("slide")
      .add({.name = "block",
            .joint = {.kind = JointKind::prismatic, .axis = axis},
            .inertia = MassProperties{.mass = 1, .Theta = {.1, .1, .1}}})
      .build();
}

TEST(Simulation, MeetsEventsWhereTheyAre) {
  const Model model = slide({0, 0, 1});
  SimulationOptions options;
  options.events.push_back({.value = [](double, Span q, Span) { return q[0] - 1; }});
  options.events.push_back(
      {.value = [](double, Span q, Span) { return q[0]; }, .direction = -1, .terminal = true});
  options.events.push_back({.value = [](double, Span q, Span) { return q[0] - 1.5; }, .direction = 1});
  const double g = -model.gravity().z;
  for (const bool adaptive : {true, false}) {
    const Trajectory motion =
        adaptive ? simulate(model, Numbers{2}, Numbers{0}, 5, {}, options)
                 : simulate_fixed(model, Numbers{2}, Numbers{0}, 5, 0.05, runge_kutta(4), options);
    ASSERT_EQ(motion.events.size(), 2u);
    EXPECT_EQ(motion.events[0].event, 0u);
    EXPECT_NEAR(motion.events[0].t, std::sqrt(2 / g), 1e-9);
    EXPECT_NEAR(motion.events[1].t, std::sqrt(4 / g), 1e-9);
    EXPECT_NEAR(motion.t().back(), std::sqrt(4 / g), 1e-9);
    EXPECT_NEAR(last_q(motion)[0], 0, 1e-8);
    EXPECT_TRUE(motion.complete);
  }
}

/// A body that rises above a height and falls back within one step causes two events, however short the time
/// between them is.
TEST(Simulation, MeetsEventsTwiceInOneStep) {
  Description drop{.name = "ball"};
  drop.bodies.push_back({.name = "ball",
                         .joint = {.kind = JointKind::free},
                         .inertia = MassProperties{.mass = 1, .Theta = {.1, .1, .1}}});
  const Model model = ModelBuilder(drop).build();
  const Numbers still = neutral(model), up{0, 0, 0, 0, 0, 3};
  const double g = -model.gravity().z;
  for (const double below_top : {1e-1, 1e-4, 1e-9}) {
    const double height = 9 / (2 * g) - below_top, half = std::sqrt(2 * below_top / g);
    SimulationOptions options;
    options.events.push_back({.value = [&](double, Span q, Span) { return q[6] - height; }});
    options.events.push_back({.value = [&](double, Span q, Span) { return q[6] - height; }, .direction = -1});
    const Trajectory motion = simulate(model, still, up, 1, {}, options);
    ASSERT_EQ(motion.events.size(), 3u) << below_top;
    EXPECT_NEAR(motion.events[0].t, 3 / g - half, 1e-7);
    EXPECT_NEAR(motion.events[1].t, 3 / g + half, 1e-7);
    EXPECT_NEAR(motion.events[2].t, 3 / g + half, 1e-7);
  }
}
TEST(Simulation, BouncesUntilItLies) {
  const Model model = slide({0, 0, 1});
  SimulationOptions options;
  options.events.push_back(
      {.value = [](double, Span q, Span) { return q[0]; }, .direction = -1, .terminal = true});
  Numbers q{1}, v{0};
  double t = 0, expected = std::sqrt(2 / -model.gravity().z);
  for (int bounce = 0; bounce < 20; ++bounce) {
    const Trajectory flight = simulate(model, q, v, 10, {}, options);
    ASSERT_EQ(flight.events.size(), 1u) << bounce;
    t += flight.t().back();
    EXPECT_NEAR(t, expected, 1e-9) << bounce;
    q = {last_q(flight)[0]}, v = {-0.5 * flight.v().back()};
    EXPECT_NEAR(q[0], 0, 1e-12);
    expected += 2 * v[0] / -model.gravity().z;
  }
}

TEST(Simulation, EndsWhereStepsBecomeHopelesslyShort) {
  SimulationOptions options;
  options.drive = [](double, Span, Span v, std::span<double> tau) { tau[0] = v[0] > 0 ? -1e4 : 1e4; };
  const Trajectory stuck = simulate(slide({1, 0, 0}), Numbers{.2}, Numbers{0.1}, 10, {}, options);
  EXPECT_FALSE(stuck.complete);
  EXPECT_THAT(stuck.stop_reason,
              testing::HasSubstr("a force is discontinuous at a state in which the motion stays"));
  EXPECT_LE(stuck.steps, 100'000u);
}
/// A force sin t in inertial axes moves a turning body of 2 kg by (t - sin t)/2.
TEST(Simulation, FeelsLoadsThatAreComputed) {
  Description space{.name = "space", .gravity = {}};
  space.bodies.push_back({.name = "body",
                          .joint = {.kind = JointKind::free},
                          .inertia = MassProperties{.mass = 2, .Theta = {.3, .2, .1}}});
  const Model model = ModelBuilder(space).build();
  const int body = model.frame_index("body");
  SimulationOptions options;
  options.computed_loads = [body](double t, Span, Span, std::vector<AppliedWrench<>>& loads) {
    loads.emplace_back(body, Wrench<Hybrid>{{}, {std::sin(t), 0, 0}});
  };
  const Numbers q = neutral(model), v{1, 2, 3, 0, 0, 0};
  const double until = 2, moved = (until - std::sin(until)) / 2;
  for (const Coordinates coordinates :
       {Coordinates::relative, Coordinates::absolute, Coordinates::absolute_SO3xR3})
    for (const auto& [name, method] : methods) {
      options.coordinates = coordinates;
      Trajectory motion(model);
      try {
        motion = method.simulate({model, q, v, until, method.adapts ? 0 : 0.002, {}, 0.8, options});
      } catch (const std::invalid_argument&) {
        continue;  // this scheme computes in other coordinates
      }
      ASSERT_TRUE(motion.complete) << name << motion.stop_reason;
      Workspace<> workspace(model);
      std::vector<SE3<>> C(static_cast<std::size_t>(model.n_frames()));
      poses(model, workspace, last_q(motion), C);
      EXPECT_NEAR(C[static_cast<std::size_t>(body)].r.x, moved, name == "euler" ? 2e-2 : 1e-4) << name;
    }
}

/// A long motion that begins with many short steps must not be taken for one that is stuck.
TEST(Simulation, WaitsUntilWhatIsStiffHasDiedOut) {
  SimulationOptions options;
  options.drive = [](double t, Span q, Span v, std::span<double> tau) {
    tau[0] = -std::exp(-40 * t) * (1e10 * q[0] + 1e3 * v[0]);
  };
  const Trajectory motion =
      simulate(slide({1, 0, 0}), Numbers{1e-3}, Numbers{0}, 1e6, {.relative = 1e-6}, options);
  EXPECT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_GE(motion.steps, 10'000u);
}

TEST(Simulation, EndsWithAReasonWhereItCannotGoOn) {
  Description massless{.name = "arm"};
  BodyDescription body{.name = "rod", .predecessor = "ground"};
  body.joint = {.name = "hinge", .kind = JointKind::revolute, .axis = {0, 1, 0}};
  massless.bodies.push_back(body);
  const Trajectory none = simulate(ModelBuilder(massless).build(), Numbers{0}, Numbers{0}, 1);
  EXPECT_FALSE(none.complete);
  EXPECT_THAT(none.stop_reason, testing::HasSubstr("\"hinge\""));

  const Model model = test_tree();
  const State<double> at = test_state(model);
  SimulationOptions options;
  options.drive = [](double, Span, Span, std::span<double> tau) { std::ranges::fill(tau, 1e200); };
  const Trajectory burst = simulate(model, at.q, at.v, 1, {}, options);
  EXPECT_FALSE(burst.complete);
  EXPECT_LE(burst.steps, 100u);
  options.drive = [](double t, Span, Span, std::span<double> tau) {
    std::ranges::fill(tau, 0.0);
    if (t > 0.1) tau[7] = std::nan("");
  };
  for (const Trajectory& motion : {simulate(model, at.q, at.v, 1, {}, options),
                                   simulate_fixed(model, at.q, at.v, 1, 0.01, runge_kutta(4), options)}) {
    EXPECT_FALSE(motion.complete);
    EXPECT_THAT(motion.stop_reason,
                testing::HasSubstr("the drive forces are not finite at joint \"ball joint"));
    EXPECT_GT(motion.t().back(), 0.08);
    EXPECT_LT(motion.t().back(), 0.11);
  }
  options.drive = {};
  options.monitor = [](double t) { return t < 0.2; };
  const Trajectory half = simulate_fixed(model, at.q, at.v, 1, 0.01, runge_kutta(4), options);
  EXPECT_NEAR(half.t().back(), 0.2, 1e-9);
  EXPECT_THAT(half.stop_reason, testing::HasSubstr("interrupted"));
}

TEST(Simulation, RefusesWhatItCannotUse) {
  const Model model = test_tree();
  const State<double> at = test_state(model);
  const auto fixed = [&](double until, double step) {
    return message_of([&] { (void)simulate_fixed(model, at.q, at.v, until, step); });
  };
  EXPECT_THAT(message_of([&] { (void)simulate_stiff(model, at.q, at.v, 1, 0.1, 1.5); }),
              testing::StartsWith("spectral radius is 1.5"));
  EXPECT_THAT(message_of([&] { (void)simulate_stiff(model, at.q, at.v, 1, -0.1); }),
              testing::StartsWith("step is -0.1"));
  EXPECT_THAT(fixed(1, 0), testing::StartsWith("step is 0 s"));
  EXPECT_THAT(fixed(1, -1), testing::StartsWith("step is -1 s"));
  EXPECT_THAT(fixed(-1, 0.1), testing::StartsWith("until is -1 s"));
  EXPECT_THAT(fixed(std::nan(""), 0.1), testing::StartsWith("until is nan"));
  EXPECT_EQ(simulate_fixed(model, at.q, at.v, 0, 0.1).size(), 1u);
  EXPECT_TRUE(simulate(model, at.q, at.v, 1e-300).complete);
  Numbers v = at.v;
  v[2] = std::numeric_limits<double>::infinity();
  EXPECT_THAT(message_of([&] { (void)simulate(model, at.q, v, 1); }), testing::HasSubstr("not finite"));
  EXPECT_THAT(message_of([&] { (void)simulate(model, at.q, at.v, 1, {.relative = -1}); }),
              testing::StartsWith("relative tolerance is -1"));
  EXPECT_THAT(message_of([&] { (void)simulate(model, at.q, at.v, 1, {.relative = 0, .absolute = 0}); }),
              testing::StartsWith("relative and absolute tolerance are 0"));
  const Trajectory motion = simulate(model, at.q, at.v, 0.1);
  Numbers q(at.q.size()), u(at.v.size());
  EXPECT_THAT(message_of([&] { motion.at(0.2, q, u); }), testing::StartsWith("t is 0.2"));
}

}  // namespace
}  // namespace axode::test
