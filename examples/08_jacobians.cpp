// The Jacobian of a tool: its velocity for a unit velocity of each joint, and the direction in which it moves
// worst.
#include <Eigen/SVD>
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/eigen.hpp"
#include "axode/io.hpp"

using namespace axode;

int main(int argc, char** argv) {
  const Model arm = load(argc > 1 ? argv[1] : AXODE_ROBOTS_DIR "/arm7.toml");
  Workspace<> workspace(arm);
  const std::vector<double> q = random_configuration(arm, 7);
  const int tool = arm.n_frames() - 1;

  std::vector<Twist<Hybrid>> J(
      arm.nv());  // hybrid: inertial axes, velocity of the origin of the tool's frame
  jacobian<Hybrid>(arm, workspace, q, tool, J);
  std::printf("hybrid Jacobian of %s\n  %-6s %26s   %s\n", arm.frame(tool).name.c_str(), "", "angular, rad/s",
              "linear, m/s");
  for (const Joint& joint : arm.joints())
    for (int c = joint.iv; c < joint.iv + joint.nv; ++c)
      std::printf("  %-6s (%8.3f %8.3f %8.3f)  (%8.3f %8.3f %8.3f)\n", joint.name.c_str(), J[c].w.x, J[c].w.y,
                  J[c].w.z, J[c].v.x, J[c].v.y, J[c].v.z);

  Eigen::MatrixXd linear(3, arm.nv());
  for (int c = 0; c < arm.nv(); ++c) linear.col(c) = to_eigen(J[c].v);
  const Eigen::Vector3d s = linear.jacobiSvd().singularValues();
  std::printf("the joints move it at %.3f m/s in its best direction and at %.3f m/s in its worst\n", s[0],
              s[2]);

  // The Jacobian of a point 10 cm ahead of the tool's frame, seen by an observer on the first link.
  relative_jacobian<Hybrid>(arm, workspace, q, {tool, Vec3<>{0, 0, 0.1}}, 1, J);
  std::printf("seen from %s, joint %s moves that point at %.3f m/s and joint %s at %.3f m/s\n",
              arm.body(1).name.c_str(), arm.joint(1).name.c_str(), norm(J[0].v), arm.joint(2).name.c_str(),
              norm(J[1].v));

  std::vector<Vec3<>> J_com(arm.nv());
  center_of_mass_jacobian(arm, workspace, q, J_com);
  std::printf("joint %s lifts the centre of mass by %.3f m/rad\n", arm.joint(2).name.c_str(), J_com[1].z);
}
