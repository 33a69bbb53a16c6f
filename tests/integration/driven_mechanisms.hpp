#pragma once
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "axode/drives.hpp"
#include "axode/model/kinds/joint_kinds.hpp"
#include "tests/integration/motions.hpp"

/// Mechanisms with drives that have states.
namespace axode::test {

inline DriveDescription random_drive(Random<double>& random, DriveKind kind) {
  DriveDescription drive{.kind = kind};
  const auto between = [&](double low, double high) { return random.number(low, high); };
  switch (kind) {
    case DriveKind::dc_motor:
      drive.parameters = {{"resistance", between(0.5, 2)},
                          {"inductance", between(0.05, 0.2)},
                          {"torque_constant", between(0.1, 0.5)},
                          {"viscous", between(0, 0.1)},
                          {"ratio", between(1, 3)},
                          {"voltage_limit", between(2, 4)},
                          {"current_limit", between(1, 2)},
                          {"heat_capacity", between(5, 10)},
                          {"thermal_resistance", 2},
                          {"temperature_coefficient", 0.004}};
      break;
    case DriveKind::pid:
      drive.parameters = {{"kp", between(1, 3)},
                          {"ki", between(0, 2)},
                          {"kd", between(0, 0.2)},
                          {"filter_time", 0.1},
                          {"limit", between(1, 2)}};
      break;
    case DriveKind::series_elastic:
      drive.parameters = {{"resistance", between(0.5, 2)},
                          {"inductance", between(0.05, 0.2)},
                          {"torque_constant", between(0.1, 0.5)},
                          {"ratio", between(1, 3)},
                          {"rotor_inertia", between(0.1, 0.2)},
                          {"stiffness", between(5, 10)},
                          {"damping", between(0, 0.5)}};
      break;
    case DriveKind::lugre:
      drive.parameters = {{"bristle_stiffness", between(10, 20)},
                          {"bristle_damping", between(0, 1)},
                          {"viscous", between(0, 0.2)},
                          {"coulomb", 0.5},
                          {"stiction", between(0.5, 1)},
                          {"stribeck_velocity", 0.2},
                          {"damping_velocity", 0.4}};
      break;
    case DriveKind::hydraulic_cylinder:
      drive.parameters = {{"closed_length", between(-0.2, 0.2)},
                          {"stroke", between(0.3, 0.6)},
                          {"area_a", 2e-3},
                          {"area_b", 1.2e-3},
                          {"dead_volume_a", 0.05},
                          {"dead_volume_b", 0.05},
                          {"bulk_modulus", 1e6},
                          {"internal_leakage", 1e-10},
                          {"external_leakage", 1e-10},
                          {"valve", 1e-6},
                          {"smooth_pressure", 100},
                          {"supply_pressure", 1e4},
                          {"tank_pressure", 10},
                          {"valve_time", 0.05},
                          {"viscous", between(0, 1)},
                          {"cushion_stiffness", between(10, 20)},
                          {"cushion_damping", between(0, 1)}};
      break;
  }
  if (traits(kind).has_input) {
    drive.input.function.emplace().kind = MotionDescription::Kind::harmonic;
    drive.input.function->amplitude = kind == DriveKind::hydraulic_cylinder ? 0.8 : between(1, 5);
    drive.input.function->frequency = between(0.5, 2);
  }
  return drive;
}

/// A random tree with a drive of each kind, on one or two joints or along a line, and a motor that a
/// controller feeds.
struct Driven {
  Model model;
  Numbers q, v, x;
  DriveSystem drives;

