#include <gtest/gtest.h>

#include <cmath>

#include "axode/integration/contact_sensitivities.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/model/configuration.hpp"
#include "tests/contact/reference_contacts.hpp"
#include "tests/support/random_loops.hpp"
#include "tests/support/refused_arguments.hpp"

/// Derivatives of steps with contact against differences of fourth order, on every branch of the laws.
namespace axode::test {
namespace {

using Matrix = Eigen::MatrixXd;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;

/// A state and a step of it.
struct Start {
  std::vector<double> q, v, tau;
  double step = 5e-3;
};
/// The end of a step and its derivatives by displacements, velocities and forces.
struct Step {
  std::vector<double> q, v;
  Rows A, B;
  ContactSensitivity result;
};
Step step_of(const Model& model, const ContactShapes& shapes, const Start& start) {
  const std::size_t nq = start.q.size(), nv = start.v.size();
  Step out{
      std::vector<double>(2 * nq), std::vector<double>(2 * nv), Rows(2 * nv, 2 * nv), Rows(2 * nv, nv), {}};
  out.result = contact_rollout_derivatives(model, shapes, start.q, start.v, start.tau, start.step,
                                           {out.q, out.v, as_span(out.A), as_span(out.B)});
  out.q.erase(out.q.begin(), out.q.begin() + static_cast<std::ptrdiff_t>(nq));
  out.v.erase(out.v.begin(), out.v.begin() + static_cast<std::ptrdiff_t>(nv));
  return out;
}

/// The end of a step as displacements from `from`, and velocities.
Vector end_of(const Model& model, const Start& start, const std::vector<double>& from) {
  SimulationOptions options;
  options.joint_losses = true;
  options.drive = [&](double, std::span<const double>, std::span<const double>, std::span<double> tau) {
    std::ranges::copy(start.tau, tau.begin());
  };
  const Trajectory motion = simulate_contact(model, start.q, start.v, start.step, start.step, options);
  EXPECT_TRUE(motion.complete) << motion.stop_reason;
  const Eigen::Index nv = model.nv();
  Vector out(2 * nv);
  const std::size_t last = motion.size() - 1;
  const std::vector<double> by = difference(model, from, motion.q(last));
  out.head(nv) = as_eigen(std::span<const double>(by));
  out.tail(nv) = as_eigen(motion.v(last));
  return out;
}

/// Differences of fourth order along the directions of the state and the forces; `along` (3nv × directions).
Matrix differences(const Model& model, const Start& start, const Step& step, const Matrix& along,
                   double size) {
  const Eigen::Index nv = model.nv();
  Matrix out(2 * nv, along.cols());
  for (Eigen::Index k = 0; k < along.cols(); ++k) {
    const auto at = [&](double by) {
      Start moved = start;
      const Vector x = by * along.col(k);
      moved.q = integrate(model, start.q, std::span(x.data(), static_cast<std::size_t>(nv)));
      for (Eigen::Index c = 0; c < nv; ++c) {
        moved.v[static_cast<std::size_t>(c)] += x[nv + c];
        moved.tau[static_cast<std::size_t>(c)] += x[2 * nv + c];
      }
      return end_of(model, moved, step.q);
    };
    out.col(k) = (8 * (at(size) - at(-size)) - (at(2 * size) - at(-2 * size))) / (12 * size);
  }
  return out;
}

/// Checks the derivatives of a step in all directions, or along some.
void expect_derivatives(const Model& model, const Start& start, double tolerance = 1e-7, double size = 3e-5,
                        Matrix along = {}) {
  const ContactShapes shapes(model);
  const Step step = step_of(model, shapes, start);
  ASSERT_TRUE(step.result.ok()) << step.result.failure.why;
  EXPECT_TRUE(step.result.unique);
  EXPECT_LE(step.result.certificate, 1e-9);
  const Eigen::Index nv = model.nv();
  const Vector end = end_of(model, start, step.q);
  EXPECT_LE(end.head(nv).norm(), 1e-13);
  for (Eigen::Index c = 0; c < nv; ++c) EXPECT_EQ(end[nv + c], step.v[static_cast<std::size_t>(c)]);
  if (along.size() == 0) along = Matrix::Identity(3 * nv, 3 * nv);
  Matrix by(2 * nv, 3 * nv);
  by << step.A, step.B;
  const Matrix exact = by * along, expected = differences(model, start, step, along, size);
  EXPECT_LE((exact - expected).lpNorm<Eigen::Infinity>(),
            tolerance * (1 + expected.lpNorm<Eigen::Infinity>()))
      << "exact\n"
      << exact << "\ndifferences\n"
      << expected;
}

ShapeDescription shape_of(ShapeKind kind, const Vec3<>& size, double friction, double restitution = 0) {
  ShapeDescription shape{.role = ShapeDescription::Role::collision, .kind = kind, .size = size};
  shape.radius = size.x;
  shape.length = size.y;
  shape.contact = {.friction = friction, .restitution = restitution};
  return shape;
}

/// A leaning floor, and free bodies with one shape each.
struct Bodies {
  Description description;

