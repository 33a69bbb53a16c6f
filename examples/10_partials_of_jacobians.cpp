// The change of a Jacobian with the configuration: all partial derivatives, or the derivative along one
// direction without them.
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

using namespace axode;

void print(const char* what, const Twist<BodyFixed>& X) {
  std::printf("%s (%8.4f %8.4f %8.4f; %8.4f %8.4f %8.4f)\n", what, X.w.x, X.w.y, X.w.z, X.v.x, X.v.y, X.v.z);
}

int main() {
  const Model arm = load(AXODE_ROBOTS_DIR "/arm7.toml");
  Workspace<> workspace(arm);
  const std::vector<double> q = random_configuration(arm, 3);
  const int tool = arm.frame_index("flange"), n = arm.nv(), A2 = 1, A5 = 4;

  std::vector<Twist<BodyFixed>> J(n), dJ(n * n);
  jacobian(arm, workspace, q, tool, J);
  jacobian_partials(arm, workspace, q, tool, 1,
                    dJ);  // dJ[k n + j] = ∂J_j/∂q_k = [J_j, J_k] for j < k, else 0
  print("the screw of A2 when A5 turns", dJ[A5 * n + A2]);
  print("the same as a screw product  ", ad(J[A2], J[A5]));
  print("the screw of A5 when A2 turns", dJ[A2 * n + A5]);

  // The second derivative of all screws along q + t u. The tensor, which has 343 columns, is never computed.
  const std::vector<double> u(n, 0.1);
  std::vector<double> twice_u(u);
  twice_u.insert(twice_u.end(), u.begin(), u.end());
  std::vector<Twist<BodyFixed>> ddJ(n);
  jacobian_derivative_along(arm, workspace, q, tool, 2, twice_u, ddJ);
  print("A2's second derivative on u  ", ddJ[A2]);
}
