#include "axode/contact/law/problem_derivative.hpp"

#include <cmath>

#include "axode/recursion/decompositions.hpp"
#include "axode/recursion/least_squares.hpp"

namespace axode {
namespace {

/// Part of the largest pivot below which a row counts as redundant.
constexpr double rank_part = 1e-11;
/// Least reciprocal condition number of equations with one solution. Such a solution is certain to seven
/// digits, as `same_motion` demands.
constexpr double regular_part = 1e-8;
constexpr double same_motion = 1e-7;
constexpr double kink_part = 1e-10;

/// Whether a contact, stop or joint with friction (a block of constraint rows) is within rounding of the
/// boundary between two branches of its law, such as stick and slide. z is its trial impulse, from which the
/// law determines the impulse. `size` is the magnitude of the impulses.
bool near_kink(const LawBlock& b, const double* z, double size) {
  const double tiny = kink_part * size;
  if (b.law == ContactLaw::loop) return false;
  if (b.law == ContactLaw::dry_friction) return std::abs(std::abs(z[0]) - b.bound) < tiny;
  const double normal = b.law == ContactLaw::pressed ? b.bound : z[0];
  if (std::abs(normal) < tiny) return true;
  if (b.law == ContactLaw::stop || normal < 0) return false;
  double sum = 0;
  for (int k = 1; k < b.rows; ++k) sum += z[k] * z[k];
  return sum > 0 && std::abs(std::sqrt(sum) - normal) < tiny;
}

/// The matrix Y of a VelocityProblem as a dense matrix, nv × rows.
Eigen::MatrixXd dense_columns(const VelocityProblem& p) {
  Eigen::MatrixXd Y = Eigen::MatrixXd::Zero(p.nv(), p.rows());
  for (const VelocityProblem::Block& b : p.blocks()) {
    const auto columns = p.columns(b);
    const auto at = p.support(b);
    for (int i = 0; i < b.width; ++i)
      Y.row(at[static_cast<std::size_t>(i)]).segment(b.first, b.rows) = columns.row(i);
  }
  return Y;
}

}  // namespace

LawDerivative differentiate_law(const VelocityProblem& p, const double* lambda, const double* u,
                                const Eigen::Ref<const Eigen::MatrixXd>& by_lambda, const Changes& by_data,
                                double speed, const std::function<double()>& change) {
  const Eigen::Index m = p.rows();
  LawDerivative out;
  out.multipliers.setZero(m, by_data.cols());
  if (m == 0) return out;
  const Eigen::Map<const Eigen::VectorXd> l(lambda, m), d2(p.squared_scales().data(), m), velocity(u, m);
  const Eigen::VectorXd z = l - velocity.cwiseQuotient(d2);
  Eigen::MatrixXd Z = Eigen::MatrixXd::Zero(m, m);
  for (const VelocityProblem::Block& b : p.blocks()) {
    with_rows(b, [&](auto n) {
      LawMatrix<n()> Z_b;
      static_cast<void>(differentiate<n()>(b, z.data() + b.first, Z_b));
      Z.block<n(), n()>(b.first, b.first) = Z_b;
    });
    if (near_kink(b, z.data() + b.first, speed / std::sqrt(d2[b.first]))) out.at_kink = true;
  }
  const Eigen::MatrixXd ZD = Z * d2.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(m, m) - Z + ZD * by_lambda;
  const Eigen::VectorXd d = d2.cwiseSqrt();
  const Changes rhs = product(Eigen::MatrixXd((-d).asDiagonal() * ZD), by_data);
  const LuFactor regular(d.asDiagonal() * A * d.cwiseInverse().asDiagonal());
  if (regular.rcond() > regular_part) {
    out.multipliers = d.cwiseInverse().asDiagonal() * regular.solve_changes(rhs);
    if (out.multipliers.allFinite()) return out;  // A = 0 with one row has the estimate 1 too
  }
  const auto solve = [&](const Eigen::VectorXd& weight) -> Eigen::MatrixXd {
    const Eigen::VectorXd inverse = weight.cwiseInverse();
    const Eigen::MatrixXd scaled = d.asDiagonal() * A * inverse.asDiagonal();
    return inverse.asDiagonal() * least_squares(scaled, rhs, rank_part);
  };
  out.multipliers = solve(d);
  const double left = (d.asDiagonal() * (A * out.multipliers) - rhs).norm();
  // Another metric chooses another share of the load. A unique motion does not depend on it.
  Eigen::VectorXd other = d;
  for (Eigen::Index row = 0; row < m; ++row) other[row] *= 1 + 0.5 * std::sin(static_cast<double>(row));
  const Eigen::MatrixXd Y = dense_columns(p), motion = Y * out.multipliers;
  out.unique = (Y * solve(other) - motion).norm() <= same_motion * (motion.norm() + change()) &&
               left <= same_motion * rhs.norm();
  return out;
}

ProblemDerivative differentiate(const VelocityProblem& p, const double* lambda,
                                const Eigen::Ref<const Eigen::MatrixXd>& dx,
                                const Eigen::Ref<const Eigen::MatrixXd>& du) {
  const Eigen::Index m = p.rows();
  const Eigen::MatrixXd Y = dense_columns(p);
  Eigen::MatrixXd G(m, m);
  p.delassus(G);
  const Eigen::Map<const Eigen::VectorXd> l(lambda, m), r(p.r.data(), m);
  const Eigen::VectorXd x = p.w + Y * l, u = Y.transpose() * x + r;
  const LawDerivative law = differentiate_law(p, lambda, u.data(), G, Y.transpose() * dx + du,
                                              x.norm() + p.w.norm(), [&] { return dx.norm(); });
  return {law.multipliers, dx + Y * law.multipliers, law.unique, law.at_kink};
}

}  // namespace axode
