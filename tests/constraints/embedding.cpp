#include <gmock/gmock.h>

#include <Eigen/QR>

#include "axode/constraints.hpp"
#include "axode/constraints/embedding/platform_placement.hpp"
#include "axode/constraints/embedding/task_rates.hpp"
#include "axode/constraints/embedding/task_singularities.hpp"
#include "axode/constraints/higher_order/constrained_rates.hpp"
#include "axode/dynamics.hpp"
#include "axode/io.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/laws/law.hpp"

/// Parallel manipulators limb by limb, compared with the functions for any mechanism with loops.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;
using Eigen::MatrixXd, Eigen::VectorXd;

Model robot(const char* file) {
  return load(std::filesystem::path(AXODE_SOURCE_DIR "/examples/robots") / file);
}

enum class Leg {
  from_ground,    ///< universal, prismatic with a drive, ball at the platform
  slider,         ///< prismatic with a drive on the ground, universal, ball at the platform
  from_platform,  ///< universal on the platform, prismatic with a drive, ball on the ground
  spinning,       ///< ball, prismatic with a drive, ball: its spin is a freedom of its own
};

void add_leg(Description& d, Leg leg, const Vec3<>& foot, const Vec3<>& top, Random<double>& random) {
  const std::string name = std::to_string(d.bodies.size());
  const Vec3<> middle = 0.5 * (foot + top), across = cross(top - foot, random.direction());
  const auto passive = [](BodyDescription body) {
    body.joint.passive = true;
    return body;
  };
  const auto cardan = [&](const std::string& on, const Vec3<>& at, const Vec3<>& to) {
    BodyDescription body = passive(bar("a" + name, on, JointKind::universal, across, at, to));
    body.joint.second_axis = cross(top - foot, across);
    return body;
  };
  LoopDescription ball{.name = "ball " + name, .kind = LoopKind::spherical, .point = top};
  switch (leg) {
    case Leg::from_ground:
      d.bodies.push_back(cardan("ground", foot, middle));
      d.bodies.push_back(bar("b" + name, "a" + name, JointKind::prismatic, top - foot, top, middle));
      ball.between = {"b" + name, "platform"};
      break;
    case Leg::slider:
      d.bodies.push_back(
          bar("b" + name, "ground", JointKind::prismatic, {0, 0, 1}, foot, foot + Vec3<>{0, 0, .2}));
      d.bodies.push_back(cardan("b" + name, foot, top));
      ball.between = {"a" + name, "platform"};
      break;
    case Leg::from_platform:
      d.bodies.push_back(cardan("platform", top, middle));
      d.bodies.push_back(bar("b" + name, "a" + name, JointKind::prismatic, top - foot, foot, middle));
      ball.between = {"b" + name, "ground"};
      ball.point = foot;
      break;
    case Leg::spinning:
      d.bodies.push_back(passive(bar("a" + name, "ground", JointKind::spherical, {0, 0, 1}, foot, middle)));
      d.bodies.push_back(bar("b" + name, "a" + name, JointKind::prismatic, top - foot, top, middle));
      ball.between = {"b" + name, "platform"};
  }
  d.loops.push_back(ball);
}

/// A platform on random legs.
Description random_platform(Random<double>& random, int legs, bool spinning) {
  Description d{.name = "platform", .gravity = random.vector(), .bodies = {}, .frames = {}};
  d.bodies.push_back({.name = "platform",
                      .joint = {.kind = JointKind::free, .passive = true},
                      .inertia = MassProperties{.mass = 5,
                                                .com = {0.1, 0, 1.1},
                                                .Theta = {.5, .6, .9, 0, .05, 0},
                                                .in = GivenIn::construction_frame}});
  for (int k = 0; k < legs; ++k) {
    const double angle = 2 * k;
    const auto on_circle = [&](double r, double z) {
      return Vec3<>{r * std::cos(angle), r * std::sin(angle), z} + 0.25 * random.vector();
    };
    add_leg(d, static_cast<Leg>(static_cast<int>(random.number(0, spinning ? 3.99 : 2.99))), on_circle(1, 0),
            on_circle(0.5, 1), random);
  }
  return d;
}

