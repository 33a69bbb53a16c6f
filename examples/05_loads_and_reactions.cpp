// A tool that pushes against a wall: the wrench that acts on it, the torques that it takes, and the wrenches
// in the bearings.
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

using namespace axode;

int main(int argc, char** argv) {
  const Model model = load(argc > 1 ? argv[1] : AXODE_ROBOTS_DIR "/arm7.toml");
  Workspace<> workspace(model);
  const std::vector<double> q = random_configuration(model, 3), rest(model.nv());

  // The wall pushes back with 50 N along -x and 2 N m about z of the inertial frame, at the last frame.
  const std::vector<AppliedWrench<>> wall{{model.n_frames() - 1, Wrench<Hybrid>{{0, 0, 2}, {-50, 0, 0}}}};

  std::vector<double> free(model.nv()), pushing(model.nv());
  inverse_dynamics(model, workspace, q, rest, rest, free);
  inverse_dynamics(model, workspace, q, rest, rest, pushing, {.wrenches = wall});

  std::vector<Wrench<BodyFixed>> W(model.n_bodies());  // in the frame of each body, about its origin
  joint_wrenches<BodyFixed>(model, workspace, q, rest, rest, W, {.wrenches = wall});

  std::printf("%-12s %9s %9s   force transmitted by the joint, N\n", "joint", "free", "pushing");
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Joint& joint = model.joint(i);
    const Vec3<> f = W[i - 1].f;
    std::printf("%-12s %9.3f %9.3f   (%.2f, %.2f, %.2f)\n", joint.name.c_str(), free[joint.iv],
                pushing[joint.iv], f.x, f.y, f.z);
  }
}
