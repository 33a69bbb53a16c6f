#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "axode/dynamics/momentum/energy.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/model/model.hpp"
#include "tests/contact/reference_contacts.hpp"
#include "tests/support/random_tree.hpp"

/// Free bodies on a floor.
namespace axode::test {

inline constexpr double g = 9.81;

inline ShapeDescription touching(ShapeKind kind, const ContactProperties& surface, double size = 0) {
  ShapeDescription shape{.role = ShapeDescription::Role::collision, .kind = kind};
  shape.radius = size;
  shape.size = {2 * size, 2 * size, 2 * size};
  shape.contact = surface;
  return shape;
}

/// A floor that may lean about y, and free bodies on it.
struct Scene {
  Description description;

  explicit Scene(const ContactProperties& floor, double angle = 0) {
    ShapeDescription plane = touching(ShapeKind::plane, floor);
    plane.name = "floor";
    plane.pose.R = {{std::cos(angle), 0, -std::sin(angle)}, {0, 1, 0}, {std::sin(angle), 0, std::cos(angle)}};
    description.shapes.push_back(plane);
    description.contact = ContactDescription{.threshold = 0.01};
  }
  Scene& add(const std::string& name, ShapeKind kind, double size, const ContactProperties& surface) {
    BodyDescription body{.name = name};
    body.joint = {.kind = JointKind::free};
    const double I = (kind == ShapeKind::sphere ? 0.4 : 2.0 / 3) * size * size;
    body.inertia = MassProperties{.mass = 1, .Theta = {I, I, I, 0, 0, 0}};
    body.shapes.push_back(touching(kind, surface, size));
    description.bodies.push_back(body);
    return *this;
  }
  Model build() const { return ModelBuilder(description).build(); }
};
inline std::vector<double> at(const Vec3<>& r, double angle = 0) {
  return {0, std::sin(angle / 2), 0, std::cos(angle / 2), r.x, r.y, r.z};
}
inline std::vector<double> last(const Trajectory& motion, bool velocity) {
  const std::size_t k = motion.size() - 1;
  return to_vector(velocity ? motion.v(k) : motion.q(k));
}
inline double energy_at(const Model& model, const Trajectory& motion, std::size_t k) {
  Workspace<> workspace(model, cut_tree);
  return kinetic_energy<double>(model, workspace, motion.q(k), motion.v(k)) +
         potential_energy<double>(model, workspace, motion.q(k));
}

inline constexpr double trunk = 5, leg = 1, foot = 0.05;

/// A trunk on a vertical guide, with a leg below it whose length a controller commands by a motor. The foot
/// is a ball, and the leg has the length 0.5 m + q at the joint "leg".
inline Description hopper() {
  Description d = Scene({.friction = 0.8}).description;
  d.name = "hopper";
  d.bodies = {{.name = "trunk",
               .joint = {.name = "guide", .kind = JointKind::prismatic, .axis = {0, 0, 1}},
               .inertia = MassProperties{.mass = trunk, .com = {}, .Theta = {0.1, 0.1, 0.1, 0, 0, 0}}},
              {.name = "leg",
               .predecessor = "trunk",
               .joint = {.name = "leg", .kind = JointKind::prismatic, .axis = {0, 0, -1}},
               .inertia = MassProperties{.mass = leg, .com = {}, .Theta = {0.1, 0.1, 0.1, 0, 0, 0}}}};
  d.bodies[1].shapes = {touching(ShapeKind::sphere, {.friction = 0.8}, foot)};
  d.bodies[1].shapes[0].pose.r = {0, 0, -0.5};
  d.drives = {{.name = "controller",
               .kind = DriveKind::pid,
               .joints = {{"leg", 1.0}},
               .parameters = {{"kp", 400}, {"ki", 800}, {"kd", 40}, {"filter_time", 0.01}, {"limit", 48}},
               .input = {.values = {0.1}}},
              {.name = "motor",
               .kind = DriveKind::dc_motor,
               .joints = {{"leg", 1.0}},
               .parameters = {{"resistance", 0.5},
                              {"inductance", 2e-4},
                              {"torque_constant", 0.05},
                              {"ratio", 100},
                              {"current_limit", 30}},
               .input = {.from = "controller"}}};
  return d;
}

/// A random tree that floats freely, under gravity, with hard stops at ±0.1 rad of its revolute joints. Other
/// joints have no springs, losses and limits.
inline Model floating_tree_with_stops(Random<double>& random, double restitution) {
  Description description = random_description(
      random,
      {.most_bodies = 6, .couplings = false, .always_mass = true, .one_free_root = true, .springs = 0});
  for (BodyDescription& body : description.bodies) {
    if (body.joint.kind == JointKind::revolute) body.joint.dof.resize(1);
    for (Dof& dof : body.joint.dof) {
      dof = {};
      if (body.joint.kind == JointKind::revolute)
        dof = {.lower = -0.1, .upper = 0.1, .hard_stops = true, .restitution = restitution};
    }
  }
  return ModelBuilder(description).build();
}

}  // namespace axode::test
