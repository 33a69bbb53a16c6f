#include <gtest/gtest.h>

#include "tests/contact/scene.hpp"
#include "tests/contact/step_differences.hpp"
#include "tests/support/random_loops.hpp"
#include "tests/support/refused_arguments.hpp"

/// Derivatives of steps with contact against differences of fourth order, on every branch of the laws.
namespace axode::test {
namespace {

struct OfOneBody {
  const char* name;
  ShapeKind kind;
  Vec3<> size;
  double friction, restitution, gap;
  Vec3<> turn, w, v;
};
void PrintTo(const OfOneBody& it, std::ostream* out) { *out << it.name; }

class OneBody : public testing::TestWithParam<OfOneBody> {};
TEST_P(OneBody, HasTheDerivativeOfItsBranch) {
  const OfOneBody& it = GetParam();
  const Model model =
      Bodies(it.friction).add(shape_of(it.kind, it.size, it.friction, it.restitution)).build();
  const std::vector<double> q = lowered(model, posed(it.turn, {0.1, 0.2, 1}), it.gap);
  const std::vector<double> v = moving(q, it.w, it.v);
  expect_derivatives(model, {q, v, push});
  expect_derivatives(model, {q, v, std::vector<double>(6)}, 1e-7, 3e-5, Matrix::Identity(18, 12));
}
constexpr Vec3<> some_turn{0.3, -0.5, 0.2}, spin{1, -0.7, 0.4};
constexpr Vec3<> ball{0.1, 0, 0}, egg{0.1, 0.15, 0.2}, rod{0.1, 0.3, 0}, oblong{0.2, 0.3, 0.25};
/// A body that leans and turns close to the floor.
OfOneBody leaning(const char* name, ShapeKind kind, const Vec3<>& size, double friction, double restitution,
                  const Vec3<>& v) {
  return {name, kind, size, friction, restitution, 1e-3, some_turn, spin, v};
}
/// A box with four corners on the floor.
OfOneBody flat(const char* name, double friction, const Vec3<>& v) {
  return {name, ShapeKind::box, oblong, friction, 0, 1e-3, {0, 0.2, 0}, {}, v};
}
INSTANTIATE_TEST_SUITE_P(
    Branches, OneBody,
    testing::Values(
        OfOneBody{"sphere_flies", ShapeKind::sphere, ball, 0.4, 0, 0.3, some_turn, spin, {1, 0, -1}},
        leaning("sphere_slides", ShapeKind::sphere, ball, 0.2, 0, {2, 1, -0.5}),
        leaning("sphere_sticks", ShapeKind::sphere, ball, 5, 0, {0.05, 0, -0.5}),
        leaning("sphere_bounces", ShapeKind::sphere, ball, 0.2, 0.6, {1, 0, -1.5}),
        leaning("ellipsoid_slides", ShapeKind::ellipsoid, egg, 0.3, 0, {2, 1, -0.5}),
        leaning("ellipsoid_sticks", ShapeKind::ellipsoid, egg, 5, 0, {0, 0, -0.5}),
        leaning("capsule_slides", ShapeKind::capsule, rod, 0.3, 0, {2, 1, -0.5}),
        leaning("cylinder_slides", ShapeKind::cylinder, rod, 0.3, 0, {2, 1, -0.5}),
        leaning("cylinder_bounces", ShapeKind::cylinder, rod, 0.3, 0.4, {1, 1, -1}),
        leaning("box_slides_on_a_corner", ShapeKind::box, oblong, 0.3, 0, {2, 1, -0.5}),
        leaning("box_sticks_on_a_corner", ShapeKind::box, oblong, 5, 0, {0, 0, -0.5}),
        leaning("box_bounces_on_a_corner", ShapeKind::box, oblong, 0.5, 0.5, {1, 0, -1.5}),
        flat("box_slides_on_four_corners", 0.3, {2, 0, -0.5}),
        flat("box_sticks_on_four_corners", 0.9, {0, 0, -0.5})),
    [](const auto& it) { return it.param.name; });

struct Turned {
  ShapeKind kind;
  Vec3<> size, turn;
};
/// Two free bodies above each other: the lower one flies, so that both move.
struct OfTwoBodies {
  const char* name;
  Turned lower, upper;
  double friction, restitution;
};
void PrintTo(const OfTwoBodies& it, std::ostream* out) { *out << it.name; }

class TwoBodies : public testing::TestWithParam<OfTwoBodies> {};
TEST_P(TwoBodies, HaveTheDerivative) {
  const OfTwoBodies& it = GetParam();
  Bodies bodies(it.friction);
  bodies.add(shape_of(it.lower.kind, it.lower.size, it.friction, it.restitution));
  bodies.add(shape_of(it.upper.kind, it.upper.size, it.friction, it.restitution));
  const Model model = bodies.build();
  const std::vector<double> lower = posed(it.lower.turn, {0, 0, 2});
  std::vector<double> upper = posed(it.upper.turn, {0.02, 0.03, 3});
  const auto together = [&] {
    std::vector<double> q = lower;
    q.insert(q.end(), upper.begin(), upper.end());
    return q;
  };
  Distances distances(model);
  for (int k = 0; k < 50; ++k) {  // the upper body comes down until the gap is 1 mm
    double gap = 0;
    for (const ShapeDistance& d : distances.evaluate(together()))
      if (distances.shapes()[d.a].body == 1 && distances.shapes()[d.b].body == 2) gap = d.distance;
    upper[6] -= 0.8 * (gap - 1e-3);
  }
  std::vector<double> v = moving(lower, {0.2, -0.1, 0.3}, {0.1, 0.2, 0.3});
  for (const double x : moving(upper, {-0.3, 0.2, 0.1}, {0.6, -0.2, -0.6})) v.push_back(x);
  std::vector<double> tau = push;
  for (const double x : push) tau.push_back(-0.5 * x);
  expect_derivatives(model, {together(), v, tau});
}
OfTwoBodies stacked(const char* name, const Turned& lower, const Turned& upper, double friction,
                    double restitution = 0) {
  return {name, lower, upper, friction, restitution};
}
constexpr Vec3<> big_ball{0.2, 0, 0}, long_rod{0.1, 0.6, 0}, slab{0.6, 0.6, 0.2};
INSTANTIATE_TEST_SUITE_P(
    Pairs, TwoBodies,
    testing::Values(stacked("spheres_slide", {ShapeKind::sphere, big_ball, some_turn},
                            {ShapeKind::sphere, ball, spin}, 0.2),
                    stacked("spheres_stick", {ShapeKind::sphere, big_ball, some_turn},
                            {ShapeKind::sphere, ball, spin}, 3),
                    stacked("spheres_bounce", {ShapeKind::sphere, big_ball, some_turn},
                            {ShapeKind::sphere, ball, spin}, 0.3, 0.7),
                    stacked("capsules_cross", {ShapeKind::capsule, long_rod, {1.5, 0, 0.1}},
                            {ShapeKind::capsule, long_rod, {0, 1.6, 0.2}}, 0.4),
                    stacked("capsule_on_a_sphere", {ShapeKind::sphere, big_ball, some_turn},
                            {ShapeKind::capsule, long_rod, {0, 1.6, 0.2}}, 2),
                    stacked("sphere_on_a_box", {ShapeKind::box, slab, {0.05, 0.1, 0}},
                            {ShapeKind::sphere, ball, some_turn}, 0.3),
                    stacked("box_on_a_sphere", {ShapeKind::sphere, big_ball, some_turn},
                            {ShapeKind::box, slab, {0.05, 0.1, 0}}, 2),
                    stacked("box_on_a_box", {ShapeKind::box, slab, {0.02, 0.03, 0.4}},
                            {ShapeKind::box, {0.3, 0.3, 0.2}, {0.1, -0.15, 0.1}}, 0.3)),
    [](const auto& it) { return it.param.name; });

/// A base with an arm of two bodies, whose shapes fall on the floor.
TEST(StepDerivatives, OfTreesAgreeWithDifferences) {
  for (const JointKind base : {JointKind::free, JointKind::spherical, JointKind::prismatic})
    for (const double friction : {0.2, 5.0})
      for (const double restitution : {0.0, 0.4}) {
        SCOPED_TRACE(std::string(to_string(base)) + " " + std::to_string(friction) + " " +
                     std::to_string(restitution));
        Bodies bodies(friction);
        const ShapeDescription ball = shape_of(ShapeKind::sphere, {0.15, 0, 0}, friction, restitution);
        bodies.add(ball).add(ball).add(ball);
        std::vector<BodyDescription>& all = bodies.description.bodies;
        all[0].joint.kind = base;
        for (const std::size_t i : {1U, 2U}) {
          all[i].predecessor = all[i - 1].name;
          all[i].joint = {.kind = JointKind::revolute,
                          .axis = i == 1 ? Vec3<>{0.2, 1, 0} : Vec3<>{1, 0.3, 0.2}};
          all[i].geometry = InBodyFrame{{exp_SO3(Vec3<>{0.3, -0.2, 0.1}), {0.5, 0.1, -0.1}}};
          all[i].shapes[0].pose = {exp_SO3(Vec3<>{-0.2, 0.1, 0.3}), {0.05, 0.02, -0.03}};
        }
        const auto gap_of = [](const Model& model, const std::vector<double>& q) {
          Distances distances(model);
          double least = 1;
          for (const ShapeDistance& d : distances.evaluate(q))
            if (distances.shapes()[d.a].kind == ShapeKind::plane) least = std::min(least, d.distance);
          return least;
        };
        const Model high = bodies.build();
        std::vector<double> q = neutral(high);
        for (std::size_t c = q.size() - 2; c < q.size(); ++c) q[c] = 0.3;
        bodies.description.shapes[0].pose.r += (gap_of(high, q) - 5e-4) * up();
        const Model model = bodies.build();
        Random<double> random(5);
        std::vector<double> v = random_numbers(random, model.nv());
        const std::vector<double> tau = random_numbers(random, model.nv());
        const auto touches = [&] {
          return gap_of(model, step_of(model, ContactShapes(model), {q, v, tau}).q) < 1e-9;
        };
        if (!touches())
          for (double& x : v) x = -x;
        ASSERT_TRUE(touches());
        expect_derivatives(model, {q, v, tau}, 1e-7, 1e-5);
        if (base == JointKind::free)
          expect_derivatives(model, {q, v, std::vector<double>(tau.size())}, 1e-7, 1e-5);
      }
}

/// A ball falls on a plate that follows a motion, sticks to it or slides, and bounces or does not. The states
/// change along all directions in which the plate goes on following its motion.
TEST(StepDerivatives, OfMechanismsThatFollowMotionsAgreeWithDifferences) {
  for (const double friction : {0.2, 5.0})
    for (const double restitution : {0.0, 0.4}) {
      SCOPED_TRACE(std::to_string(friction) + " " + std::to_string(restitution));
      Bodies bodies(friction);
      bodies.add(shape_of(ShapeKind::sphere, {0.15, 0, 0}, friction, restitution));
      Description& d = bodies.description;
      BodyDescription plate = d.bodies[0];
      plate.name = "plate";
      plate.joint = {.name = "turn", .kind = JointKind::revolute, .axis = {0.2, 1, 0.5}};
      plate.shapes = std::exchange(d.shapes, {});
      d.bodies.push_back(plate);
      d.motions = {{.of = "turn", .coefficients = {0.1, 1.5, -2, 3}}};
      const double gap = Distances(bodies.build())
                             .evaluate([] {
                               std::vector<double> q = posed({}, {});
                               q.push_back(0.1);
                               return q;
                             }())[0]
                             .distance;
      const Vec3<> n = exp_SO3((0.1 / norm(d.bodies[1].joint.axis)) * d.bodies[1].joint.axis) * up();
      std::vector<double> q = posed({0.3, -0.2, 0.4}, (1e-3 - gap) * n);
      q.push_back(0.1);
      const std::vector<double> v{0.5, -1, 0.3, 0.2, 0.1, -1, 1.5}, tau{0.1, -0.2, 0.3, 1, -2, 0.5, 4};
      Matrix along = Matrix::Zero(21, 19);
      along.topLeftCorner(6, 6).setIdentity();
      along.block(7, 6, 6, 6).setIdentity();
      along.bottomRightCorner(7, 7).setIdentity();
      const Model model = bodies.build();
      expect_derivatives(model, {q, v, tau}, 1e-7, 1e-5, along);
      const Start start{q, v, tau};
      expect_parameter_derivatives(model, start, step_of(model, ContactShapes(model), start), 1e-7, 1e-5);
    }
}

/// The steps are those of simulations: they are divided where a motion begins to accelerate, and end with the
/// same sentence where a contact blocks the motion.
TEST(StepDerivatives, OfMechanismsThatFollowMotionsAreThoseOfSimulatedSteps) {
  Bodies bodies(0.3);
  bodies.add(shape_of(ShapeKind::sphere, {0.1, 0, 0}, 0.3));
  Description& d = bodies.description;
  d.bodies[0].joint = {.name = "rail", .kind = JointKind::prismatic, .axis = up()};
  d.shapes[0].pose.r -= 0.2 * up();
  using Kind = MotionDescription::Kind;
  d.motions = {{.of = "rail", .kind = Kind::ramp, .from = 0, .to = -0.2, .start = 0.012, .end = 0.1}};
  const Model model = bodies.build();
  const ContactShapes shapes(model);
  const std::vector<double> q{0}, v{0};
  constexpr std::size_t K = 20;
  constexpr double step = 5e-3;
  const auto steps = [&](std::size_t count) {
    std::vector<double> q_out(count + 1), v_out(q_out), A(4 * count), B(2 * count), tau(count);
    const ContactSensitivity found =
        contact_rollout_derivatives(model, shapes, q, v, tau, step, {q_out, v_out, A, B});
    return std::pair(found, q_out);
  };
  const auto [free_motion, places] = steps(8);
  const Trajectory simulated = simulate_contact(model, shapes, q, v, 8 * step, step);
  ASSERT_TRUE(free_motion.ok()) << free_motion.failure.why;
  EXPECT_EQ(simulated.size(), 10) << "a step is divided";
  EXPECT_EQ(places.back(), simulated.q(simulated.size() - 1)[0]);
  EXPECT_LT(places.back(), -1e-3);
  const auto [blocked, none] = steps(K);
  const Trajectory ended = simulate_contact(model, shapes, q, v, K * step, step);
  ASSERT_FALSE(ended.complete);
  EXPECT_THAT(blocked.failure.why, testing::HasSubstr("block the prescribed motion of \"rail\""));
  EXPECT_THAT(ended.stop_reason, testing::HasSubstr(blocked.failure.why));
}

/// Bodies on a compliant floor that begin or end to touch in the step, or touch all the time, and stick or
/// slide.
TEST(StepDerivatives, OfCompliantContactsAgreeWithDifferences) {
  for (const double friction : {0.0, 0.3, 5.0})
    for (const double gap : {-1.4e-3, -2e-4, 4e-4})
      for (const double speed : {-0.5, 0.5}) {
        SCOPED_TRACE(std::to_string(friction) + " " + std::to_string(gap) + " " + std::to_string(speed));
        for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::box}) {
          Bodies bodies(friction);
          bodies.description.shapes.front().contact.stiffness = 1e5;
          bodies.description.shapes.front().contact.damping = 0.3;
          const Model model = bodies.add(shape_of(kind, {0.1, 0.12, 0.14}, friction)).build();
          const std::vector<double> q = lowered(model, posed({0.2, 0.1, -0.1}, {0.1, 0.2, 1}), gap);
          const std::vector<double> v =
              moving(q, {0.3, -0.2, 0.4},
                     Vec3<>{0.4, 0.2, -0.1} + (speed - dot(Vec3<>{0.4, 0.2, -0.1}, up())) * up());
          expect_derivatives(model, {q, v, push, 2e-3}, 1e-6, 1e-5);
        }
      }
}

