// Derivatives with respect to anything: inverse dynamics of an arm with dual numbers, which carry derivatives
// along three directions. These are a coordinate, a velocity, and the mass of a tool, for which the library
// has no function of its own.
#include <cmath>
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/dynamics/generic_dynamics.hpp"
#include "axode/io.hpp"
#include "axode/scalar/dual.hpp"

using namespace axode;
using D = Dual<double, 3>;

int main() {
  const Model arm = load(AXODE_ROBOTS_DIR "/arm7.toml");
  const std::size_t nv = static_cast<std::size_t>(arm.nv());
  const int elbow = arm.joint(arm.joint_index("A4")).iv, tool = arm.n_bodies();

  const Tree<D> numbers = cast<D>(arm.tree<double>());
  TreeNumbers<D> parameters = numbers;
  parameters.M[tool].m.dx[2] = 1;  // a point mass at the origin of the last body's joint frame
  GenericDynamics<D> dynamics(arm, Tree<D>(numbers.topology(), parameters));

  // q moved along its left-trivialised directions: the way that holds for spherical and free joints, too.
  std::vector<D> q(nv, D(0.3)), dq(nv), v(nv, D(0.5)), a(nv, D(1)), moved(nv), tau(nv);
  dq[elbow].dx[0] = 1, v[elbow].dx[1] = 1;
  dynamics.integrate(q, dq, moved);
  dynamics.inverse_dynamics(moved, v, a, tau);

  // The first two are columns of the analytic derivatives.
  Workspace<> workspace(arm);
  const std::vector<double> q0(nv, 0.3), v0(nv, 0.5), a0(nv, 1);
  std::vector<double> by_q(nv * nv), by_v(nv * nv), by_a(nv * nv);
  inverse_dynamics_derivatives(arm, workspace, q0, v0, a0, {by_q, by_v, by_a});
  double off = 0;
  std::printf("joint   N m       by A4      by A4'      by mass\n");
  for (std::size_t c = 0; c < nv; ++c) {
    std::printf("A%zu %10.4f %10.4f %10.4f %10.4f\n", c + 1, tau[c].x, tau[c].dx[0], tau[c].dx[1],
                tau[c].dx[2]);
    off = std::max(
        {off, std::abs(tau[c].dx[0] - by_q[c * nv + elbow]), std::abs(tau[c].dx[1] - by_v[c * nv + elbow])});
  }
  std::printf("off the analytic derivatives by %.0e\n", off);
  return off < 1e-12 ? 0 : 1;
}
