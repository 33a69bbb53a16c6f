#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "tests/model/random_mechanism.hpp"

/// Mechanisms of many bodies, in a row or all on one body.
namespace axode::test::large {

/// Names of the same length, so that the work for a name does not depend on its number.
inline std::string named(char letter, int i) { return numbered(letter, 10'000 + i); }

/// A tree of n bodies. The predecessor of body i is the earlier body predecessor_of(i), or the ground if that
/// is negative.
inline Description tree(int n, const std::function<int(int)>& predecessor_of) {
  Description description{.name = "large"};
  for (int i = 0; i < n; ++i) {
    const int p = predecessor_of(i);
    description.bodies.push_back({.name = named('b', i),
                                  .predecessor = p < 0 ? "ground" : named('b', p),
                                  .joint = {.name = named('j', i),
                                            .kind = one_dof_kinds[static_cast<std::size_t>(i) % 2],
                                            .axis = {0.3, 1, 0},
                                            .point = {0.001 * i, 0, 0}},
                                  .geometry = InConstructionFrame{{{}, {0.001 * i, 0, 0}}},
                                  .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1, 0, 0, 0}}});
  }
  return description;
}
inline Description chain(int n) {
  return tree(n, [](int i) { return i - 1; });
}
inline Description backward_chain(int n) {  // its bodies are declared from the tip to the root
  Description description = chain(n);
  std::ranges::reverse(description.bodies);
  return description;
}
inline Description star(int n) {
  return tree(n, [](int i) { return i == 0 ? -1 : 0; });
}
inline Description forest(int n) {
  return tree(n, [](int) { return -1; });
}
inline Description fixed_chain(int n) {
  Description description = chain(n);
  for (BodyDescription& body : description.bodies)
    if (body.name != named('b', 0)) body.joint.kind = JointKind::fixed;
  return description;
}
inline Description chain_of_split_joints(int n) {
  Description description = chain(n);
  for (BodyDescription& body : description.bodies) body.joint.kind = JointKind::cylindrical;
  return description;
}
inline Description couplings_on_one_joint(int n) {
  Description description = star(n);
  for (BodyDescription& body : description.bodies)
    if (body.name != named('b', 0)) body.joint.coupling = Coupling{named('j', 0)};
  return description;
}
inline Description chain_of_couplings(int n) {  // each joint follows the next one, which is declared after it
  Description description = star(n);
  for (int i = 0; i + 1 < n; ++i) description.bodies[i].joint.coupling = Coupling{named('j', i + 1)};
  return description;
}
inline Description coupled_chain(int n) {  // the same for bodies in a row
  Description description = chain(n);
  for (int i = 0; i + 1 < n; ++i) description.bodies[i].joint.coupling = Coupling{named('j', i + 1)};
  return description;
}
inline Description many_frames(int n) {
  Description description = chain(10);
  for (int k = 0; k < n; ++k) description.frames.push_back({.name = named('f', k), .body = named('b', 9)});
  return description;
}
/// A spring on a line and one on a coordinate for every body.
inline Description springs_on_every_body(int n) {
  Description description = forest(n);
  for (int k = 0; k < n; ++k) {
    description.springs.push_back({.between = {"ground", named('b', k)}, .stiffness = 1, .rest = 1});
    SpringDescription turn{.kind = SpringKind::joints, .stiffness = 1};
    turn.terms = {{named('j', k), 1.0}};
    description.springs.push_back(turn);
  }
  return description;
}
/// A controller on every body but the first, whose input is the output of the next one.
inline Description chain_of_drives(int n) {
  Description description = forest(n);
  for (int k = 1; k < n; ++k) {
    DriveDescription drive{.name = named('d', k), .kind = DriveKind::pid};
    drive.joints = {{named('j', k), 1.0}};
    drive.parameters = {{"kp", 1.0}};
    if (k + 1 < n)
      drive.input.from = named('d', k + 1);
    else
      drive.input.values = {0};
    description.drives.push_back(std::move(drive));
  }
  return description;
}

/// A rod from every body to the ground, and pairs of joints that are coupled without a leader.
inline Description loops_on_every_body(int n) {
  Description description = forest(n);
  for (int k = 0; k < n; ++k) {
    description.loops.push_back({.between = {"ground", named('b', k)}, .kind = LoopKind::rod, .length = 1});
    if (k % 2 == 0 && k + 1 < n)
      description.couplings.push_back({.terms = {{named('j', k), 1.0}, {named('j', k + 1), 2.0}}});
  }
  return description;
}
inline Description motion_of_every_joint(int n) {
  Description description = forest(n);
  for (int k = 0; k < n; ++k) description.motions.push_back({.of = named('j', k), .coefficients = {0, 1}});
  return description;
}
inline Description shapes_on_every_body(int n) {
  Description description = chain(n);
  for (BodyDescription& body : description.bodies)
    for (const auto role : {ShapeDescription::Role::visual, ShapeDescription::Role::collision})
      body.shapes.push_back({.role = role, .name = "shape of " + body.name, .size = {1, 2, 3}});
  return description;
}

inline Description nothing_but_faults(int n) {
  Description description = chain(n);
  for (BodyDescription& body : description.bodies) {
    body.predecessor = "x" + body.name;
    body.inertia->mass = -1;
    body.joint.coupling = Coupling{"k" + body.name};
  }
  return description;
}
inline Description ring_of_couplings(int n) {
  Description description = star(n);
  for (int i = 0; i < n; ++i) description.bodies[i].joint.coupling = Coupling{named('j', (i + 1) % n)};
  return description;
}
inline Description ring(int n) {
  Description description = chain(n);
  description.bodies[0].predecessor = named('b', n - 1);
  return description;
}
inline Description ring_of_drives(int n) {
  Description description = chain_of_drives(n);
  description.drives.back().input.values.clear();
  description.drives.back().input.from = named('d', 1);
  return description;
}

struct Mechanism {
  const char* name;
  Description (*make)(int n);
  std::vector<Rule> faults_of_each = {};  ///< the faults that each body has, or each drive if there are any
  std::vector<Rule> faults_of_all = {};
};
inline const std::vector<Mechanism> mechanisms{
    {"chain", chain},
    {"backward_chain", backward_chain},
    {"star", star},
    {"forest", forest},
    {"fixed_chain", fixed_chain},
    {"chain_of_split_joints", chain_of_split_joints},
    {"couplings_on_one_joint", couplings_on_one_joint},
    {"chain_of_couplings", chain_of_couplings},
    {"coupled_chain", coupled_chain},
    {"many_frames", many_frames},
    {"loops_on_every_body", loops_on_every_body},
    {"motion_of_every_joint", motion_of_every_joint},
    {"shapes_on_every_body", shapes_on_every_body},
    {"springs_on_every_body", springs_on_every_body},
    {"chain_of_drives", chain_of_drives},
};
inline const std::vector<Mechanism> faulty_mechanisms{
    {"nothing_but_faults",
     nothing_but_faults,
     {Rule::unknown_predecessor, Rule::mass_not_positive, Rule::coupling_unknown_joint}},
    {"ring", ring, {}, {Rule::cycle}},
    {"ring_of_couplings", ring_of_couplings, {Rule::coupling_loop}},
    {"ring_of_drives", ring_of_drives, {Rule::cycle}},
};
inline std::string name_of(const testing::TestParamInfo<Mechanism>& info) { return info.param.name; }

}  // namespace axode::test::large