TEST(StepDerivatives, OfTwoCompliantBodiesAgreeWithDifferences) {
  Bodies bodies(0.4);
  ShapeDescription soft = shape_of(ShapeKind::sphere, {0.1, 0, 0}, 0.4);
  soft.contact.stiffness = 1e5;
  soft.contact.damping = 0.2;
  const Model model = bodies.add(soft).add(soft).build();
  std::vector<double> q = posed({0.2, 0.1, -0.1}, {0, 0, 1});
  for (const double x : posed({-0.3, 0.2, 0.1}, {0.05, 0.03, 1.1905})) q.push_back(x);
  const std::vector<double> v{0.3, 0.2, -0.1, 0.1, 0.2, 0.3, -0.2, 0.1, 0.3, 0, 0.1, -0.4};
  std::vector<double> tau = push;
  tau.insert(tau.end(), push.rbegin(), push.rend());
  expect_derivatives(model, {q, v, tau, 2e-3}, 1e-6, 1e-5);
}

TEST(StepDerivatives, OfAWholeMotionAreProductsOfThoseOfItsSteps) {
  Bodies bodies(0.3);
  bodies.add(shape_of(ShapeKind::box, {0.2, 0.3, 0.25}, 0.3, 0.3));
  bodies.add(shape_of(ShapeKind::sphere, {0.1, 0, 0}, 0.3, 0.3));
  const Model model = bodies.build();
  const ContactShapes shapes(model);
  std::vector<double> q = posed(some_turn, {0, 0, 0.25});
  for (const double x : posed(spin, {0.4, 0, 0.2})) q.push_back(x);
  std::vector<double> v(12, 0.1);
  const std::size_t K = 60, nv = 12;
  Random<double> random(3);
  const auto numbers_of = [&](std::size_t n) { return random_numbers(random, static_cast<int>(n)); };
  const std::vector<double> tau = numbers_of(K * nv), dq = numbers_of(nv), dv = numbers_of(nv),
                            dtau = numbers_of(K * nv), dsurfaces = numbers_of(9), dplacement = numbers_of(18),
                            dinertia = numbers_of(20), dgeometry = numbers_of(12),
                            w_q = numbers_of((K + 1) * nv), w_v = numbers_of((K + 1) * nv);
  std::vector<double> dq_k((K + 1) * nv), dv_k(dq_k), by_q(nv), by_v(nv), by_tau(K * nv), by_surfaces(9),
      by_placement(18), by_inertia(20), by_geometry(12);
  ContactSensitivity found = contact_rollout_jvp(model, shapes, q, v, tau, 5e-3, dq, dv, dtau, dq_k, dv_k, {},
                                                 {dsurfaces, dplacement, dinertia, dgeometry});
  ASSERT_TRUE(found.ok()) << found.failure.why;
  found = contact_rollout_vjp(model, shapes, q, v, tau, 5e-3, w_q, w_v, {by_q, by_v, by_tau}, {},
                              {by_surfaces, by_placement, by_inertia, by_geometry});
  ASSERT_TRUE(found.ok()) << found.failure.why;
  const auto product = [](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
    return sum;
  };
  const double forward = product(w_q, dq_k) + product(w_v, dv_k);
  const double backward = product(by_q, dq) + product(by_v, dv) + product(by_tau, dtau) +
                          product(by_surfaces, dsurfaces) + product(by_placement, dplacement) +
                          product(by_inertia, dinertia) + product(by_geometry, dgeometry);
  EXPECT_NEAR(forward, backward, 1e-9 * (1 + std::abs(forward)));
}

