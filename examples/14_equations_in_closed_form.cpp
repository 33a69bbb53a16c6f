// The paper's equations of motion in matrices of the whole system, which agree with the recursions.
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/dynamics/closed_form/closed_form.hpp"
#include "axode/eigen.hpp"
#include "axode/io.hpp"

using namespace axode;

int main() {
  const Model arm = load(AXODE_ROBOTS_DIR "/arm7.toml");
  Workspace<> workspace(arm);
  const std::vector<double> q = random_configuration(arm, 2), v(arm.nv(), 0.5), a(arm.nv(), -1.0);
  std::vector<double> tau(arm.nv());
  inverse_dynamics(arm, workspace, q, v, a, tau);

  const auto differs = [&](const Eigen::VectorXd& other) {
    return (other - as_eigen(std::span<const double>(tau))).cwiseAbs().maxCoeff();
  };
  std::printf("drive forces in N m, against the recursion:\n");
  std::printf("  Euler-Jourdain, body-fixed  %.1e\n",
              differs(closed_form::projection_equations<BodyFixed>(arm, q, v, a)));
  std::printf("  Euler-Jourdain, hybrid      %.1e\n",
              differs(closed_form::projection_equations<Hybrid>(arm, q, v, a)));
  std::printf("  spatial momentum balance    %.1e\n", differs(closed_form::momentum_balance(arm, q, v, a)));
  std::printf("  Lagrange, M a + C v + g     %.1e\n", differs(closed_form::lagrange_equations(arm, q, v, a)));

  // For some of the matrices C, M' - 2C is skew symmetric, as passivity-based controllers need it; for the
  // paper's C it is not.
  std::vector<double> dM(arm.nv() * arm.nv() * arm.nv());
  mass_matrix_partials(arm, workspace, q, dM);
  Eigen::MatrixXd M_rate = Eigen::MatrixXd::Zero(arm.nv(), arm.nv());
  for (int k = 0; k < arm.nv(); ++k)
    M_rate += v[k] * Eigen::Map<Eigen::MatrixXd>(&dM[k * arm.nv() * arm.nv()], arm.nv(), arm.nv());
  std::printf("largest entry of the symmetric part of M' - 2C, kg m^2/s:\n");
  for (const auto& [name, form] : {std::pair("paper", CoriolisForm::paper),
                                   {"skew", CoriolisForm::skew},
                                   {"christoffel", CoriolisForm::christoffel}}) {
    const Eigen::MatrixXd S = M_rate - 2 * closed_form::coriolis_matrix(arm, q, v, form);
    std::printf("  %-12s %.1e\n", name, (S + S.transpose()).cwiseAbs().maxCoeff());
  }
}
