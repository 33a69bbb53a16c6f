#pragma once
#include <cmath>
#include <limits>
#include <span>

#include "axode/constraints/assembly.hpp"
#include "axode/dynamics.hpp"
#include "axode/integration.hpp"
#include "axode/model/configuration.hpp"
#include "tests/laws/law.hpp"

/// The mechanisms and the comparisons of the tests of motions.
namespace axode::test {

using Numbers = std::vector<double>;
using Span = std::span<const double>;

/// A random tree and a state of it.
struct Mover {
  Model model;
  State<double> state;

  explicit Mover(std::uint64_t seed)
      : model([&] {
          Random<double> random(seed);
          return ModelBuilder(
                     described(random_mechanism(random, {.most_bodies = 6, .always_mass = true}), random))
              .build();
        }()) {
    Random<double> random(seed + 1);
    state = random_state(model, random);
    state.wrenches.clear();
  }
};

inline double apart(const Model& model, Span q0, Span q1) {
  double sum = 0;
  for (const double x : difference(model, q0, q1)) sum += x * x;
  return std::sqrt(sum);
}
inline double energy_of(const Model& model, Span q, Span v) {
  Workspace<> workspace(model);
  return kinetic_energy(model, workspace, q, v) + potential_energy(model, workspace, q);
}
/// The largest change of the energy up to a time.
inline double energy_error(const Trajectory& motion, double until = std::numeric_limits<double>::infinity()) {
  const double before = energy_of(motion.model(), motion.q(0), motion.v(0));
  double most = 0;
  for (std::size_t k = 0; k < motion.size() && motion.t()[k] <= until; ++k)
    most = std::max(most, std::abs(energy_of(motion.model(), motion.q(k), motion.v(k)) - before));
  return most;
}
inline Span last_q(const Trajectory& motion) { return motion.q(motion.size() - 1); }
inline Span last_v(const Trajectory& motion) { return motion.v(motion.size() - 1); }

/// Expects that a symmetric scheme returns to its initial state if all velocities are reversed at the end.
template <class Run>
void expect_way_back(const Model& model, const Numbers& q, const Numbers& v, double bound, double away,
                     const Run& run) {
  const Trajectory there = run(Span(q), Span(v));
  Numbers turned(last_v(there).begin(), last_v(there).end());
  for (double& v_c : turned) v_c = -v_c;
  EXPECT_LE(apart(model, q, last_q(run(last_q(there), Span(turned)))), bound);
  EXPECT_GT(apart(model, q, last_q(there)), away);
}

inline constexpr LocalCoordinates both_local_coordinates[]{LocalCoordinates::exponential,
                                                           LocalCoordinates::cayley};
/// Options with these local coordinates of steps.
inline SimulationOptions with(LocalCoordinates coordinates, SimulationOptions options = {}) {
  options.local_coordinates = coordinates;
  return options;
}

/// A mechanism with loops in motion.
struct Closed {
  Model model;
  AssemblyResult at;

  explicit Closed(const Description& description)
      : model(ModelBuilder(description).build()), at([&] {
          Random<double> random(3);
          return assemble(model, neutral(model), random_numbers(random, model.nv()));
        }()) {}
};

/// Two links of 1 m and 10 kg with hinges about y.
inline Description two_links() {
  Description arm{.name = "arm"};
  for (int k = 0; k < 2; ++k) {
    BodyDescription body{.name = k == 0 ? "upper" : "fore", .predecessor = k == 0 ? "ground" : "upper"};
    body.joint = {.name = k == 0 ? "shoulder" : "elbow",
                  .kind = JointKind::revolute,
                  .axis = {0, 1, 0},
                  .point = {static_cast<double>(k), 0, 0}};
    body.inertia = MassProperties{.mass = 10, .com = {0.5 + k, 0, 0}, .Theta = {1, 1, 1}};
    arm.bodies.push_back(std::move(body));
  }
  return arm;
}

/// A model with a spherical, a free and a planar joint and a hinge; none of its configurations is singular.
inline Model test_tree(Vec3<> gravity = {0, 0, -9.81}) {
  Description tree{.name = "tree", .gravity = gravity};
  const auto add = [&](const char* name, const char* on, JointKind kind, Vec3<> point) {
    BodyDescription body{.name = name, .predecessor = on};
    body.joint = {.name = std::string(name) + " joint", .kind = kind};
    if (kind == JointKind::revolute || kind == JointKind::planar) body.joint.axis = {0.6, 0, 0.8};
    body.joint.point = point;
    body.inertia =
        MassProperties{.mass = 1.3, .com = {0.1, 0.2, -0.1}, .Theta = {0.5, 0.7, 0.6, 0.02, 0.01, 0.03}};
    tree.bodies.push_back(std::move(body));
  };
  add("base", "ground", JointKind::free, {});
  add("ball", "base", JointKind::spherical, {0.4, 0, 0});
  add("plate", "base", JointKind::planar, {0, 0.5, 0});
  add("door", "ball", JointKind::revolute, {0.7, 0.1, 0});
  return ModelBuilder(tree).build();
}
inline State<double> test_state(const Model& model) {
  Random<double> random(7);
  State<double> state = random_state(model, random);
  state.wrenches.clear();
  return state;
}
/// Options with drives that depend on time and take energy away.
inline SimulationOptions driven_and_damped() {
  SimulationOptions options;
  options.drive = [](double t, Span, Span v, std::span<double> tau) {
    for (std::size_t c = 0; c < tau.size(); ++c)
      tau[c] = std::sin(3 * t + static_cast<double>(c)) - 0.3 * v[c];
  };
  return options;
}

}  // namespace axode::test