/// A box that a force pushes aside, which friction balances, ends each step at rest, whatever velocity it
/// begins the step with.
TEST(StepDerivatives, OfARestingBoxAreThoseOfABoxThatSticks) {
  const Model model = Scene({.friction = 0.5}).add("box", ShapeKind::box, 0.1, {.friction = 0.5}).build();
  const ContactShapes shapes(model);
  const std::vector<double> rest(6);
  constexpr std::size_t K = 60;
  std::vector<double> q_out(7 * (K + 1)), v_out(6 * (K + 1)), A(144 * K), B(72 * K);
  for (const auto& [aside, away] : {std::pair{0.1, 0.0}, {0.3, 0.0}, {0.7, 0.0}, {0.3, 1e4}}) {
    const std::vector<double> q{0, 0, 0, 1, away, 0, 0.1};
    std::vector<double> tau(6 * K);
    for (std::size_t k = 0; k < K; ++k) tau[6 * k + 3] = aside;
    const ContactSensitivity found =
        contact_rollout_derivatives(model, shapes, q, rest, tau, 5e-3, {q_out, v_out, A, B});
    ASSERT_TRUE(found.ok() && found.unique) << aside << " N, at " << away << " m";
    for (std::size_t k = 0; k < K; ++k)
      for (std::size_t r = 6; r < 12; ++r)
        for (std::size_t c = 6; c < 12; ++c) EXPECT_NEAR(A[144 * k + 12 * r + c], 0, 1e-9) << k;
  }
}