  explicit Driven(std::uint64_t seed)
      : model([&] {
          Random<double> random(seed);
          Description d =
              described(random_mechanism(random, {.most_bodies = 5, .always_mass = true}), random);
          const Description expanded = expand(d);
          std::vector<std::string> joints;
          for (const BodyDescription& body : expanded.bodies)
            if (can_couple(body.joint.kind)) joints.push_back(body.joint.name);
          const auto any = [&](auto& all) -> auto& {
            return all[static_cast<std::size_t>(random.number(0, 0.999) * static_cast<double>(all.size()))];
          };
          for (const DriveTraits& kind : drive_kinds) {
            DriveDescription drive = random_drive(random, kind.kind);
            drive.name = std::string(kind.name);
            if (joints.empty() || random.number(0, 1) < 0.5) {
              drive.line = DriveDescription::Line{.between = {any(d.bodies).name, "ground"}};
              drive.line->points = {Vec3<>{random.number(-1, 1), 0.3, 0}, {1, random.number(-1, 1), 0.5}};
            } else {
              drive.joints = {{any(joints), random.number(0.5, 1)}};
              if (const std::string other = any(joints); other != drive.joints[0].first)
                drive.joints.emplace_back(other, random.number(-1, -0.5));
            }
            d.drives.push_back(drive);
          }
          DriveDescription fed = random_drive(random, DriveKind::dc_motor);
          fed.name = "fed";
          fed.joints = d.drives[0].joints;
          fed.line = d.drives[0].line;
          fed.input = {.from = "pid"};
          d.drives.push_back(fed);
          return ModelBuilder(d).build();
        }()),
        drives(model) {
    Random<double> random(seed + 1);
    q = integrate(model, random_configuration(model, seed), random_numbers(random, model.nv(), 0.5));
    v = random_numbers(random, model.nv(), 0.5);
    x.resize(drives.nx());
    drives.start(0.1, q, v, x);
    for (std::size_t k = 0; k < x.size(); ++k) {
      const double size = drives.states()[k].unit == "Pa"    ? 2e3
                          : drives.states()[k].unit == "rad" ? 0.02
                                                             : 0.5;
      x[k] += size * random.number(-1, 1);
    }
    drives.set_state(0.1, q, v, x);
  }
  std::size_t nv() const { return v.size(); }
};

inline double spring_energy(const Model& model, Span q) {
  Workspace<> workspace(model);
  return model.springs().empty() ? 0 : elastic_energy(model, workspace, q);
}

/// A pendulum that a controller holds by a motor.
inline Description controlled_pendulum() {
  Description d{.name = "pendulum"};
  d.bodies = {
      {.name = "rod",
       .joint = {.name = "hinge", .kind = JointKind::revolute, .axis = {0, 1, 0}},
       .inertia = MassProperties{.mass = 1, .com = {0.3, 0, 0}, .Theta = {0.01, 0.02, 0.02, 0, 0, 0}}}};
  d.drives = {
      {.name = "controller",
       .kind = DriveKind::pid,
       .joints = {{"hinge", 1.0}},
       .parameters = {{"kp", 40}, {"ki", 20}, {"kd", 4}, {"filter_time", 0.02}, {"limit", 40}},
       .input = {.values = {0.5}}},
      {.name = "motor",
       .kind = DriveKind::dc_motor,
       .joints = {{"hinge", 1.0}},
       .parameters = {{"resistance", 1}, {"inductance", 0.01}, {"torque_constant", 0.2}, {"ratio", 5}},
       .input = {.from = "controller"}}};
  return d;
}

/// A motor that turns a joint of the mechanism through its limits of voltage and current.
inline DriveDescription motor_on(const std::string& joint) {
  DriveDescription motor{.name = "motor", .joints = {{joint, 1.0}}};
  motor.parameters = {{"resistance", 1},
                      {"inductance", 0.02},
                      {"torque_constant", 0.5},
                      {"voltage_limit", 10},
                      {"current_limit", 3}};
  motor.input.function.emplace().kind = MotionDescription::Kind::harmonic;
  motor.input.function->amplitude = 14;
  motor.input.function->frequency = 3;
  return motor;
}

/// A motor that its load drives, at -40 rad/s, above the speed at which the amplifier can hold the current.
inline Description limited_motor() {
  Description d{.name = "wheel", .gravity = {}};
  d.bodies = {{.name = "wheel",
               .joint = {.name = "hinge", .kind = JointKind::revolute},
               .inertia = MassProperties{.mass = 1, .com = {}, .Theta = {1, 1, 0.05, 0, 0, 0}}}};
  d.drives = {{.name = "motor",
               .joints = {{"hinge", 1.0}},
               .parameters = {{"resistance", 1},
                              {"inductance", 0.05},
                              {"torque_constant", 0.5},
                              {"voltage_limit", 10},
                              {"current_limit", 4}},
               .input = {.values = {30}}}};
  return d;
}

/// The largest differences of a motion at its end to an accurate one: of q, v and x.
inline double error_at_end(const Trajectory& motion, const Trajectory& exact) {
  double most = std::max(std::abs(last_q(motion)[0] - last_q(exact)[0]),
                         std::abs(last_v(motion)[0] - last_v(exact)[0]));
  for (std::size_t k = 0; k < motion.nx(); ++k)
    most = std::max(most, std::abs(motion.x(motion.size() - 1)[k] - exact.x(exact.size() - 1)[k]));
  return most;
}

/// The difference of a motion at its end to an accurate one, of q along the group, v, and x as a part of its
/// nominal values.
inline double deviation_at_end(const Trajectory& motion, const Trajectory& exact) {
  double most = apart(motion.model(), last_q(exact), last_q(motion));
  for (std::size_t c = 0; c < last_v(motion).size(); ++c)
    most = std::max(most, std::abs(last_v(motion)[c] - last_v(exact)[c]));
  const DriveSystem drives(motion.model());
  for (std::size_t k = 0; k < motion.nx(); ++k)
    most = std::max(most, std::abs(motion.x(motion.size() - 1)[k] - exact.x(exact.size() - 1)[k]) /
                              drives.states()[k].nominal);
  return most;
}

/// The mechanism without springs and stops, whose forces have kinks. Only its drives have.
inline Model without_springs(const Model& model) {
  Description d = model.description();
  d.springs.clear();
  for (BodyDescription& body : d.bodies)
    for (Dof& dof : body.joint.dof) dof.stop_stiffness = dof.stop_damping = dof.stiffness = 0;
  return ModelBuilder(d).build();
}

/// A random mechanism with drives and without springs, and its accurate motion.
struct DrivenMotion : Driven {
  DrivenMotion(std::uint64_t seed, double until)
      : Driven(seed), smooth(without_springs(Driven::model)), exact(smooth) {
    options.x = x;
    exact = simulate(smooth, q, v, until, {.relative = 1e-12, .absolute = 1e-13}, options);
    EXPECT_TRUE(exact.complete) << exact.stop_reason;
  }

  Model smooth;
  SimulationOptions options;
  Trajectory exact;
};

}  // namespace axode::test
