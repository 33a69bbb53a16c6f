// A crane from its drawing: axes, points and masses are all given in one frame, with every joint at zero.
// That frame is also the frame of every body, so that the pose of a body is its displacement. A frame "load"
// marks the place of the load.
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"

using namespace axode;

int main() {
  const Model crane =
      ModelBuilder("crane")
          .add({.name = "mast",
                .joint = {.name = "slew", .kind = JointKind::revolute, .axis = {0, 0, 1}},
                .inertia = MassProperties{.mass = 800, .com = {0, 0, 4}, .Theta = {4300, 4300, 40, 0, 0, 0}}})
          .add({.name = "jib",
                .predecessor = "mast",
                .joint =
                    {.name = "luff", .kind = JointKind::revolute, .axis = {0, -1, 0}, .point = {0.4, 0, 8}},
                .inertia = MassProperties{.mass = 300, .com = {5, 0, 8}, .Theta = {5, 2500, 2500, 0, 0, 0}}})
          .add({.name = "trolley",
                .predecessor = "jib",
                .joint = {.name = "travel", .kind = JointKind::prismatic, .axis = {1, 0, 0}},
                .inertia = MassProperties{.mass = 60, .com = {2, 0, 7.8}, .Theta = {2, 2, 2, 0, 0, 0}}})
          .add({.name = "load", .body = "trolley", .pose = {{}, {2, 0, 7}}})
          .build();

  Workspace<> workspace(crane);
  const std::vector<double> q{0.5, 0.3, 4}, rest(3);  // rad, rad, m
  std::vector<SE3<>> C(crane.n_frames());
  std::vector<double> tau(crane.nv());
  poses(crane, workspace, q, C);
  inverse_dynamics(crane, workspace, q, rest, rest, tau);

  const Vec3<> r = C[crane.frame_index("load")].r;
  std::printf("load at (%.3f, %.3f, %.3f) m\n", r.x, r.y, r.z);
  std::printf("to hold it: slew %.1f N m, luff %.1f N m, travel %.1f N\n", tau[0], tau[1], tau[2]);
}