/// A random platform in a random pose, with a random motion.
struct Moving {
  Moving(std::uint64_t seed, int legs, bool spinning = false)
      : random(seed),
        model(ModelBuilder(random_platform(random, legs, spinning)).build()),
        loops(model),
        space(model, neutral(model)),
        q(neutral(model)),
        V(random_numbers(random, space.freedom())),
        dV(random_numbers(random, space.freedom(), 5)),
        v(static_cast<std::size_t>(model.nv())),
        a(v.size()) {
    const Screw<> X{0.15 * random.vector(), 0.15 * random.vector()};
    closed = place_platform(space, exp(X), q);
    if (!closed.reached) return;
    resolved = space.velocities(q, V, v).ok() && space.accelerations(q, v, dV, a).ok();
  }
  Random<double> random;
  Model model;
  LoopWorkspace<double> loops;
  TaskSpace space;
  Numbers q, V, dV, v, a;
  PlatformPlacement closed;
  bool resolved = false;
};

TEST(ConstraintEmbedding, FindsThePlatformAndItsLimbs) {
  const Model gough_platform = robot("gough.toml"), delta = robot("delta.toml"),
              ring = robot("four_bar.toml");
  const TaskSpace six(gough_platform, neutral(gough_platform)), three(delta, neutral(delta));
  EXPECT_EQ(gough_platform.body(six.platform()).name, "platform");
  EXPECT_EQ(six.limbs(), 6);
  EXPECT_EQ(six.names().front(), "platform.omega_x");
  EXPECT_EQ(delta.body(three.platform()).name, "plate");
  EXPECT_EQ(three.limbs(), 3);
  EXPECT_EQ(three.names(), (std::vector<std::string>{"plate.v_x", "plate.v_y", "plate.v_z"}));
  EXPECT_EQ(TaskSpace(ring, neutral(ring)).freedom(), 1) << "a mechanism without a platform";
}

TEST(ConstraintEmbedding, KeepsLoopsClosed) {
  int seen = 0;
  Comparison residual("r", 1e-9), rates("A v", 1e-9), accelerations("A a + γ", 1e-9), task("V", 1e-12);
  for_seeds(40, [&](std::uint64_t seed) {
    Moving at(seed, 6, true);
    if (!at.resolved) return;
    ++seen;
    const auto m = static_cast<std::size_t>(at.model.loops().rows);
    Numbers r(static_cast<std::size_t>(at.model.loops().residuals)), A(m * at.v.size()), gamma(m);
    loop_residual(at.model, at.loops, at.q, r);
    residual.expect_equal(r, Numbers(r.size()), 1);
    loop_jacobian(at.model, at.loops, at.q, A);
    loop_bias(at.model, at.loops, at.q, at.v, gamma);
    const MatrixXd rows = matrix(static_cast<int>(m), A);
    rates.expect_equal(numbers(rows * vector(at.v)), Numbers(m), 1 + vector(at.v).norm());
    accelerations.expect_equal(numbers(rows * vector(at.a) + vector(gamma)), Numbers(m),
                               1 + vector(at.a).norm() + vector(gamma).norm());
    task.expect_equal(Numbers(at.v.begin(), at.v.begin() + 6), Numbers(at.V.begin(), at.V.begin() + 6));
  });
  EXPECT_GT(seen, 20);
}

