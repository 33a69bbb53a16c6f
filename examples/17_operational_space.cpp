// The inertia of a tool that a wrench meets, and the velocities of all joints after a blow on the tool.
#include <array>
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

using namespace axode;

int main() {
  const Model arm = load(AXODE_ROBOTS_DIR "/arm7.toml");
  Workspace<> workspace(arm);
  const std::vector<double> q = random_configuration(arm, 3);
  const int tool = arm.frame_index("flange");

  std::array<double, 36> Lambda;  // row by row, angular before linear
  const Solvability outcome = operational_space_inertia<Hybrid>(arm, workspace, q, tool, Lambda);
  if (!outcome.ok()) {
    std::puts(to_string(arm, outcome).c_str());
    return 1;
  }
  std::printf("pushed along x, y, z the tool shows %.2f, %.2f, %.2f kg\n", Lambda[6 * 3 + 3],
              Lambda[6 * 4 + 4], Lambda[6 * 5 + 5]);

  std::vector<Twist<Hybrid>> Y(arm.nv());  // M⁻¹ Jᵀ: Y | impulse = jump of the velocity
  const Solvability solvability = impulse_response<Hybrid>(arm, workspace, q, tool, Y);
  if (!solvability.ok()) return 1;
  const Wrench<Hybrid> blow{{0, 0, 0}, {0, 0, -2}};  // N s: a hammer from above
  for (const Joint& joint : arm.joints())
    std::printf("  %-4s jumps by %7.3f rad/s\n", joint.name.c_str(), blow | Y[joint.iv]);
}
