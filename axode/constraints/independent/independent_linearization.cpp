#include "axode/constraints/independent/independent_linearization.hpp"

#include <limits>

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/constrained_derivatives.hpp"
#include "axode/constraints/independent/independent_velocities.hpp"
#include "axode/derivatives/displacement/velocity_bracket.hpp"
#include "axode/derivatives/spring_derivatives.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/eigen.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

using Matrix = Eigen::MatrixXd;
using RowByRow = LoopSystem<double>::RowByRow;

/// Computes the derivative of A v by q (m × nv) for constant velocities v (nv), where A is the Jacobian of
/// the m loop equations A v = 0. LoopSystem differentiates A a + A' v for accelerations a and velocities. It
/// is given v as accelerations and 0 as velocities, so that only A v remains.
RowByRow velocity_rows_by_q(LoopSystem<double>& system, std::span<const double> q,
                            std::span<const double> v) {
  const Eigen::Index nv = system.model().nv(), m = system.model().loops().rows;
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(nv), lambda = Eigen::VectorXd::Zero(m);
  Eigen::VectorXd forces(nv);
  RowByRow by_q = RowByRow::Zero(m, nv), by_v = by_q, unused = RowByRow::Zero(nv, nv);
  system.force(q.data(), still.data(), v.data(), {}, forces.data());
  system.make_rows(ConstraintLevel::velocity);
  system.differentiate(lambda.data(), by_q.data(), by_v.data(), unused.data());
  return by_q;
}

}  // namespace

IndependentLinearization independent_linearization(const Model& model, std::span<const double> q,
                                                   std::span<const double> v, std::span<const double> tau,
                                                   std::span<const int> velocities,
                                                   const Loads<double>& loads) {
  catalog::check_counts<"independent_linearization">(model);
  LoopWorkspace<double> loops(model);
  LoopSystem<double>& system = checked<double>(model, loops, q, v);
  check_size("tau", tau.size(), v.size(), "nv");
  check_loads(model, loads);
  check_closed(system, q, v);
  const Eigen::Index nv = model.nv();
  RowByRow rows_q = velocity_rows_by_q(system, q, v), A(rows_q.rows(), nv);
  const IndependentRows<double> rows(system, ConstraintLevel::velocity);
  const IndependentVelocities independent = independent_velocities(model, rows, velocities);
  const std::vector<int>& chosen = independent.velocities;
  system.write(A.data());

  IndependentLinearization out;
  out.velocities = chosen;
  out.N = independent.N;
  out.D = dependent_part(independent, rows, A, -rows_q * out.N);
  const auto k = static_cast<Eigen::Index>(chosen.size());
  out.A = Matrix::Zero(2 * k, 2 * k);
  out.B = Matrix::Zero(2 * k, nv);

  Workspace<double> workspace(model);
  Eigen::VectorXd forces = as_eigen(tau);
  add_spring_forces(model, workspace, q, v, as_span(forces));
  RowByRow a_q(nv, nv), a_v(nv, nv), a_tau(nv, nv), forces_q(nv, nv), forces_v(nv, nv);
  out.solvability = forward_dynamics_derivatives(model, loops, q, v, as_span(std::as_const(forces)),
                                                 {as_span(a_q), as_span(a_v), as_span(a_tau)}, loads);
  if (!out.solvability.ok()) {
    out.A.setConstant(std::numeric_limits<double>::quiet_NaN());
    out.B.setConstant(std::numeric_limits<double>::quiet_NaN());
    return out;
  }
  spring_force_derivatives(model, workspace, q, v, {as_span(forces_q), as_span(forces_v)});
  a_q += a_tau * forces_q;
  a_v += a_tau * forces_v;

  RowByRow bracket = RowByRow::Zero(nv, nv);
  subtract_ad(model.tree<double>(), v.data(), nv, bracket.data());
  const auto chosen_rows = [&](const Matrix& all) { return Matrix(all(chosen, Eigen::indexing::all)); };
  out.A.topLeftCorner(k, k) = chosen_rows(bracket * out.N);
  out.A.topRightCorner(k, k).setIdentity();
  out.A.bottomLeftCorner(k, k) = chosen_rows(a_q * out.N + a_v * out.D);
  out.A.bottomRightCorner(k, k) = chosen_rows(a_v * out.N);
  out.B.bottomRows(k) = chosen_rows(a_tau);
  return out;
}

}  // namespace axode
