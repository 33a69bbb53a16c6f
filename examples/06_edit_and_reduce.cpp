// Models never change, but edits make new models: one with a payload in the hand, and one with locked joints.
#include <cstdio>
#include <string_view>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

using namespace axode;

/// The torque that a drive needs to hold a joint at rest at q.
double holding_torque(const Model& model, const char* joint, const std::vector<double>& q) {
  Workspace<> workspace(model);
  const std::vector<double> rest(model.nv());
  std::vector<double> tau(model.nv());
  inverse_dynamics(model, workspace, q, rest, rest, tau);
  return tau[model.joint(model.joint_index(joint)).iv];
}

int main() {
  const Model arm = load(AXODE_ROBOTS_DIR "/arm7.toml");

  ModelBuilder edit(arm);
  edit.add({.name = "payload",
            .predecessor = "link 7",
            .inertia = MassProperties{.mass = 10, .com = {0, 0, 1.4}, .Theta = {.05, .05, .05, 0, 0, 0}}});
  const Model loaded = edit.build();

  const std::vector<double> q{0, 1.2, 0, -0.5, 0, 0.3, 0};
  const std::string_view locked[] = {"A3", "A5", "A6", "A7"};
  const Model planar = reduced(loaded, locked, q);

  std::printf("%-12s %8s %10s %22s\n", "", "joints", "mass, kg", "torque of A2, N m");
  std::printf("%-12s %8d %10.3f %22.3f\n", "arm", arm.nv(), arm.total_mass(), holding_torque(arm, "A2", q));
  std::printf("%-12s %8d %10.3f %22.3f\n", "with load", loaded.nv(), loaded.total_mass(),
              holding_torque(loaded, "A2", q));
  std::printf("%-12s %8d %10.3f %22.3f\n", "and locked", planar.nv(), planar.total_mass(),
              holding_torque(planar, "A2", {q[0], q[1], q[3]}));
}
