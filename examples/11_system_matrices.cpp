// The Jacobian of the whole system as a product of sparse matrices, and joint velocities computed from the
// twists of the bodies.
#include "axode/kinematics/system_matrices.hpp"

#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

using namespace axode;

int main(int argc, char** argv) {
  const Model robot = load(argc > 1 ? argv[1] : AXODE_ROBOTS_DIR "/humanoid.urdf");
  const std::vector<double> q = random_configuration(robot, 5), v(robot.nv(), 0.2), a(robot.nv(), -0.1);

  const SystemMatrices system = system_matrices<BodyFixed>(robot, q);  // V = A X v and (I - D) A = I
  const auto print = [](const char* name, const SystemMatrix& M) {
    std::printf("%s is %3d x %3d, %5.1f %% of it not zero\n", name, static_cast<int>(M.rows()),
                static_cast<int>(M.cols()),
                100.0 * static_cast<double>(M.nonZeros()) / static_cast<double>(M.size()));
  };
  print("A", system.A), print("D", system.D), print("X", system.X);

  const Eigen::VectorXd V = system_twist(robot, q, v), dV = system_acceleration(robot, q, v, a);
  const Eigen::VectorXd v_again = joint_velocities(robot, q, V),
                        a_again = joint_accelerations(robot, q, V, dV);
  std::printf("from the twists of %d bodies and their rates: v = (%.3f %.3f ...), a = (%.3f %.3f ...)\n",
              robot.n_bodies(), v_again[0], v_again[1], a_again[0], a_again[1]);
}