TEST(ConstraintEmbedding, MovesAsTheMechanismWithLoops) {
  int seen = 0;
  Comparison dV("V'", 1e-8), a("a", 1e-8), balance("M V' + h", 1e-9);
  for_seeds(40, [&](std::uint64_t seed) {
    Moving at(seed, 6, true);
    if (!at.resolved) return;
    ++seen;
    const Numbers tau = random_numbers(at.random, at.model.nv(), 10);
    Numbers expected(at.v.size()), found(at.v.size()), rates(at.dV.size());
    ASSERT_TRUE(forward_dynamics(at.model, at.loops, at.q, at.v, tau, expected).ok());
    ASSERT_TRUE(at.space.forward_dynamics(at.q, at.v, tau, rates, found).ok());
    const double size = 1 + vector(expected).norm();
    a.expect_equal(found, expected, size);
    const TaskEquations equations = at.space.equations(at.q, at.v);
    dV.expect_equal(numbers(equations.F * vector(rates) + equations.c), expected, size);
    balance.expect_equal(numbers(equations.M * vector(rates) + equations.h),
                         numbers(equations.F.transpose() * vector(tau)), 1 + equations.M.norm() * size);
  });
  EXPECT_GT(seen, 20);
}

/// The least drive forces from a basis of the velocities that the loops allow (D7.10).
Numbers least_forces(const Moving& at) {
  Workspace<double> tree(at.model, cut_tree);
  Numbers f(at.v.size());
  inverse_dynamics(at.model, tree, at.q, at.v, at.a, f);
  const MatrixXd N = loop_mobility(at.model, at.q).kernel;
  const std::vector<char>& driven = at.model.loops().driven;
  MatrixXd B = MatrixXd::Zero(N.rows(), N.cols());
  B = N;
  for (Eigen::Index c = 0; c < B.rows(); ++c)
    if (driven[static_cast<std::size_t>(c)] == 0) B.row(c).setZero();
  const MatrixXd NB = B.transpose();
  return numbers(NB.completeOrthogonalDecomposition().solve(N.transpose() * vector(f)));
}

TEST(ConstraintEmbedding, FindsTheLeastDriveForces) {
  int seen = 0;
  Comparison in_task_space("task space", 1e-7), with_loops("loops", 1e-7), back("V'", 1e-7);
  for (const int legs : {6, 7, 9})
    for_seeds(12, [&](std::uint64_t seed) {
      Moving at(seed, legs);
      if (!at.resolved || !singularities(at.space, at.q, 0.02).empty()) return;
      ++seen;
      const Numbers expected = least_forces(at);
      const double size = vector(expected).norm();
      Numbers tau(at.v.size()), again(at.v.size()), rates(at.dV.size());
      ASSERT_TRUE(at.space.inverse_dynamics(at.q, at.v, at.dV, tau).ok());
      in_task_space.expect_equal(tau, expected, size);
      EXPECT_LT(inverse_dynamics(at.model, at.loops, at.q, at.v, at.a, again), 1e-9);
      with_loops.expect_equal(again, expected, size);
      ASSERT_TRUE(at.space.forward_dynamics(at.q, at.v, tau, rates).ok());
      back.expect_equal(rates, at.dV, 1 + vector(at.dV).norm());
    });
  EXPECT_GT(seen, 15);
}

/// Multipliers of inverse dynamics balance the forces of the tree, also if they are found limb by limb.
TEST(ConstraintEmbedding, FindsMultipliers) {
  for_seeds(10, [&](std::uint64_t seed) {
    Moving at(seed, 6);
    if (!at.resolved || !singularities(at.space, at.q, 0.02).empty()) return;
    const auto m = static_cast<std::size_t>(at.model.loops().rows);
    Numbers tau(at.v.size()), f(tau), lambda(m), A(m * tau.size());
    Workspace<double> tree(at.model, cut_tree);
    inverse_dynamics(at.model, tree, at.q, at.v, at.a, f);
    EXPECT_LT(inverse_dynamics(at.model, at.loops, at.q, at.v, at.a, tau, lambda), 1e-9);
    loop_jacobian(at.model, at.loops, at.q, A);
    const VectorXd rest =
        vector(f) - vector(tau) - matrix(static_cast<int>(m), A).transpose() * vector(lambda);
    EXPECT_LT(rest.norm(), 1e-9 * (1 + vector(f).norm() + vector(lambda).norm()));
  });
}

