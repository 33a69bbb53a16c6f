// Small motions about an equilibrium: the configuration in which a double pendulum rests, its natural
// frequencies, and the motion that the linear system predicts.
#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "axode/axode.hpp"
#include "axode/eigen.hpp"
#include "axode/io.hpp"

using namespace axode;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

int main() {
  const Model model = load(AXODE_ROBOTS_DIR "/double_pendulum.toml");
  const int nv = model.nv();
  Workspace<> workspace(model);
  const std::vector<double> rest(nv);
  Matrix A(2 * nv, 2 * nv), B(2 * nv, nv);

  for (const std::vector<double>& guess : {std::vector{0.3, -0.2}, std::vector{3.0, 0.1}}) {
    const EquilibriumResult found = equilibrium(model, guess);
    const Solvability status = linearize(model, workspace, found.q, rest, rest, {as_span(A), as_span(B)});
    if (found.status != EquilibriumStatus::solved || !status.ok()) return 1;
    std::printf("at rest with the upper rod at %.4f rad, found in %d steps:\n", std::abs(found.q[0]),
                found.iterations);
    const Eigen::VectorXcd eigenvalues = A.eigenvalues();
    for (const std::complex<double>& lambda : eigenvalues)
      if (lambda.imag() > 0) {
        std::printf("  swings at %.4f Hz\n", std::abs(lambda) / (2 * std::numbers::pi));
      } else if (lambda.imag() == 0) {
        std::printf("  %s in %.4f s\n", lambda.real() > 0 ? "grows by e" : "dies out",
                    1 / std::abs(lambda.real()));
      }
  }

  // About the upright position, x' = A x and the accelerations
  // of forward dynamics agree to second order in x.
  std::printf("error of A x for a displacement of 0.1, 0.01, 0.001 rad:");
  const std::vector<double> upright{std::numbers::pi, 0};
  if (!linearize(model, workspace, upright, rest, rest, {as_span(A), as_span(B)}).ok()) return 1;
  for (const double size : {0.1, 0.01, 0.001}) {
    const Eigen::Vector4d x(size, -size, 0, 0);
    const std::vector<double> q = integrate(model, upright, as_span(x).first(2));
    Eigen::VectorXd a(nv);
    if (!forward_dynamics(model, workspace, q, rest, rest, as_span(a)).ok()) return 1;
    std::printf(" %.0e", ((A * x).tail(nv) - a).norm() / a.norm());
  }
  std::printf("\n");
}
