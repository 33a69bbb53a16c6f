#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "axode/contact.hpp"
#include "axode/dynamics.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/kinematics.hpp"
#include "tests/contact/scene.hpp"
#include "tests/contact/two_shapes.hpp"
#include "tests/support/comparison.hpp"

/// Points of contact with their forces: in trajectories and at rest.
namespace axode::test {
namespace {

ShapeDescription with_friction(ShapeDescription shape, double friction, double restitution = 0) {
  shape.contact.friction = friction;
  shape.contact.restitution = restitution;
  return shape;
}
ShapeDescription box(double friction) {
  return with_friction(collision_shape(ShapeKind::box, {0.2, 0.2, 0.2}, 0, 0), friction);
}
/// A free body at a place on a floor.
Model on_floor(const ShapeDescription& shape) { return with_floor(free_bodies({shape})); }

Vec3<> sum(std::span<const ContactForce> contacts) {
  Vec3<> total;
  for (const ContactForce& contact : contacts) total += contact.force;
  return total;
}

TEST(ContactForces, OfABoxAtRestAreItsWeightAndStick) {
  const Model model = on_floor(box(0.6));
  const Trajectory motion = simulate_contact(model, at({0, 0, 0.1}), std::vector<double>(6), 0.05, 5e-3);
  EXPECT_TRUE(motion.contacts(0).empty()) << "nothing has acted yet";
  ASSERT_EQ(motion.contact_shapes, (std::vector<std::string>{"floor", "body 0 shape 1"}));
  for (std::size_t k = 1; k < motion.size(); ++k) {
    const auto contacts = motion.contacts(k);
    ASSERT_EQ(contacts.size(), 4u);
    EXPECT_LT(norm(sum(contacts) - Vec3<>{0, 0, g}), 1e-10);
    for (const ContactForce& contact : contacts) {
      EXPECT_EQ(contact.branch, LawBranch::stick);
      EXPECT_EQ(motion.contact_shapes[contact.a], "floor");
      EXPECT_EQ(contact.body_b, 1);
      EXPECT_NEAR(contact.gap, 0, 1e-12);
      EXPECT_NEAR(contact.normal.z, 1, 1e-12);
    }
  }
}

TEST(ContactForces, OfASlidingBoxAreOnCoulombsConeAgainstItsMotion) {
  const double mu = std::sqrt(0.3 * 0.6);
  const Model model = on_floor(box(0.3));
  std::vector<double> v(6);
  v[3] = 1;
  v[4] = -0.5;
  const Trajectory motion = simulate_contact(model, at({0, 0, 0.1}), v, 0.1, 5e-3);
  const Vec3<> along = (1 / std::hypot(1, 0.5)) * Vec3<>{1, -0.5, 0};
  for (std::size_t k = 1; k < motion.size(); ++k) {
    EXPECT_LT(norm(sum(motion.contacts(k)) - Vec3<>{0, 0, g} + mu * g * along), 1e-9);
    for (const ContactForce& contact : motion.contacts(k)) {
      EXPECT_DOUBLE_EQ(contact.friction, mu);
      EXPECT_EQ(contact.branch, LawBranch::slide);
      EXPECT_NEAR(norm(contact.friction_force()), mu * contact.normal_force(), 1e-9);
    }
  }
}

/// The impulses on each body of a random pile are the change of its momentum, with impacts and tumbling. No
/// shapes overlap at the start: the motion that parts overlaps turns a body with its momentum.
TEST(ContactForces, AreTheChangeOfMomentumOfEachBody) {
  Random<double> random(7);
  std::vector<ShapeDescription> shapes;
  for (const ShapeKind kind : {ShapeKind::box, ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box}) {
    const double mu = random.number(0.2, 0.8);  // compilers differ in the order of arguments
    shapes.push_back(with_friction(random_collision_shape(random, kind), mu, 0.3));
  }
  const Model model = with_floor(free_bodies(shapes));
  std::vector<double> q, v;
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    for (const double x : at({0.1 * double(k % 2), 0.05 * double(k), 0.8 + 1.6 * double(k)})) q.push_back(x);
    for (int c = 0; c < 6; ++c) v.push_back(random.number(-1, 1));
  }
  const Trajectory motion = simulate_contact(model, q, v, 1.6, 5e-3);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  Workspace<> workspace(model, cut_tree);
  const std::size_t n = shapes.size() + 1;
  std::vector<Momentum<Spatial>> before(n - 1), after(n - 1);
  std::size_t pressed = 0;
  for (std::size_t k = 1; k < motion.size(); ++k) {
    body_momenta<Spatial, double>(model, workspace, motion.q(k - 1), motion.v(k - 1), before);
    body_momenta<Spatial, double>(model, workspace, motion.q(k), motion.v(k), after);
    const double h = motion.t()[k] - motion.t()[k - 1];
    std::vector<Vec3<>> forces(n);
    for (const ContactForce& contact : motion.contacts(k)) {
      forces[contact.body_b] += contact.force;
      forces[contact.body_a] -= contact.force;
      pressed += contact.branch != LawBranch::open;
      EXPECT_GE(contact.normal_force(), -1e-6 * norm(contact.force));
    }
    for (std::size_t i = 0; i + 1 < n; ++i) {
      const Vec3<> by_contacts = after[i].p - before[i].p - h * Vec3<>{0, 0, -g};
      EXPECT_LT(norm(h * forces[i + 1] - by_contacts), 1e-9) << "body " << i << " at " << motion.t()[k];
    }
  }
  EXPECT_GT(pressed, 100u);
}

TEST(ContactForces, AreNoneWithoutContactAndBelongToTheStepOfTheirTime) {
  const Model model = on_floor(box(0.6));
  const std::vector<double> q = at({0, 0, 0.1}), v(6);
  const Trajectory free = simulate_fixed(model, q, v, 0.02, 1e-2);
  EXPECT_TRUE(free.contact_shapes.empty());
  for (std::size_t k = 0; k < free.size(); ++k) EXPECT_TRUE(free.contacts(k).empty());

  SimulationOptions options;
  options.events.push_back({.value = [](double t, auto, auto) { return t - 0.025; }, .terminal = true});
  Trajectory motion = simulate_contact(model, q, v, 1, 1e-2, options);
  ASSERT_EQ(motion.size(), 4u) << "it ends within the third step";
  for (std::size_t k = 1; k < motion.size(); ++k) EXPECT_EQ(motion.contacts(k).size(), 4u);
  EXPECT_EQ(motion.contacts_at(0.015).data(), motion.contacts(2).data());
  EXPECT_EQ(motion.contacts_at(0.02).data(), motion.contacts(2).data());
  EXPECT_TRUE(motion.contacts_at(0).empty());
  motion.pop_back();
  EXPECT_EQ(motion.contacts(2).size(), 4u);
  EXPECT_TRUE(motion.contacts(3).empty());
}

TEST(ContactsAtRest, HoldABoxUpToItsAngleOfFriction) {
  const double mu = 0.5;
  for (const double angle : {std::atan(mu) * (1 - 1e-6), std::atan(mu) + 0.1}) {
    Description d = free_bodies({with_friction(collision_shape(ShapeKind::box, {0.2, 0.2, 0.2}, 0, 0), mu)})
                        .description();
    d.gravity = {g * std::sin(angle), 0, -g * std::cos(angle)};
    d.shapes.push_back(with_friction(collision_shape(ShapeKind::plane, {}, 0, 0), mu));
    const Model model = ModelBuilder(std::move(d)).build();
    const ContactsAtRest found =
        contacts_at_rest(model, ContactShapes(model), at({0, 0, 0.1}), {}, {.margin = 0.01});
    ASSERT_EQ(found.contacts.size(), 4u);
    EXPECT_LE(found.certificate, 1e-12);
    const double excess = g * (std::sin(angle) - mu * std::cos(angle));
    const bool slides = excess > 0;
    EXPECT_NEAR(found.a[3], slides ? excess : 0, 1e-10);
    EXPECT_NEAR(sum(found.contacts).z, g * std::cos(angle), 1e-10);
    for (const ContactForce& contact : found.contacts)
      EXPECT_EQ(contact.branch, slides ? LawBranch::slide : LawBranch::stick);
  }
}

TEST(ContactsAtRest, PressOnlyIfTheyTouch) {
  const Model model = on_floor(box(0.6));
  const ContactShapes shapes(model);
  for (const double gap : {-1e-3, 0.0, 5e-7, 2e-6, 5e-3}) {
    const ContactsAtRest found = contacts_at_rest(model, shapes, at({0, 0, 0.1 + gap}));
    ASSERT_EQ(found.contacts.size(), 4u);
    const bool presses = gap <= 1e-6;
    EXPECT_NEAR(sum(found.contacts).z, presses ? g : 0, 1e-10) << gap;
    EXPECT_NEAR(found.a[5], presses ? 0 : -g, 1e-10) << gap;
    for (const ContactForce& contact : found.contacts) {
      EXPECT_NEAR(contact.gap, gap, 1e-15);
      EXPECT_EQ(contact.branch, presses ? LawBranch::stick : LawBranch::open);
    }
  }
  EXPECT_TRUE(contacts_at_rest(model, shapes, at({0, 0, 0.2})).contacts.empty());
  EXPECT_EQ(contacts_at_rest(model, shapes, at({0, 0, 0.2}), {}, {.margin = 0.2}).contacts.size(), 4u);
}

/// A chain of links with balls, and a wall across n at a distance.
Model chain_at_wall(const Vec3<>& n, double distance, double friction) {
  Description d{.name = "chain at a wall", .bodies = {}};
  ShapeDescription wall = with_friction(collision_shape(ShapeKind::plane, {}, 0, 0), friction);
  wall.pose = {rotation_to(n), distance * n};
  d.shapes.push_back(wall);
  for (int k = 0; k < 4; ++k) {
    const Vec3<> center{0, 0, 0.9 - 0.2 * k};
    BodyDescription link{.name = "link " + std::to_string(k),
                         .predecessor = k == 0 ? "ground" : "link " + std::to_string(k - 1)};
    link.joint = {.kind = JointKind::revolute, .axis = {0.2 * k, 1, 0}, .point = {0, 0, 1 - 0.2 * k}};
    link.inertia = MassProperties{.mass = 1 + 0.3 * k, .com = center, .Theta = {0.01, 0.01, 0.01, 0, 0, 0}};
    link.shapes.push_back(with_friction(collision_shape(ShapeKind::sphere, {}, 0.05, 0), friction));
    link.shapes.back().pose.r = center;
    d.bodies.push_back(link);
  }
  return ModelBuilder(std::move(d)).build();
}

/// Forward dynamics with the forces as loads give the accelerations, which obey Signorini's law.
TEST(ContactsAtRest, ExplainTheAccelerationsOfAChainAtAWall) {
  Random<double> random(11);
  int pressing = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const Vec3<> across{random.number(-1, 1), random.number(-1, 1), random.number(-1, 1)};
    const Vec3<> n = (1 / norm(across)) * across;
    const double friction = random.number(0.1, 1);
    std::vector<double> q(4), tau(4);
    for (double& x : q) x = random.number(-1, 1);
    for (double& x : tau) x = random.number(-3, 3);
    const Model in_the_air = chain_at_wall(n, 0, friction);
    Distances distances(in_the_air);
    double nearest = 1e9;
    for (const ShapeDistance& x : distances.evaluate(q))
      if (distances.shapes()[x.a].kind == ShapeKind::plane) nearest = std::min(nearest, x.distance);
    const Model model = chain_at_wall(n, nearest, friction);

    const ContactsAtRest found = contacts_at_rest(model, ContactShapes(model), q, tau);
    EXPECT_LE(found.certificate, 1e-10);
    std::vector<AppliedWrench<>> loads;
    for (const ContactForce& contact : found.contacts) {
      const Vec3<> f = contact.force, moment = cross(contact.point, f) + contact.moment;
      if (contact.body_b > 0) loads.emplace_back(contact.body_b, Wrench<Spatial>{moment, f});
      if (contact.body_a > 0) loads.emplace_back(contact.body_a, Wrench<Spatial>{-moment, -f});
    }
    Workspace<> workspace(model);
    std::vector<double> a(4), v(4);
    ASSERT_TRUE(forward_dynamics(model, workspace, q, v, tau, a, {.wrenches = loads}).ok());
    for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(a[c], found.a[c], 1e-8 * (1 + largest(a)));

    Distances at_wall(model);
    const auto near = at_wall.evaluate(q, 1e-6);
    std::vector<double> J(4 * near.size());
    at_wall.jacobian(J);
    for (std::size_t k = 0; k < near.size(); ++k) {
      double opening = 0;
      for (std::size_t c = 0; c < 4; ++c) opening += J[4 * k + c] * a[c];
      double pressure = 0;
      for (const ContactForce& contact : found.contacts)
        if (contact.a == near[k].a && contact.b == near[k].b) pressure += contact.normal_force();
      EXPECT_GE(opening, -1e-8);
      EXPECT_GE(pressure, 0);
      EXPECT_NEAR(opening * pressure, 0, 1e-7);
      pressing += pressure > 0;
    }
  }
  EXPECT_GT(pressing, 10);
}

TEST(ContactsAtRest, RefuseWhatTheyDoNotCount) {
  const Model model = on_floor(box(0.6));
  const ContactShapes shapes(model);
  EXPECT_THROW((void)contacts_at_rest(model, shapes, std::vector<double>(3)), std::invalid_argument);
  EXPECT_THROW((void)contacts_at_rest(model, shapes, at({0, 0, 1}), std::vector<double>{1}),
               std::invalid_argument);
  EXPECT_THROW((void)contacts_at_rest(model, shapes, at({0, 0, 1}), {}, {.touching = -1}),
               std::invalid_argument);
  EXPECT_THROW((void)with_floor(model, std::nan("")), std::invalid_argument);
  EXPECT_THAT([] { (void)with_floor(free_bodies({{.role = ShapeDescription::Role::visual}})); },
              testing::ThrowsMessage<std::invalid_argument>(
                  testing::HasSubstr("has a collision shape, so that nothing could touch the floor")));
}

}  // namespace
}  // namespace axode::test
