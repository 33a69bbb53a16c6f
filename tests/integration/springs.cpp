#include <cmath>

#include "axode/batch.hpp"
#include "axode/derivatives.hpp"
#include "axode/dynamics.hpp"
#include "axode/integration.hpp"
#include "axode/model/configuration.hpp"
#include "tests/integration/motions.hpp"

/// Springs, dampers and stops: their forces are gradients of the energy, their derivatives those of the
/// forces, and motions under them conserve or lose energy accordingly.
namespace axode::test {
namespace springs {
namespace {

enum class Loss { none, some };

/// A random tree with springs, and a state of it in which some joints are beyond their limits.
struct Sprung {
  Model model;
  Numbers q, v;
  Workspace<> workspace;

  Sprung(std::uint64_t seed, Loss loss, const TreeRecipe& recipe = {.most_bodies = 8, .always_mass = true})
      : model([&] {
          Random<double> random(seed);
          const Description tree = described(random_mechanism(random, recipe), random);
          return ModelBuilder(with_springs(tree, random, loss == Loss::some)).build();
        }()),
        workspace(model) {
    Random<double> random(seed + 1);
    q = integrate(model, random_configuration(model, seed), random_numbers(random, model.nv(), 1));
    v = random_numbers(random, model.nv(), 1);
  }
  std::size_t nv() const { return v.size(); }
  double energy(Span at) { return elastic_energy(model, workspace, at); }
  Numbers forces(Span at, Span with) {
    Numbers tau(nv());
    spring_forces(model, workspace, at, with, tau);
    return tau;
  }
  Numbers moved(std::size_t k, double by) const {
    Numbers x(nv());
    x[k] = by;
    return integrate(model, q, x);
  }
};

double largest(Span x) {
  double most = 0;
  for (const double x_k : x) most = std::max(most, std::abs(x_k));
  return most;
}
double product(Span x, Span y) {
  double sum = 0;
  for (std::size_t k = 0; k < x.size(); ++k) sum += x[k] * y[k];
  return sum;
}

TEST(Springs, ForcesAreTheGradientOfTheEnergy) {
  for_seeds(200, [](std::uint64_t seed) {
    Sprung at(seed, Loss::some);
    const Numbers rest(at.nv()), tau = at.forces(at.q, rest);
    for (std::size_t k = 0; k < at.nv(); ++k) {
      constexpr double h = 1e-5;
      const double slope = (at.energy(at.moved(k, h)) - at.energy(at.moved(k, -h))) / (2 * h);
      EXPECT_NEAR(tau[k], -slope, 1e-6 * (1 + at.energy(at.q))) << velocity_names(at.model)[k];
    }
  });
}

TEST(Springs, DerivativesAreThoseOfTheForces) {
  for_seeds(200, [](std::uint64_t seed) {
    Sprung at(seed, Loss::some);
    Numbers by_q(at.nv() * at.nv()), by_v(by_q.size());
    spring_force_derivatives(at.model, at.workspace, at.q, at.v, {by_q, by_v});
    const double scale = 1 + largest(by_q) + largest(by_v);
    for (std::size_t j = 0; j < at.nv(); ++j) {
      constexpr double h = 1e-6;
      Numbers faster = at.v, slower = at.v;
      faster[j] += h, slower[j] -= h;
      const Numbers ahead = at.forces(at.moved(j, h), at.v), behind = at.forces(at.moved(j, -h), at.v),
                    more = at.forces(at.q, faster), less = at.forces(at.q, slower);
      for (std::size_t k = 0; k < at.nv(); ++k) {
        EXPECT_NEAR(by_q[k * at.nv() + j], (ahead[k] - behind[k]) / (2 * h), 1e-7 * scale);
        EXPECT_NEAR(by_v[k * at.nv() + j], (more[k] - less[k]) / (2 * h), 1e-7 * scale);
      }
    }
  });
}

TEST(Springs, ActOnLinearisationsAndEquilibria) {
  int found = 0;
  for_seeds(100, [&](std::uint64_t seed) {
    Sprung at(seed, Loss::some);
    const std::size_t n = at.nv();
    const Numbers tau(n);
    Numbers A(4 * n * n), B(2 * n * n);
    const auto acceleration = [&](Span q, Span v) {
      Numbers a(n);
      const Numbers forces = at.forces(q, v);
      EXPECT_TRUE(forward_dynamics(at.model, at.workspace, q, v, forces, a).ok());
      return a;
    };
    if (!linearize(at.model, at.workspace, at.q, at.v, tau, {A, B}).ok()) return;
    const double scale = 1 + largest(A);
    for (std::size_t j = 0; j < n; ++j) {
      constexpr double h = 1e-5;
      Numbers faster = at.v, slower = at.v;
      faster[j] += h, slower[j] -= h;
      const Numbers ahead = acceleration(at.moved(j, h), at.v), behind = acceleration(at.moved(j, -h), at.v),
                    more = acceleration(at.q, faster), less = acceleration(at.q, slower);
      for (std::size_t i = 0; i < n; ++i) {
        EXPECT_NEAR(A[(n + i) * 2 * n + j], (ahead[i] - behind[i]) / (2 * h), 1e-6 * scale);
        EXPECT_NEAR(A[(n + i) * 2 * n + n + j], (more[i] - less[i]) / (2 * h), 1e-6 * scale);
      }
    }
    const EquilibriumResult rest = equilibrium(at.model, at.q);
    if (rest.status != EquilibriumStatus::solved) return;
    ++found;
    EXPECT_LE(largest(acceleration(rest.q, tau)), 1e-6);
  });
  EXPECT_GT(found, 0);
}

TEST(Springs, DampersAndStopsTakeEnergy) {
  int trees = 0, taken = 0;
  for_seeds(100, [&](std::uint64_t seed) {
    ++trees;
    Sprung at(seed, Loss::some);
    const Numbers rest(at.nv()), still = at.forces(at.q, rest), moving = at.forces(at.q, at.v);
    const double power = product(moving, at.v) - product(still, at.v);
    EXPECT_LE(power, 1e-12 * (1 + largest(still)));
    taken += power < -1e-3;
  });
  EXPECT_GT(2 * taken, trees);
}

TEST(Springs, SingleAndDoublePrecisionAgree) {
  for_seeds(50, [](std::uint64_t seed) {
    Sprung at(seed, Loss::some);
    Workspace<float> workspace(at.model);
    std::vector<float> q(at.q.begin(), at.q.end()), v(at.v.begin(), at.v.end()), tau(at.nv());
    spring_forces<float>(at.model, workspace, q, v, tau);
    const Numbers exact = at.forces(at.q, at.v);
    for (std::size_t k = 0; k < tau.size(); ++k) EXPECT_NEAR(tau[k], exact[k], 2e-4 * (1 + largest(exact)));
    EXPECT_NEAR(elastic_energy<float>(at.model, workspace, q), at.energy(at.q), 1e-4 * (1 + at.energy(at.q)));
  });
}

/// Whether a joint with several velocities, a torsion spring or a bushing is near half a turn, where the
/// energy may jump.
bool nears_half_a_turn(const Model& model, const Trajectory& motion) {
  const Numbers rest = neutral(model);
  for (std::size_t k = 0; k < motion.size(); ++k) {
    const Numbers x = difference(model, rest, motion.q(k));
    for (const Joint& joint : model.joints()) {
      const double* w = &x[joint.iv];
      if (joint.nv > 1 &&
          (joint.kind == Subgroup::planar ? std::abs(*w) : std::hypot(w[0], w[1], w[2])) > 2.8)
        return true;
    }
    const std::vector<SE3<>> C = poses_of(model, Numbers(motion.q(k).begin(), motion.q(k).end()));
    const auto turn = [&](const std::array<Spring::End, 2>& ends, const SE3<>& rest) {
      const auto pose = [&](const Spring::End& end) {
        return C[static_cast<std::size_t>(end.frame)] * end.pose;
      };
      return norm(log_SO3((inverse(rest) * inverse(pose(ends[0])) * pose(ends[1])).R));
    };
    for (const Spring& spring : model.springs().elements) {
      if (const auto* torsion = std::get_if<Spring::Torsion>(&spring.geometry))
        if (turn(torsion->ends, {}) > 2.8) return true;
      if (const auto* bushing = std::get_if<Spring::Bushing>(&spring.geometry))
        if (turn(bushing->ends, bushing->rest) > 2.8) return true;
    }
  }
  return false;
}

TEST(Springs, MotionsUnderThemKeepTheirEnergy) {
  int kept = 0;
  for_seeds(40, [&](std::uint64_t seed) {
    Sprung at(seed, Loss::none, {.most_bodies = 6, .always_mass = true});
    const auto energy = [&](Span q, Span v) {
      return kinetic_energy(at.model, at.workspace, q, v) + potential_energy(at.model, at.workspace, q) +
             at.energy(q);
    };
    const Trajectory motion = simulate(at.model, at.q, at.v, 0.3, {.relative = 1e-10, .absolute = 1e-12});
    if (!motion.complete || nears_half_a_turn(at.model, motion)) return;
    const std::size_t last = motion.size() - 1;
    const double before = energy(motion.q(0), motion.v(0)), after = energy(motion.q(last), motion.v(last));
    const double scale = std::max({1.0, std::abs(before), at.energy(at.q),
                                   kinetic_energy(at.model, at.workspace, motion.q(last), motion.v(last))});
    EXPECT_NEAR(before, after, 1e-6 * scale);
    ++kept;
  });
  EXPECT_GT(kept, 15);
}

TEST(Springs, ImplicitAndExplicitMethodsAndRolloutsSeeTheSameOnes) {
  int compared = 0;
  for_seeds(20, [&](std::uint64_t seed) {
    Sprung at(seed, Loss::some, {.most_bodies = 5, .always_mass = true});
    const double until = 0.02;
    const Trajectory exact = simulate(at.model, at.q, at.v, until, {.relative = 1e-11, .absolute = 1e-12});
    if (!exact.complete || largest(exact.a()) > 1e3) return;
    const auto error = [&](Span q) { return largest(difference(at.model, exact.q(exact.size() - 1), q)); };
    const Trajectory stiff = simulate_stiff(at.model, at.q, at.v, until, until / 40);
    ASSERT_TRUE(stiff.complete) << stiff.stop_reason;
    EXPECT_LE(error(stiff.q(40)), 1e-4 * (1 + largest(exact.a()) * until));
    const Trajectory fixed = simulate_fixed(at.model, at.q, at.v, until, until / 40);
    Numbers q(41 * at.q.size()), v(41 * at.nv());
    EXPECT_TRUE(batch::rollout<double>(at.model, at.q, at.v, Numbers(40 * at.nv()), until / 40, q, v).ok());
    EXPECT_LE(largest(difference(at.model, fixed.q(40), Span(q).last(at.q.size()))), 1e-13);
    ++compared;
  });
  EXPECT_GT(compared, 5);
}

/// Calls f(frame, point, pose) for the ends of a spring.
template <class F> void for_places(SpringDescription& spring, const F& f) {
  SE3<> none;
  Vec3<> nowhere;
  for (SpringDescription::Point& it : spring.path) f(it.on, it.point, none);
  for (std::size_t k = 0; k < 2 && traits(spring.kind).has("between"); ++k)
    f(spring.between[k], spring.kind == SpringKind::line ? spring.points[k] : nowhere, spring.frames[k]);
}

TEST(Springs, EndsMeanTheSameHoweverTheyAreGiven) {
  for_seeds(50, [](std::uint64_t seed) {
    Sprung at(seed, Loss::some);
    Description drawn = at.model.description();
    for (SpringDescription& spring : drawn.springs) {
      if (spring.in == GivenIn::body_frame)
        for_places(spring, [&](const std::string& on, Vec3<>& point, SE3<>& pose) {
          const Frame& frame = at.model.frame(at.model.frame_index(on));
          const SE3<> A = at.model.body(frame.body).A * frame.pose;
          point = A * point;
          pose = A * pose;
        });
      spring.in = GivenIn::construction_frame;
      if (spring.kind == SpringKind::line)
        std::swap(spring.between[0], spring.between[1]), std::swap(spring.points[0], spring.points[1]);
      std::ranges::reverse(spring.path);
    }
    const Model other = ModelBuilder(drawn).build();
    Numbers tau(at.nv());
    spring_forces(other, at.workspace, at.q, at.v, tau);
    const Numbers expected = at.forces(at.q, at.v);
    for (std::size_t k = 0; k < tau.size(); ++k)
      EXPECT_NEAR(tau[k], expected[k], 1e-11 * (1 + largest(expected)));
  });
}

TEST(Springs, ModelsMadeFromOthersKeepThem) {
  for_seeds(50, [](std::uint64_t seed) {
    Sprung at(seed, Loss::some), hand(seed + 1000, Loss::some, {.most_bodies = 4});
    const Model whole = append(at.model, at.model.frame(at.model.n_frames() - 1).name, hand.model, "its ");
    Workspace<> workspace(whole);
    Numbers q(static_cast<std::size_t>(whole.nq()));
    const auto fill = [&](const Sprung& from, const std::string& prefix) {
      for (const Joint& joint : from.model.joints()) {
        const Joint& to = whole.joint(whole.joint_index(prefix + joint.name));
        for (int k = 0; k < joint.nq; ++k) q[to.iq + k] = from.q[joint.iq + k];
      }
    };
    fill(at, ""), fill(hand, "its ");
    const double both = at.energy(at.q) + hand.energy(hand.q);
    EXPECT_NEAR(elastic_energy(whole, workspace, q), both, 1e-10 * (1 + both));

    std::vector<std::string_view> locked;
    double held = 0;
    Description alone = at.model.description();
    // Springs on locked joints are left out, so that those on joints are not compared.
    for (BodyDescription& body : alone.bodies) body.joint.dof.clear();
    std::erase_if(alone.springs,
                  [](const SpringDescription& spring) { return spring.kind == SpringKind::joints; });
    const Model lines = ModelBuilder(alone).build();
    for (std::size_t i = 0; i < lines.joints().size(); i += 2)
      if (!lines.joints()[i].leader) locked.push_back(lines.joints()[i].name);
    const Model rest = reduced(lines, locked, at.q);
    Numbers q_rest(static_cast<std::size_t>(rest.nq()));
    for (const Joint& joint : rest.joints())
      for (int k = 0; k < joint.nq; ++k)
        q_rest[joint.iq + k] = at.q[lines.joint(lines.joint_index(joint.name)).iq + k];
    Workspace<> small(rest);
    held = elastic_energy(lines, at.workspace, Span(at.q));
    EXPECT_NEAR(elastic_energy(rest, small, Span(q_rest)), held, 1e-10 * (1 + held));
  });
}

/// A mechanism with a body on a slide, and a second one on the first.
Description slides() {
  Description model{.name = "slides"};
  for (int k = 0; k < 2; ++k) {
    BodyDescription body{.name = k == 0 ? "first" : "second", .predecessor = k == 0 ? "ground" : "first"};
    body.joint = {.name = body.name + " slide", .kind = JointKind::prismatic, .axis = {0, 0, 1}};
    body.inertia = MassProperties{.mass = 2, .com = {}, .Theta = {1, 1, 1}};
    model.bodies.push_back(std::move(body));
  }
  return model;
}

TEST(Springs, OfNoLengthHaveAForceOnlyWhereItIsZero) {
  Description model = slides();
  for (const double rest : {0.0, 0.5}) {
    model.springs = {{.between = {"first", "second"}, .stiffness = 10, .rest = rest, .damping = 3}};
    const Model built = ModelBuilder(model).build();
    Workspace<> workspace(built);
    Numbers tau(2), by_q(4), by_v(4);
    for (const double length : {0.0, 1e-200, -1e-200}) {
      const Numbers q{1, length}, v{0.3, 0.7};
      spring_forces(built, workspace, q, v, tau);
      spring_force_derivatives(built, workspace, q, v, {by_q, by_v});
      EXPECT_EQ(tau[0], 0);
      EXPECT_EQ(tau[1], 0);
      EXPECT_EQ(by_q[3], rest == 0 ? -10 : 0);
      EXPECT_EQ(by_v[3], 0);
      EXPECT_DOUBLE_EQ(elastic_energy(built, workspace, Span(q)), 5 * rest * rest);
    }
    spring_forces(built, workspace, Numbers{1, -2}, Numbers{0.3, 0.7}, tau);
    EXPECT_DOUBLE_EQ(tau[1], 10 * (2 - rest) - 3 * 0.7);
  }
}

TEST(Springs, FarFromTheInertialOriginNothingIsLost) {
  Description model = slides();
  model.springs = {{.between = {"first", "second"},
                    .points = {{{0.5, 0.2, 0}, {0, 0, 0.1}}},
                    .stiffness = 10,
                    .rest = 0.1}};
  const Model built = ModelBuilder(model).build();
  Workspace<> workspace(built);
  Numbers here(2), there(2);
  spring_forces(built, workspace, Numbers{0, 0.3}, Numbers{0, 1}, here);
  spring_forces(built, workspace, Numbers{1e12, 0.3}, Numbers{0, 1}, there);
  EXPECT_EQ(here, there);
  EXPECT_GT(std::abs(here[1]), 1);
}

TEST(Springs, StopsHoldAndNeverPull) {
  Description model = slides();
  model.bodies.pop_back();
  Dof& dof = model.bodies[0].joint.dof.emplace_back();
  dof.lower = -0.2, dof.upper = 0.3, dof.stop_stiffness = 1e5, dof.stop_damping = 0.8;
  const Model built = ModelBuilder(model).build();
  Workspace<> workspace(built);
  const auto force = [&](double q, double v) {
    Numbers tau(1);
    spring_forces(built, workspace, Numbers{q}, Numbers{v}, tau);
    return tau[0];
  };
  for (const double v : {-3.0, -1.0, 0.0, 2.0}) {
    EXPECT_EQ(force(0.1, v), 0);
    for (double depth = 1e-12; depth < 0.1; depth *= 10) {
      EXPECT_GE(force(-0.2 - depth, v), 0);
      EXPECT_LE(force(0.3 + depth, v), 0);
      EXPECT_LE(std::abs(force(-0.2 - depth, v)), 1e5 * depth * 4) << "continuous";
    }
  }
  EXPECT_DOUBLE_EQ(force(0.4, 0), -1e4);
  EXPECT_DOUBLE_EQ(force(0.4, 1), -1.8e4);
  EXPECT_EQ(force(0.4, -2), 0) << "a stop does not pull";

  // The body falls onto the lower stop and comes to rest there.
  const double weight = 2 * 9.81;
  for (const Trajectory& motion : {simulate(built, Numbers{0.1}, Numbers{0}, 20),
                                   simulate_stiff(built, Numbers{0.1}, Numbers{0}, 20, 1e-3)}) {
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    const std::size_t last = motion.size() - 1;
    double deepest = 0, highest = -1;
    for (std::size_t k = 0; k < motion.size(); ++k) {
      deepest = std::min(deepest, motion.q(k)[0]);
      if (motion.t()[k] > 19) highest = std::max(highest, motion.q(k)[0]);
    }
    EXPECT_GT(deepest, -0.2 - 0.02);
    EXPECT_LT(highest, 0.0);  // it started at 0.1
    EXPECT_GT(motion.q(last)[0], -0.2 - 4 * weight / 1e5);
  }
}

TEST(Springs, StiffOnesTakeAFewIterationsOfNewtonsMethod) {
  // A spring of 1e8 N m/rad at the first of two hinges balances the weight at the start.
  Description arm = two_links();
  const double stiffness = 1e8;
  const Model plain = ModelBuilder(arm).build();
  Workspace<> workspace(plain);
  Numbers weight(2);
  gravity_torques(plain, workspace, Numbers{0, 0}, weight);
  arm.bodies[0].joint.dof = {{.stiffness = stiffness, .rest = weight[0] / stiffness}};
  const Model model = ModelBuilder(arm).build();
  const auto elbow = [&](double step) {
    const Trajectory motion = simulate_stiff(model, Numbers{0, 0}, Numbers{0, 0}, 0.5, step);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    const std::size_t last = motion.size() - 1;
    EXPECT_LE(std::abs(motion.q(last)[0]), 1e-5);
    EXPECT_LE(motion.evaluations, 6 * motion.steps);
    return motion.q(last)[1];
  };
  const double coarse = elbow(2e-3), middle = elbow(1e-3), fine = elbow(5e-4);
  EXPECT_NEAR(std::log2((coarse - middle) / (middle - fine)), 2, 0.3);
}

}  // namespace
}  // namespace springs
}  // namespace axode::test