  explicit Bodies(double friction) {
    ShapeDescription plane = shape_of(ShapeKind::plane, {}, friction);
    plane.name = "floor";
    const double c = std::cos(0.2), s = std::sin(0.2);
    plane.pose.R = {{c, 0, -s}, {0, 1, 0}, {s, 0, c}};
    description.shapes.push_back(plane);
    description.contact = ContactDescription{.threshold = 0.01};
  }
  Bodies& add(const ShapeDescription& shape) {
    BodyDescription body{.name = "body " + std::to_string(description.bodies.size())};
    body.joint = {.kind = JointKind::free};
    body.inertia = MassProperties{
        .mass = 1.3, .com = {0.01, -0.02, 0.015}, .Theta = {0.02, 0.025, 0.03, 0.001, -0.002, 0.003}};
    body.shapes.push_back(shape);
    description.bodies.push_back(body);
    return *this;
  }
  Model build() const { return ModelBuilder(description).build(); }
};
Vec3<> up() { return {std::sin(0.2), 0, std::cos(0.2)}; }

/// A pose of a free joint with a rotation about an axis and then a height of its lowest point over the floor.
std::vector<double> posed(const Vec3<>& turn, const Vec3<>& r) {
  const double angle = norm(turn), s = angle > 0 ? std::sin(angle / 2) / angle : 0;
  return {s * turn.x, s * turn.y, s * turn.z, std::cos(angle / 2), r.x, r.y, r.z};
}
/// Moves a single free body along the normal of the floor until its least gap is `gap`.
std::vector<double> lowered(const Model& model, std::vector<double> q, double gap) {
  Distances distances(model);
  const double d = distances.evaluate(q)[0].distance;
  const Vec3<> n = up();
  q[4] += (gap - d) * n.x;
  q[5] += (gap - d) * n.y;
  q[6] += (gap - d) * n.z;
  return q;
}
/// The velocity of a free body that moves with a velocity in space and turns with one in its own axes.
std::vector<double> moving(const std::vector<double>& q, const Vec3<>& w, const Vec3<>& velocity) {
  const SO3<> R = rotation(Quaternion<>{q[0], q[1], q[2], q[3]});
  const Vec3<> v = transpose(R) * velocity;
  return {w.x, w.y, w.z, v.x, v.y, v.z};
}

const std::vector<double> push{0.02, -0.01, 0.03, 0.2, -0.1, 0.3};

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

/// The last state of a motion of some steps under constant forces, and its derivative by them.
/// Bodies on a compliant floor that begin or end to touch in the step, or touch all the time, and stick or slide.
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
                            dtau = numbers_of(K * nv), w_q = numbers_of((K + 1) * nv),
                            w_v = numbers_of((K + 1) * nv);
  std::vector<double> dq_k((K + 1) * nv), dv_k(dq_k), by_q(nv), by_v(nv), by_tau(K * nv);
  ContactSensitivity found = contact_rollout_jvp(model, shapes, q, v, tau, 5e-3, dq, dv, dtau, dq_k, dv_k);
  ASSERT_TRUE(found.ok()) << found.failure.why;
  found = contact_rollout_vjp(model, shapes, q, v, tau, 5e-3, w_q, w_v, {by_q, by_v, by_tau});
  ASSERT_TRUE(found.ok()) << found.failure.why;
  const auto product = [](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
    return sum;
  };
  const double forward = product(w_q, dq_k) + product(w_v, dv_k);
  const double backward = product(by_q, dq) + product(by_v, dv) + product(by_tau, dtau);
  EXPECT_NEAR(forward, backward, 1e-9 * (1 + std::abs(forward)));
}

/// Friction and restitution of a floor and of a ball, the height of the floor and the radius of the ball.
TEST(StepDerivatives, BySurfacesAgreeWithDifferences) {
  struct Case {
    double friction;  ///< of the floor
    Vec3<> velocity;
  };
  for (const Case& it : {Case{0.2, {1, 0.5, -1.5}}, Case{0.2, {0.2, 0.5, -0.5}}, Case{6, {0.1, 0, -1.5}}}) {
    const auto build = [&](const Vector& by) {
      Bodies bodies(it.friction + by[0]);
      bodies.add(shape_of(ShapeKind::sphere, {0.1 + by[5], 0, 0}, 0.3 + by[1], 0.5 + by[3]));
      ShapeDescription& floor = bodies.description.shapes[0];
      floor.contact.restitution = 0.2 + by[2];
      floor.pose.r += by[4] * up();
      return bodies.build();
    };
    const Model model = build(Vector::Zero(6));
    const ContactShapes shapes(model);
    const std::vector<double> q = lowered(model, posed(some_turn, {0.1, 0.2, 1}), 1e-3);
    const Start start{q, moving(q, spin, it.velocity), push};
    std::vector<double> q_k(14), v_k(12);
    Rows A(12, 12), B(12, 6), C(12, 6);
    const ContactSensitivity found =
        contact_rollout_derivatives(model, shapes, start.q, start.v, start.tau, start.step,
                                    {q_k, v_k, as_span(A), as_span(B), as_span(C)});
    ASSERT_TRUE(found.ok()) << found.failure.why;
    const std::vector<double> from(q_k.begin() + 7, q_k.end());
    EXPECT_GT(C.norm(), 1e-2);
    for (Eigen::Index k = 0; k < 6; ++k) {
      const auto at = [&](double by) { return end_of(build(by * Vector::Unit(6, k)), start, from); };
      const double size = 3e-5;
      const Vector expected = (8 * (at(size) - at(-size)) - (at(2 * size) - at(-2 * size))) / (12 * size);
      EXPECT_LE((C.col(k) - expected).norm(), 1e-7 * (1 + expected.norm()))
          << k << ": " << C.col(k).transpose() << "\n"
          << expected.transpose();
    }
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

/// Mechanisms of all files, with stops, dry joints and loops, along motions of some steps.
class MotionDerivatives : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == no_case) GTEST_SKIP() << missing(contact_folder(), "AXODE_VECTORS");
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, MotionDerivatives, testing::ValuesIn(contact_cases()), case_name);

/// Forces change the ends of motions as differences say, wherever both one-sided differences agree.
TEST_P(MotionDerivatives, ByForcesAgreeWithDifferences) {
  const ReferenceContacts reference(GetParam());
  const Model model = reference.build();
  const ContactShapes shapes(model);
  const std::size_t nv = static_cast<std::size_t>(model.nv()), K = 3;
  int compared = 0, kinks = 0;
  for (const Json& state : reference.file.at("states")) {
    SCOPED_TRACE(state.at("name").text());
    const std::vector<double> q = numbers(state.at("q")), v = numbers(state.at("v")),
                              tau_1 = numbers(state.at("tau"));
    const double step = 2e-3;
    Random<double> random(7);
    std::vector<double> tau, dtau = random_numbers(random, static_cast<int>(K * nv));
    for (std::size_t k = 0; k < K; ++k) tau.insert(tau.end(), tau_1.begin(), tau_1.end());
    std::vector<double> dq((K + 1) * nv), dv(dq);
    const std::vector<double> none(nv);
    const ContactSensitivity found =
        contact_rollout_jvp(model, shapes, q, v, tau, step, none, none, dtau, dq, dv);
    ASSERT_TRUE(found.ok()) << found.failure.why;
    if (found.certificate > 1e-9 || !found.unique) continue;
    std::vector<double> from = q;
    const auto at = [&](double by) {
      SimulationOptions options;
      options.joint_losses = true;
      options.drive = [&](double t, std::span<const double>, std::span<const double>, std::span<double> out) {
        const std::size_t k = std::min(K - 1, static_cast<std::size_t>(t / step));
        for (std::size_t c = 0; c < nv; ++c) out[c] = tau[k * nv + c] + by * dtau[k * nv + c];
      };
      const Trajectory motion = simulate_contact(model, q, v, step * static_cast<double>(K), step, options);
      EXPECT_TRUE(motion.complete) << motion.stop_reason;
      const std::size_t last = motion.size() - 1;
      Vector out(2 * static_cast<Eigen::Index>(nv));
      if (by == 0) from.assign(motion.q(last).begin(), motion.q(last).end());
      const std::vector<double> moved = difference(model, from, motion.q(last));
      out << as_eigen(std::span<const double>(moved)), as_eigen(motion.v(last));
      return out;
    };
    // Where several points share a load and slide, solutions differ by more than rounding: two sizes of the
    // differences say by how much.
    const Vector here = at(0);
    const auto difference_of = [&](double size, Vector& jump) {
      const Vector one = at(size), two = at(2 * size), back = at(-size), far = at(-2 * size);
      jump = (4 * (one + back) - (two + far) - 6 * here) / (2 * size);  // of one-sided differences
      return Vector((8 * (one - back) - (two - far)) / (12 * size));
    };
    Vector jump, other_jump;
    const Vector central = difference_of(1e-3, jump), other = difference_of(2.5e-4, other_jump);
    Vector exact(2 * static_cast<Eigen::Index>(nv));
    exact << as_eigen(std::span<const double>(dq).last(nv)), as_eigen(std::span<const double>(dv).last(nv));
    if (jump.norm() > 1e-3 * central.norm()) {
      ++kinks;
      continue;
    }
    ++compared;
    EXPECT_LE((exact - central).norm(), 1e-7 * central.norm() + 1e-9 + 2 * (central - other).norm())
        << exact.transpose() << "\n"
        << central.transpose();
  }
  EXPECT_GE(compared, 1) << "states where the motion has a derivative";
}

}  // namespace
}  // namespace axode::test