TEST(ConstraintEmbedding, HasTheTimeDerivativesOfTheForces) {
  int seen = 0;
  Comparison forces("forces", 1e-7);
  for_seeds(20, [&](std::uint64_t seed) {
    Moving at(seed, 6);
    if (!at.resolved || !singularities(at.space, at.q, 0.05).empty()) return;
    ++seen;
    const std::size_t nv = at.v.size();
    const Numbers rates = random_numbers(at.random, 4 * 6);
    Numbers tau(3 * nv), expected(3 * nv), motion(4 * nv);
    ASSERT_TRUE(inverse_dynamics_rates(at.space, at.q, rates, tau, motion).ok());
    EXPECT_LT(inverse_dynamics_rates(at.model, at.loops, at.q, motion, expected), 1e-7);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto row = [&](const Numbers& of) {
        const auto first = of.begin() + static_cast<std::ptrdiff_t>(k * nv);
        return Numbers(first, first + static_cast<std::ptrdiff_t>(nv));
      };
      forces.expect_equal(row(tau), row(expected), vector(row(expected)).norm());
    }
  });
  EXPECT_GT(seen, 2);
}

TEST(ConstraintEmbedding, ResolvesLimbsOfLessMobility) {
  const Model model = robot("delta.toml");
  TaskSpace space(model, neutral(model));
  LoopWorkspace<double> loops(model);
  Numbers q = neutral(model);
  const Vec3<> there{0.08, -0.05, 0.06};
  ASSERT_TRUE(place_platform(space, {{}, there}, q).reached);
  Numbers unreachable = q;
  const PlatformPlacement turned = place_platform(space, exp(Screw<>{{0.1, 0, 0}, {}}), unreachable);
  EXPECT_FALSE(turned.reached) << "it does not turn";
  EXPECT_THAT(to_string(space, turned),
              testing::MatchesRegex("the limb with loops? .* by .* \\(rad and m\\); .*"));
  EXPECT_FALSE(place_platform(space, {{}, {0, 0, -5}}, unreachable).reached) << "too far";
  Numbers v(static_cast<std::size_t>(model.nv())), a(v), expected(v), tau(v), dV(3);
  const Numbers V{0.3, -0.2, 0.5}, wanted{1, 2, -3};
  ASSERT_TRUE(space.velocities(q, V, v).ok());
  ASSERT_TRUE(space.inverse_dynamics(q, v, wanted, tau).ok());
  ASSERT_TRUE(space.forward_dynamics(q, v, tau, dV, a).ok());
  ASSERT_TRUE(forward_dynamics(model, loops, q, v, tau, expected).ok());
  EXPECT_LT((vector(dV) - vector(wanted)).norm(), 1e-11);
  EXPECT_LT((vector(a) - vector(expected)).norm(), 1e-9 * vector(expected).norm());
}

// ------------------------------------------------------------------------------------ singularities

TEST(PlatformSingularities, AreAbsentFromARegularPosture) {
  for (const char* const file : {"gough.toml", "delta.toml"}) {
    const Model model = robot(file);
    TaskSpace space(model, neutral(model));
    EXPECT_TRUE(singularities(space, neutral(model)).empty()) << file;
  }
}