TEST(StepDerivatives, RefuseDrivesWithStates) {
  Bodies bodies(0.3);
  bodies.add(shape_of(ShapeKind::sphere, {0.1, 0, 0}, 0.3));
  BodyDescription wheel{.name = "wheel"};
  wheel.joint = {.name = "axle", .kind = JointKind::revolute};
  wheel.inertia = MassProperties{.mass = 1, .Theta = {0.1, 0.1, 0.1, 0, 0, 0}};
  bodies.description.bodies.push_back(wheel);
  bodies.description.drives.push_back(
      {.kind = DriveKind::dc_motor,
       .joints = {{"axle", 1.0}},
       .parameters = {{"resistance", 1}, {"inductance", 0.01}, {"torque_constant", 0.2}},
       .input = {.values = {1.0}}});
  const Model model = bodies.build();
  std::vector<double> q = posed({}, {0, 0, 0.1});
  q.push_back(0);
  EXPECT_THAT(message_of([&] {
                step_of(model, ContactShapes(model), {q, std::vector<double>(7), std::vector<double>(7)});
              }),
              testing::StartsWith("contact does not count drives with states, and model"));
}

TEST(StepDerivatives, RefuseContactPointsWithoutAClosedForm) {
  Bodies bodies(0.3);
  bodies.add(shape_of(ShapeKind::cylinder, {0.2, 0.3, 0}, 0.3))
      .add(shape_of(ShapeKind::ellipsoid, {0.1, 0.15, 0.2}, 0.3));
  const Model model = bodies.build();
  std::vector<double> q = posed({}, {0, 0, 2});
  for (const double x : posed({}, {0, 0, 2.34})) q.push_back(x);
  std::vector<double> v(12);
  v[11] = -1;
  const Step step = step_of(model, ContactShapes(model), {q, v, std::vector<double>(12)});
  EXPECT_FALSE(step.result.ok());
  EXPECT_EQ(step.result.failure.why,
            "the points of contact between \"body 0 shape 1\" and \"body 1 shape 1\" have no closed form, so "
            "that their derivatives are not known; give one of the two another shape");
  EXPECT_TRUE(std::isnan(step.A(0, 0)));
}

}  // namespace
}  // namespace axode::test
