// The drive torques that a robot needs for a motion: load a file, give q, v and a, and read tau.
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

int main(int argc, char** argv) {
  const axode::Model model = axode::load(argc > 1 ? argv[1] : AXODE_ROBOTS_DIR "/arm7.toml");
  axode::Workspace<> workspace(model);

  const std::vector<double> q = axode::random_configuration(model, 1);  // within the limits of the joints
  const std::vector<double> v(model.nv(), 0.5), a(model.nv(), 1.0);
  std::vector<double> tau(model.nv());
  axode::inverse_dynamics(model, workspace, q, v, a, tau);

  std::printf("%s, %d bodies, %.3f kg\n", model.name().c_str(), model.n_bodies(), model.total_mass());
  for (const axode::Joint& joint : model.joints())
    for (int k = joint.iv; k < joint.iv + joint.nv; ++k)
      std::printf("  %-12s tau[%d] = %9.4f\n", joint.name.c_str(), k, tau[k]);
}