/// Fichter's singularity: the platform is turned by a quarter turn about its axis.
TEST(PlatformSingularities, OfTheDrivesHaveTheScrewOfTheFreeMotion) {
  const Model model = robot("gough.toml");
  TaskSpace space(model, neutral(model));
  Numbers q = neutral(model);
  for (const double angle : {0.3, 0.6, 0.9, 1.2, 0.5 * 3.14159265358979323846})
    ASSERT_TRUE(place_platform(space, exp(Screw<>{{0, 0, angle}, {}}), q).reached);
  const std::vector<TaskSingularity> found = singularities(space, q);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found.front().type, TaskSingularity::Type::drives);
  EXPECT_LT(found.front().distance, 1e-9);
  EXPECT_EQ(found.front().joints.size(), 6u) << "all drives hold each other";
  const Twist<Spatial>& V = found.front().twist;
  EXPECT_NEAR(std::abs(V.w.z), norm(V.w), 1e-6) << "along z, as far as the drawing is symmetric";
  EXPECT_LT(std::hypot(V.v.x, V.v.y), 2e-3) << "through the centre";
  EXPECT_NEAR(V.v.z / V.w.z, -0.306, 1e-3) << "pitch";
  EXPECT_THAT(found.front().sentence, testing::StartsWith("type 2: the platform can move while all drives"));
  Numbers tau(static_cast<std::size_t>(model.nv()));
  const TaskVerdict verdict = space.inverse_dynamics(q, Numbers(24), Numbers(6, 1.0), tau);
  EXPECT_THAT(to_string(space, verdict),
              testing::StartsWith("type 2: the platform can move while all drives"));
  // The platform moves along this screw while the drives rest.
  const SE3<> C = exp(Screw<>{{0, 0, 0.5 * 3.14159265358979323846}, {}});
  const Screw<> body = Ad_inv(C, Screw<>{V.w, V.v});
  Numbers v(static_cast<std::size_t>(model.nv()));
  ASSERT_TRUE(
      space.velocities(q, Numbers{body.w.x, body.w.y, body.w.z, body.v.x, body.v.y, body.v.z}, v).ok());
  for (std::size_t c = 0; c < v.size(); ++c)
    if (model.loops().driven[c] != 0) {
      EXPECT_NEAR(v[c], 0, 1e-9);
    }
}

/// A leg along the first axis of its foot turns about itself while the platform rests.
TEST(PlatformSingularities, OfALimbNameItsJoints) {
  Description d = gough();
  d.bodies.front().joint.passive = true;
  const Model model = ModelBuilder(d).build();
  TaskSpace space(model, neutral(model));
  const Vec3<> foot = model.description().bodies[1].joint.point,
               axis = model.description().bodies[1].joint.axis;
  const Vec3<> top = model.description().loops[0].point;
  Numbers q = neutral(model);
  const Vec3<> target = foot + (norm(top - foot) / norm(axis)) * axis;
  for (double part = 0.1; part < 0.9999; part += 0.1)
    ASSERT_TRUE(place_platform(space, {{}, part * (target - top)}, q).reached);
  ASSERT_TRUE(place_platform(space, {{}, (1 - 1e-5) * (target - top)}, q).reached);
  const std::vector<TaskSingularity> found = singularities(space, q);
  ASSERT_GE(found.size(), 1u);
  EXPECT_EQ(found.front().type, TaskSingularity::Type::limb);
  EXPECT_EQ(found.front().limb, 0);
  EXPECT_LT(found.front().distance, 1e-3);
  EXPECT_THAT(found.front().sentence, testing::StartsWith("type 1: joints of the limb with loop"));
  EXPECT_FALSE(found.front().joints.empty());
}

TEST(ConstraintEmbedding, RefusesWhatItCannotDivide) {
  const Model ring = robot("four_bar.toml");
  EXPECT_THAT(
      [&] { TaskSpace(ring, neutral(ring), "coupler"); },
      testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("\"coupler\" hangs on another body")));
  const Model open = ModelBuilder("open").build();
  EXPECT_THAT([&] { TaskSpace(open, {}); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("has no loops")));
  const Model gough_platform = robot("gough.toml");
  TaskSpace space(gough_platform, neutral(gough_platform));
  Numbers tau(24);
  EXPECT_THAT([&] { static_cast<void>(space.velocities(neutral(gough_platform), Numbers(5), tau)); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("freedom()")));
  const Numbers bad{std::nan(""), 0, 0, 0, 0, 0};
  EXPECT_EQ(space.velocities(neutral(gough_platform), bad, tau).kind, TaskVerdict::Kind::not_finite);
}

}  // namespace
}  // namespace axode::test
