#include "axode/constraints/higher_order/constrained_rates.hpp"

#include <algorithm>

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/embedding/row_elimination.hpp"
#include "axode/constraints/higher_order/loop_series.hpp"
#include "axode/constraints/stable_norm.hpp"
#include "axode/derivatives/displacement/force_series.hpp"
#include "axode/dynamics/mass_matrix/mass_matrix.hpp"
#include "axode/eigen.hpp"
#include "axode/model/finite.hpp"
#include "axode/recursion/least_squares.hpp"

namespace axode {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

/// Checks that a motion keeps the loops closed. Throws std::invalid_argument, with the order and the name of
/// the loop, if a time derivative of A v along the motion is not 0, where A is the Jacobian of the loop
/// equations.
void check_motion(const Model& model, const LoopSeries& loops, Numbers<double> rates) {
  constexpr double tolerance = 1e-3;  // the tolerance is wide, because derivatives that are measured or
                                      // differenced have few correct digits
  const Eigen::Index nv = model.nv();
  for (int k = 0; k <= loops.order(); ++k) {
    const Vector known = loops.known_terms(rates.data(), k),
                 own = loops.derivative(0) * Eigen::Map<const Vector>(rates.data() + k * nv, nv);
    const double size = 1 + stable_norm(as_span(known)) + stable_norm(as_span(own));
    for (const LoopRows& loop : model.loops().all) {
      const Vector rest = (known + own).segment(loop.first_row, loop.rows);
      const double error = stable_norm(as_span(rest));
      if (!is_within(error, tolerance * size))
        throw std::invalid_argument("rates: row " + std::to_string(k) + " does not keep loop \"" + loop.name +
                                    "\" closed: derivative " + std::to_string(k) + " of A v is " +
                                    to_text(error) +
                                    " and must be 0; inverse_kinematics_rates finds such motions");
    }
  }
}

}  // namespace

double inverse_dynamics_rates(const Model& model, LoopWorkspace<>& workspace, Numbers<double> q,
                              Numbers<double> rates, std::span<double> tau, std::span<const int> drives,
                              const Loads<double>& loads) {
  LoopSystem<double>& system = checked(model, workspace, q);
  check_loads(model, loads);
  const Eigen::Index nv = model.nv(), m = model.loops().rows;
  const Eigen::Index orders = nv == 0 ? 0 : std::ssize(tau) / nv;
  if (orders == 0 || orders * nv != std::ssize(tau) || orders > LoopSeries::largest_order)
    throw std::invalid_argument("tau has " + std::to_string(tau.size()) + " numbers; they come in 1 to " +
                                std::to_string(LoopSeries::largest_order) +
                                " rows of nv = " + std::to_string(nv));
  check_size("rates", rates.size(), static_cast<std::size_t>((orders + 1) * nv), "a row more than tau");
  check_separate("tau", tau, "rates", std::span<const double>(rates));
  if (!finite(rates)) throw std::invalid_argument("rates is not finite");
  check_closed(system, q, rates.first(static_cast<std::size_t>(nv)));
  LoopSeries loops(model, static_cast<int>(orders));
  loops.run(q.data(), rates.data());
  check_motion(model, loops, rates);
  std::vector<double> forces(tau.size());
  ForceSeries<double>(model.tree<double>(), static_cast<int>(orders - 1))
      .run(model.tree<double>(), q.data(), rates.data(), loads, forces.data());

  Vector drive = Vector::Zero(nv);  // 1 at the velocities of drives
  for (const int c : driven(model, drives)) drive[c] = 1;
  Matrix K = Matrix::Zero(nv + m, nv + m);
  K.topLeftCorner(nv, nv) = drive.asDiagonal();
  K.topRightCorner(nv, m) = loops.derivative(0).transpose();
  K.bottomLeftCorner(m, nv) = loops.derivative(0);
  Matrix M(nv, nv);
  Workspace<> cut(model, cut_tree);
  mass_matrix(model, cut, q, as_span(M));
  Matrix z(nv + m, orders);  // w and λ of each order; the drive forces are the entries of w at the drives
  double missing = 0;
  for (Eigen::Index k = 0; k < orders; ++k) {
    Vector b = Vector::Zero(nv + m);
    b.head(nv) = Eigen::Map<const Vector>(forces.data() + k * nv, nv);
    const Vector inertial = M * Eigen::Map<const Vector>(rates.data() + (k + 1) * nv, nv);
    double terms = b.norm() + inertial.norm();  // of which b is the rest
    double binomial = 1;
    for (Eigen::Index l = 1; l <= k; ++l) {
      binomial = binomial * static_cast<double>(k - l + 1) / static_cast<double>(l);
      const Matrix& A_l = loops.derivative(static_cast<int>(l));
      const Vector by_loops = binomial * (A_l.transpose() * z.col(k - l).tail(m));
      b.head(nv) -= by_loops;
      terms += by_loops.norm();
      b.tail(m) -= binomial * (A_l * z.col(k - l).head(nv));
    }
    z.col(k) = least_squares(K, b, 1e-13);
    const double size = b.norm(), left = (b - K * z.col(k)).norm();
    if (left > RowElimination<double>::rounding * terms) missing = std::max(missing, left / size);
    Eigen::Map<Vector>(tau.data() + k * nv, nv) = drive.cwiseProduct(z.col(k).head(nv));
  }
  return missing;
}

}  // namespace axode
