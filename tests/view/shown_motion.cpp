#include "axode/view/shown_motion.hpp"

#include <gtest/gtest.h>

#include "axode/constraints/assembly.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/model/building/builder.hpp"

/// The numbers that a page shows of a motion.
namespace axode::test {
namespace {

/// A ball on a vertical slide that falls on the floor.
Model falling_ball() {
  ShapeDescription shape{.role = ShapeDescription::Role::collision, .kind = ShapeKind::plane};
  Description d{.name = "falling ball", .bodies = {}, .frames = {}};
  d.shapes = {shape};
  shape.kind = ShapeKind::sphere;
  shape.radius = 0.1;
  d.bodies = {{.name = "ball",
               .joint = {.name = "slide", .kind = JointKind::prismatic, .axis = {0, 0, 1}},
               .inertia = MassProperties{.mass = 2, .com = {}, .Theta = {0.008, 0.008, 0.008}}}};
  d.bodies[0].shapes = {shape};
  d.contact = ContactDescription{};
  return ModelBuilder(std::move(d)).build();
}

TEST(ShownMotion, WrenchesOfJointsCountTheForcesOfContacts) {
  const Model model = falling_ball();
  const Trajectory motion =
      simulate_contact(model, std::vector<double>{0.15}, std::vector<double>{0}, 0.5, 1e-3);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  ShownMotion shown{.t = {motion.t().begin(), motion.t().end()},
                    .q = {motion.q().begin(), motion.q().end()},
                    .v = {motion.v().begin(), motion.v().end()},
                    .a = {motion.a().begin(), motion.a().end()},
                    .contact_shapes = motion.contact_shapes};
  for (std::size_t k = 0; k < motion.size(); ++k)
    shown.contacts.emplace_back(motion.contacts(k).begin(), motion.contacts(k).end());
  const std::vector<double> wrenches = view::numbers_of(model, shown).wrenches;
  ASSERT_EQ(wrenches.size(), 6 * motion.size());
  // The first row has the forces of no step.
  for (std::size_t k = 1; k < motion.size(); ++k) EXPECT_NEAR(wrenches[6 * k + 5], 0, 1e-9) << motion.t()[k];
  EXPECT_FALSE(shown.contacts.back().empty());

  shown.contacts.clear();
  EXPECT_NEAR(view::numbers_of(model, shown).wrenches.back(), 2 * 9.81, 1e-9) << "as if the slide held it";
  shown.contacts.resize(motion.size());
  shown.contact_shapes = {"a shape of another mechanism"};
  EXPECT_TRUE(view::numbers_of(model, shown).wrenches.empty());
}

/// The moment of the joint of a prescribed crank about its axis is the force of the motion.
TEST(ShownMotion, WrenchesOfJointsCountPrescribedMotions) {
  const MassProperties inertia{.mass = 1, .com = {0.1, 0, 0}, .Theta = {0.1, 0.1, 0.1}};
  const auto hinge = [&](const char* name, const char* on, Vec3<> at) {
    return BodyDescription{
        .name = name,
        .predecessor = on,
        .joint = {.name = std::string(name) + " joint", .kind = JointKind::revolute, .point = at},
        .inertia = inertia};
  };
  Description d{.name = "four-bar", .gravity = {0, -9.81, 0}, .bodies = {}, .frames = {}};
  d.bodies = {hinge("crank", "ground", {}), hinge("rod", "crank", {0, 0.1, 0}),
              hinge("rocker", "ground", {0.4, 0, 0})};
  d.loops = {{.name = "pin", .between = {"rod", "rocker"}, .point = {0.4, 0.3, 0}}};
  d.motions = {{.of = "crank joint", .coefficients = {0, 3, 1}}};
  const Model model = ModelBuilder(std::move(d)).build();
  const AssemblyResult start = assemble(model, std::vector<double>(3), std::vector<double>(3));
  ASSERT_EQ(start.status, AssemblyStatus::closed);
  const Trajectory motion = simulate(model, start.q, start.v, 0.5);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  const ShownMotion shown{.t = {motion.t().begin(), motion.t().end()},
                          .q = {motion.q().begin(), motion.q().end()},
                          .v = {motion.v().begin(), motion.v().end()},
                          .a = {motion.a().begin(), motion.a().end()},
                          .tau = {motion.tau().begin(), motion.tau().end()}};
  const view::MotionNumbers numbers = view::numbers_of(model, shown);
  ASSERT_EQ(numbers.wrenches.size(), 18 * motion.size());
  for (std::size_t k = 0; k < motion.size(); ++k) {
    const double force =
        forward_dynamics_at(model, motion.t()[k], motion.q(k), motion.v(k), std::vector<double>(3))
            .motion_forces[0];
    EXPECT_NEAR(numbers.wrenches[18 * k + 2], force, 1e-8 * (1 + std::abs(force))) << motion.t()[k];
  }
}

}  // namespace
}  // namespace axode::test
