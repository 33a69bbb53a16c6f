// A robot whose drives are switched off: the accelerations from the forces, and the mass matrix.
#include <Eigen/Eigenvalues>
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/eigen.hpp"
#include "axode/io.hpp"

using namespace axode;

int main(int argc, char** argv) {
  const Model arm = load(argc > 1 ? argv[1] : AXODE_ROBOTS_DIR "/arm7.toml");
  Workspace<> workspace(arm);
  const std::vector<double> q = random_configuration(arm, 5), v(arm.nv(), 0.3), no_drive(arm.nv());

  std::vector<double> a(arm.nv());
  const Solvability fall = forward_dynamics(arm, workspace, q, v, no_drive, a);
  if (!fall.ok()) {
    std::printf("%s\n", to_string(arm, fall).c_str());
    return 1;
  }
  std::vector<double> tau(arm.nv());  // inverse dynamics gives the forces of the drives back
  inverse_dynamics(arm, workspace, q, v, a, tau);

  std::printf("%-6s %14s %22s\n", "joint", "falls, rad/s^2", "takes from its drive, N m");
  for (const Joint& joint : arm.joints())
    for (int c = joint.iv; c < joint.iv + joint.nv; ++c)
      std::printf("%-6s %14.4f %22.1e\n", joint.name.c_str(), a[c], tau[c]);

  Eigen::MatrixXd M(arm.nv(), arm.nv());  // it is symmetric, so that rows and columns may be exchanged
  mass_matrix(arm, workspace, q, as_span(M));
  const Eigen::VectorXd inertias = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(M).eigenvalues();
  std::printf("the lightest combination of joints has %.2e kg m^2, the heaviest %.2f kg m^2\n", inertias[0],
              inertias[inertias.size() - 1]);
}
