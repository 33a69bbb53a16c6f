#include <gmock/gmock.h>

#include <random>

#include "axode/dynamics.hpp"
#include "tests/integration/motions.hpp"
#include "tests/support/refused_arguments.hpp"

/// Schemes in (q, p): their orders, symplecticity, reversibility, momenta that stay to rounding, and energies
/// without drift.
namespace axode::test {
namespace {

Numbers momenta_of(const Model& model, Span q, Span v) {
  Workspace<> workspace(model);
  Numbers p(v.size());
  momenta(model, workspace, q, v, p);
  return p;
}
double dot(const Numbers& x, const Numbers& y) {
  double sum = 0;
  for (std::size_t k = 0; k < x.size(); ++k) sum += x[k] * y[k];
  return sum;
}

TEST(ConfigurationGroup, HasDualsOfItsMaps) {
  const Model model = test_tree();
  for (const LocalCoordinates coordinates : both_local_coordinates) {
    const ConfigurationGroup<double> group(model.tree<double>(), coordinates);
    Random<double> random(3);
    const auto numbers = [&] {
      Numbers x(static_cast<std::size_t>(model.nv()));
      for (double& x_k : x) x_k = random.number(-2, 2);
      return x;
    };
    const Numbers x = numbers(), y = numbers(), p = numbers();
    Numbers back(x), of_p(p.size()), of_y(p.size()), carried(p.size());
    for (double& x_k : back) x_k = -x_k;
    group.ad_transpose(x.data(), p.data(), of_p.data()), group.bracket(x.data(), y.data(), of_y.data());
    EXPECT_NEAR(dot(of_p, y), dot(p, of_y), 1e-13);
    group.dexp_transpose(x.data(), p.data(), of_p.data()), group.velocity(back.data(), y.data(), of_y.data());
    EXPECT_NEAR(dot(of_p, y), dot(p, of_y), 1e-13);
    group.Ad_transpose(x.data(), p.data(), carried.data());  // dexp_x = Ad_{exp x} dexp_{-x}
    group.dexp_transpose(back.data(), carried.data(), carried.data());
    for (std::size_t k = 0; k < p.size(); ++k) EXPECT_NEAR(carried[k], of_p[k], 1e-13);
  }
}

TEST(ConfigurationGroup, HasTheVelocitiesAndAccelerationsOfItsCoordinates) {
  const Model model = test_tree();
  const State<double> at = test_state(model);
  for (const LocalCoordinates coordinates : both_local_coordinates) {
    const ConfigurationGroup<double> group(model.tree<double>(), coordinates);
    Random<double> random(4);
    const Numbers x = random_numbers(random, model.nv()), y = random_numbers(random, model.nv()),
                  z = random_numbers(random, model.nv());
    const auto along = [&](const Numbers& from, const Numbers& by, double t) {
      Numbers out(from);
      for (std::size_t c = 0; c < out.size(); ++c) out[c] += t * by[c];
      return out;
    };
    const double h = 1e-4;
    const auto difference_of = [&](const auto& f) {
      const Numbers after = f(h), before = f(-h), later = f(2 * h), earlier = f(-2 * h);
      Numbers out(after);
      for (std::size_t c = 0; c < out.size(); ++c)
        out[c] = (8 * (after[c] - before[c]) - (later[c] - earlier[c])) / (12 * h);
      return out;
    };
    Numbers q(at.q), velocity(x), acceleration(x), back(x);
    group.move(at.q, x, q);
    group.velocity(x, y, velocity);
    group.acceleration(x, y, z, acceleration);
    group.rate(x, velocity, back);
    const Numbers of_places = difference_of([&](double t) {
      Numbers there(at.q), out(x);
      group.move(at.q, along(x, y, t), there);
      group.difference(q, there, out);
      return out;
    });
    const Numbers of_velocities = difference_of([&](double t) {
      Numbers out(x);
      group.velocity(along(x, y, t), along(y, z, t), out);
      return out;
    });
    for (std::size_t c = 0; c < x.size(); ++c) {
      EXPECT_NEAR(velocity[c], of_places[c], 1e-9);
      EXPECT_NEAR(acceleration[c], of_velocities[c], 1e-9);
      EXPECT_NEAR(back[c], y[c], 1e-12);
    }
    Numbers twice(at.q), step(x), whole(at.q);
    group.move_twice(at.q, step, twice);
    group.move(q, x, whole);
    EXPECT_LE(apart(model, twice, whole), 1e-13);
  }
}

TEST(ConservingSchemes, HaveTheirOrdersOnTheGroup) {
  const Model model = test_tree();
  const State<double> at = test_state(model);
  const SimulationOptions exponential = driven_and_damped();
  const Trajectory exact =
      simulate(model, at.q, at.v, 0.5, {.relative = 1e-13, .absolute = 1e-13}, exponential);
  const auto order_of = [&](const auto& run, int n) {
    const auto error = [&](int steps) {
      const Trajectory motion = run(0.5 / steps);
      EXPECT_TRUE(motion.complete) << motion.stop_reason;
      return apart(model, last_q(exact), last_q(motion));
    };
    return std::log2(error(n) / error(2 * n));
  };
  for (const LocalCoordinates coordinates : both_local_coordinates) {
    const SimulationOptions options = with(coordinates, exponential);
    for (const int order : {2, 4, 6})
      EXPECT_NEAR(
          order_of([&](double h) { return simulate_symplectic(model, at.q, at.v, 0.5, h, order, options); },
                   order == 2 ? 100 : 20),
          order, 0.25);
    for (const int order : {1, 2, 3, 4})
      EXPECT_NEAR(order_of(
                      [&](double h) {
                        return simulate_momenta(model, at.q, at.v, 0.5, h, runge_kutta(order), options);
                      },
                      order == 1 ? 1000 : 80),
                  order, 0.25);
  }
}

TEST(ConservingSchemes, AgreeWithTheDynamicsOfAnyTree) {
  for_seeds(40, [&](std::uint64_t seed) {
    Mover subject(seed);
    SimulationOptions options;
    Random<double> random(seed);
    options.loads = random_state(subject.model, random).wrenches;
    const Trajectory exact = simulate(subject.model, subject.state.q, subject.state.v, 0.02,
                                      {.relative = 1e-11, .absolute = 1e-12}, options);
    if (!exact.complete) return;  // some joints move no mass
    const auto expect_order = [&](const auto& run, double ratio) {
      const Trajectory coarse = run(1e-3), fine = run(0.5e-3);
      ASSERT_TRUE(fine.complete && coarse.complete) << fine.stop_reason << coarse.stop_reason;
      const double error = apart(subject.model, last_q(exact), last_q(fine));
      EXPECT_LE(error, std::max(apart(subject.model, last_q(exact), last_q(coarse)) / ratio, 1e-9));
    };
    expect_order(
        [&](double h) {
          return simulate_symplectic(subject.model, subject.state.q, subject.state.v, 0.02, h, 2, options);
        },
        3);
    expect_order(
        [&](double h) {
          return simulate_momenta(subject.model, subject.state.q, subject.state.v, 0.02, h, runge_kutta(4),
                                  options);
        },
        8);
  });
}

/// How far a step is from being symplectic: the largest entry of J B(p_0) Jᵀ - B(p_1), with the derivative J
/// of the step and the Poisson matrix B = [[0, 1], [-1, Λ]], Λ w = ad_wᵀ p.
template <class Run> double symplectic_error(const Model& model, const State<double>& at, const Run& run) {
  const ConfigurationGroup<double> group(model.tree<double>());
  const std::size_t nv = at.v.size();
  const Numbers p_0 = momenta_of(model, at.q, at.v);
  struct Point {
    Numbers q, p;
  };
  const auto step = [&](const Numbers& q, const Numbers& p) {
    Workspace<> workspace(model);
    Numbers v(nv);
    EXPECT_TRUE(from_momenta(model, workspace, q, p, v).ok());
    const Trajectory motion = run(q, v);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    return Point{Numbers(last_q(motion).begin(), last_q(motion).end()),
                 momenta_of(model, last_q(motion), last_v(motion))};
  };
  const Point end = step(at.q, p_0);
  const double e = 1e-3;
  Eigen::MatrixXd J(2 * nv, 2 * nv);
  for (std::size_t k = 0; k < 2 * nv; ++k) {
    const auto moved = [&](double by) {
      Numbers q = at.q, p = p_0, x(nv), out(2 * nv);
      if (k < nv)
        x[k] = by, group.move(q.data(), x.data(), q.data());
      else
        p[k - nv] += by;
      const Point to = step(q, p);
      group.difference(end.q.data(), to.q.data(), out.data());
      for (std::size_t c = 0; c < nv; ++c) out[nv + c] = to.p[c] - end.p[c];
      return Eigen::VectorXd(Eigen::Map<Eigen::VectorXd>(out.data(), static_cast<Eigen::Index>(2 * nv)));
    };
    J.col(static_cast<Eigen::Index>(k)) =
        (8 * (moved(e) - moved(-e)) - (moved(2 * e) - moved(-2 * e))) / (12 * e);
  }
  const auto poisson = [&](const Numbers& p) {
    const auto n = static_cast<Eigen::Index>(nv);
    Eigen::MatrixXd B = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    B.topRightCorner(n, n).setIdentity(), B.bottomLeftCorner(n, n) = -Eigen::MatrixXd::Identity(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      Numbers unit(nv), image(nv);
      unit[static_cast<std::size_t>(k)] = 1;
      group.ad_transpose(unit.data(), p.data(), image.data());
      B.col(n + k).tail(n) = Eigen::Map<Eigen::VectorXd>(image.data(), n);
    }
    return B;
  };
  return (J * poisson(p_0) * J.transpose() - poisson(end.p)).cwiseAbs().maxCoeff();
}

TEST(ConservingSchemes, AreSymplecticOnJointsWithSeveralVelocities) {
  const Model model = test_tree();
  const State<double> at = test_state(model);
  const double h = 0.02;
  for (const LocalCoordinates coordinates : both_local_coordinates)
    for (const int order : {2, 4, 6}) {
      SCOPED_TRACE(order);
      EXPECT_LE(symplectic_error(model, at,
                                 [&](Span q, Span v) {
                                   return simulate_symplectic(model, q, v, h, h, order, with(coordinates));
                                 }),
                1e-8);
    }
  EXPECT_GT(
      symplectic_error(model, at,
                       [&](Span q, Span v) { return simulate_momenta(model, q, v, h, h, runge_kutta(2)); }),
      1e-5);
}

TEST(ConservingSchemes, GoBackTheWayTheyCame) {
  const Model model = test_tree();
  const State<double> at = test_state(model);
  for (const LocalCoordinates coordinates : both_local_coordinates)
    for (const int order : {2, 4, 6})
      expect_way_back(model, at.q, at.v, 1e-11, 0.1, [&](Span q, Span v) {
        return simulate_symplectic(model, q, v, 0.4, 0.01, order, with(coordinates));
      });
}

/// The largest difference between the total momentum about the inertial origin and the one at t = 0 plus
/// `gained`, relative to the sum of the momenta of the bodies.
double momentum_error(const Trajectory& motion, const Vec3<>& g) {
  const Model& model = motion.model();
  Workspace<> workspace(model);
  const Momentum<Hybrid> before = centroidal_momentum(model, workspace, motion.q(0), motion.v(0));
  const Momentum<Spatial> about_origin = spatial_momentum(model, workspace, motion.q(0), motion.v(0));
  std::vector<Momentum<Spatial>> Pi(static_cast<std::size_t>(model.n_bodies()));
  double worst = 0;
  for (std::size_t k = 0; k < motion.size(); ++k) {
    body_momenta<Spatial>(model, workspace, motion.q(k), motion.v(k), Pi);
    double size = 0, mass = model.total_mass();
    for (const Momentum<Spatial>& one : Pi) size += norm(one.l) + norm(one.p);
    const Momentum<Hybrid> now = centroidal_momentum(model, workspace, motion.q(k), motion.v(k));
    const Momentum<Spatial> all = spatial_momentum(model, workspace, motion.q(k), motion.v(k));
    const Vec3<> l = axode::dot(g, g) == 0 ? all.l - about_origin.l : now.l - before.l;
    worst = std::max(worst, (norm(l) + norm(now.p - before.p - (mass * motion.t()[k]) * g)) / size);
  }
  return worst;
}

TEST(ConservingSchemes, KeepTheMomentumOfWhatFloatsToRounding) {
  for (const Vec3<>& g : {Vec3<>{}, Vec3<>{0.3, -0.2, -9.81}}) {
    const Model model = test_tree(g);
    const State<double> at = test_state(model);
    for (const int order : {2, 4}) {
      SCOPED_TRACE(order);
      EXPECT_LE(momentum_error(simulate_symplectic(model, at.q, at.v, 4, 0.004, order), g), 1e-14);
    }
    EXPECT_LE(momentum_error(simulate_momenta(model, at.q, at.v, 4, 0.004), g), 1e-14);
    EXPECT_GT(momentum_error(simulate_fixed(model, at.q, at.v, 4, 0.004), g), 1e-12);
  }
}

TEST(ConservingSchemes, CountImpulsesOnWhatFloats) {
  const Model model = test_tree({});
  const State<double> at = test_state(model);
  SimulationOptions options;
  options.loads = {{model.frame_index("door"), Wrench<Spatial>{{0.3, -1, 2}, {4, 5, -6}}}};
  const Trajectory motion = simulate_symplectic(model, at.q, at.v, 1, 0.01, 2, options);
  Workspace<> workspace(model);
  const Momentum<Spatial> before = spatial_momentum(model, workspace, motion.q(0), motion.v(0)),
                          after = spatial_momentum(model, workspace, last_q(motion), last_v(motion));
  EXPECT_LE(norm(after.l - before.l - Vec3<>{0.3, -1, 2}), 1e-11);
  EXPECT_LE(norm(after.p - before.p - Vec3<>{4, 5, -6}), 1e-11);
}

/// A chain of n links of 1 m that hangs from the ground.
Model chain(int n, JointKind kind) {
  Description description{.name = "chain"};
  for (int k = 0; k < n; ++k) {
    BodyDescription body{.name = "link " + std::to_string(k),
                         .predecessor = k == 0 ? "ground" : "link " + std::to_string(k - 1)};
    body.joint = {
        .name = "joint " + std::to_string(k), .kind = kind, .point = {0, 0, static_cast<double>(-k)}};
    if (kind == JointKind::revolute) body.joint.axis = {0, 1, 0};
    body.inertia = MassProperties{.mass = 1, .com = {0, 0, -k - 0.5}, .Theta = {1. / 12, 1. / 12, 1e-3}};
    description.bodies.push_back(std::move(body));
  }
  return ModelBuilder(description).build();
}

TEST(ConservingSchemes, KeepTheEnergyOfAChainInABand) {
  const Model model = chain(10, JointKind::revolute);
  Numbers q(10), v(10);
  q[0] = -std::acos(-1.0) / 2;
  const double start = energy_of(model, q, v), deep = start - energy_of(model, Numbers(10), v);
  const auto band = [&](double step, int order) {
    const Trajectory motion = simulate_symplectic(model, q, v, 2, step, order);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    return energy_error(motion) / deep;
  };
  EXPECT_LE(band(1e-3, 2), 1e-3);
  EXPECT_LE(band(4e-3, 4), 1e-3);
}

/// A floating tree with four kinds of joints, the first of which is 10 m from the centre of the base. If
/// the iteration of a step changes v twice by the same amount, it has not converged. When such steps were
/// accepted, the energy had an error of 1e-8 J at once.
TEST(ConservingSchemes, SolveStepsToRoundingWhereJointsAreFarOut) {
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> number(-1, 1);
  Description tree{.name = "tree", .gravity = {}};
  double x = 0;
  for (const JointKind kind :
       {JointKind::free, JointKind::universal, JointKind::helical, JointKind::spherical, JointKind::planar}) {
    const std::string name = "b" + std::to_string(tree.bodies.size());
    BodyDescription body{.name = name, .predecessor = tree.bodies.empty() ? "ground" : "b0"};
    body.joint = {.name = name + " joint", .kind = kind};
    if (kind == JointKind::helical || kind == JointKind::planar) body.joint.axis = {0.6, 0, 0.8};
    if (kind == JointKind::helical) body.joint.pitch = 0.1;
    if (kind == JointKind::universal) body.joint.axis = {1, 0, 0}, body.joint.second_axis = {0, 1, 0};
    Vec3<>& point = body.joint.point;
    if (kind != JointKind::free) {
      point.x = kind == JointKind::universal ? 10 : x;
      point.y = 0.3 * number(generator);
      point.z = 0.3 * number(generator);
      x = 0.5 * number(generator);
    }
    body.inertia = MassProperties{
        .mass = 1.3, .com = point + Vec3<>{0.1, 0.2, -0.1}, .Theta = {0.5, 0.7, 0.6, 0.02, 0.01, 0.03}};
    tree.bodies.push_back(std::move(body));
  }
  const Model model = ModelBuilder(tree).build();
  generator.seed(7);
  Numbers v(static_cast<std::size_t>(model.nv())), q_from_neutral(v.size());
  for (double& v_c : v) v_c = number(generator);
  for (double& x_c : q_from_neutral) x_c = 0.5 * number(generator);
  const Numbers q = integrate(model, neutral(model), q_from_neutral);
  const Trajectory motion = simulate_symplectic(model, q, v, 6, 3e-3, 6);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_LE(energy_error(motion), 1e-9);
}

TEST(ConservingSchemes, GoOverToNewtonsMethodOnStiffSprings) {
  const Model model = chain(2, JointKind::revolute);
  SimulationOptions options;
  options.drive = [&](double, Span q, Span, std::span<double> tau) { tau[0] = -1e8 * q[0], tau[1] = 0; };
  const Trajectory motion = simulate_symplectic(model, Numbers{0, 0.5}, Numbers{0, 0}, 0.2, 1e-3, 2, options);
  EXPECT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_LE(std::abs(last_q(motion)[0]), 1e-5);
  EXPECT_LE(motion.evaluations, 25 * motion.steps);
}

TEST(ConservingSchemes, RefuseForcesThatJump) {
  Description slider{.name = "slider"};
  BodyDescription body{.name = "block", .predecessor = "ground"};
  body.joint = {.name = "rail", .kind = JointKind::prismatic, .axis = {1, 0, 0}};
  body.joint.dof = {{.friction = 0.5}};
  body.inertia = MassProperties{.mass = 1};
  slider.bodies.push_back(body);
  const Model model = ModelBuilder(slider).build();
  const Numbers q{0}, v{1};
  SimulationOptions options{.joint_losses = true};
  EXPECT_EQ(message_of([&] { (void)simulate_symplectic(model, q, v, 1, 0.1, 2, options); }),
            "joint \"rail\" has dry friction of 0.5, a discontinuous force, which method "
            "\"midpoint\" does not support; use rk4 or euler");
  SimulationOptions events;
  events.events.push_back({.value = [](double, Span x, Span) { return x[0] - 0.5; }});
  EXPECT_THAT(message_of([&] { (void)simulate_momenta(model, q, v, 1, 0.1, runge_kutta(4), events); }),
              testing::StartsWith("events: method \"rk4_momenta\" does not support them"));
  EXPECT_EQ(message_of([&] { (void)simulate_symplectic(model, q, v, 1, 0.1, 3); }),
            "order is 3; expected 2, 4 or 6");
  EXPECT_NE(message_of([&] { (void)simulate_symplectic(model, q, v, 1, 0); }), "");
}

}  // namespace
}  // namespace axode::test
