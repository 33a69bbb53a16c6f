#include "axode/drives/linearization.hpp"

#include <algorithm>
#include <stdexcept>

#include "axode/derivatives/linearization.hpp"
#include "axode/dynamics/forward_dynamics.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/eigen.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/finite.hpp"
#include "axode/recursion/least_squares.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

using Vector = Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Span = std::span<const double>;

void check(const Model& model, const DriveSystem& drives, Span q, Span v, Span x) {
  check_configuration(model, q);
  check_size("v", v.size(), static_cast<std::size_t>(model.nv()), "nv");
  check_size("x", x.size(), drives.nx(), "the number of states of the drives");
  if (const std::string bad = first_not_finite(model, q, v); !bad.empty())
    throw std::invalid_argument("linearize_with_drives: " + bad + "; it must be finite");
  for (std::size_t k = 0; k < x.size(); ++k)
    if (!finite(x[k]))
      throw std::invalid_argument("linearize_with_drives: x of \"" + drives.states()[k].name + "\" is " +
                                  to_text(x[k]) + "; it must be finite");
}

/// A state (q, v = 0, x) with its accelerations and, after these, the rates x' over the nominal values of x.
struct AtRest {
  std::vector<double> q, x;
  Vector rates;
  double residual = 0;
  Solvability solvability;
};

/// The equations of a state of rest, and Newton's method for them. At rest v = 0, the accelerations are 0,
/// and the rates of the drive states are 0. Each rate of a drive state is divided by the nominal value of
/// this state.
class Statics {
 public:
  Statics(const Model& model, DriveSystem& drives, double t)
      : model_(model),
        drives_(drives),
        t_(t),
        workspace_(model),
        still_(static_cast<std::size_t>(model.nv())) {
    nominal_.resize(static_cast<Eigen::Index>(drives.nx()));
    for (std::size_t k = 0; k < drives.nx(); ++k)
      nominal_[static_cast<Eigen::Index>(k)] = drives.states()[k].nominal;
  }
  void evaluate(AtRest& at) {
    std::vector<double> tau(still_.size()), dx(at.x.size());
    drives_.set_state(t_, at.q, still_, at.x);
    drives_.evaluate(t_, at.q, still_, at.x, tau, dx);
    if (!model_.springs().empty()) add_spring_forces(model_, workspace_, at.q, still_, tau);
    const Eigen::Index nv = model_.nv();
    at.rates.resize(nv + nominal_.size());
    at.solvability =
        forward_dynamics(model_, workspace_, at.q, still_, tau, as_span(at.rates).first(still_.size()));
    at.rates.tail(nominal_.size()) = as_eigen(Span(dx)).cwiseQuotient(nominal_);
    at.residual = at.rates.size() > 0 ? at.rates.lpNorm<Eigen::Infinity>() : 0;
  }
  /// The step of Newton's method: displacements of q (nv numbers, rad or m, at most 1 in magnitude), then the
  /// changes of the drive states, each divided by the nominal value of the state.
  Vector step(const AtRest& at) {
    const DriveLinearization linear = linearize_with_drives(model_, drives_, t_, at.q, still_, at.x);
    const Eigen::Index nv = model_.nv(), nx = nominal_.size(), n = nv + nx;
    Eigen::MatrixXd J(n, n);
    J << linear.A.bottomLeftCorner(n, nv), linear.A.bottomRightCorner(n, nx);
    J.rightCols(nx) *= nominal_.asDiagonal();
    J.bottomRows(nx) = nominal_.cwiseInverse().asDiagonal() * J.bottomRows(nx);
    Vector r = at.rates;
    for (Eigen::Index k = 0; k < n; ++k)
      if (const double size = J.row(k).norm(); size > 0) {
        J.row(k) /= size;
        r[k] /= size;
      }
    constexpr double rank = 1e-11;
    const Vector step = -least_squares(J, r, rank);
    const double largest = nv > 0 ? step.head(nv).lpNorm<Eigen::Infinity>() : 0;
    return step / std::max(1.0, largest);  // at most 1 rad or m
  }
  AtRest moved(const AtRest& at, const Vector& step) const {
    const Vector dq = step.head(model_.nv());
    AtRest next{integrate(model_, at.q, as_span(dq)), at.x, {}, 0, {}};
    for (std::size_t k = 0; k < next.x.size(); ++k)
      next.x[k] += nominal_[static_cast<Eigen::Index>(k)] * step[model_.nv() + static_cast<Eigen::Index>(k)];
    return next;
  }

 private:
  const Model& model_;
  DriveSystem& drives_;
  double t_;
  Workspace<> workspace_;
  std::vector<double> still_;
  Vector nominal_;
};

}  // namespace

DriveLinearization linearize_with_drives(const Model& model, DriveSystem& drives, double t, Span q, Span v,
                                         Span x, const Loads<double>& loads) {
  catalog::check_counts<"linearize_with_drives">(model);
  check(model, drives, q, v, x);
  const Eigen::Index nv = model.nv(), nx = static_cast<Eigen::Index>(drives.nx()), n = 2 * nv + nx;
  Vector tau = Vector::Zero(nv), dx(nx);
  drives.set_state(t, q, v, x);
  drives.evaluate(t, q, v, x, as_span(tau), as_span(dx));
  RowMajor A_0(2 * nv, 2 * nv), B_0(2 * nv, nv);
  Workspace<> workspace(model);
  DriveLinearization out;
  out.solvability = linearize_without_drives<double>(model, workspace, q, v, as_span(std::as_const(tau)),
                                                     {as_span(A_0), as_span(B_0)}, loads);
  const DriveDerivatives by = drives.derivatives(t, q, v, x);
  const auto inverse = B_0.bottomRows(nv);  // M⁻¹
  out.A = Eigen::MatrixXd::Zero(n, n);
  out.A.topLeftCorner(2 * nv, 2 * nv) = A_0;
  out.A.block(nv, 0, nv, nv) += inverse * by.tau_q;
  out.A.block(nv, nv, nv, nv) += inverse * by.tau_v;
  out.A.block(nv, 2 * nv, nv, nx) = inverse * by.tau_x;
  out.A.bottomRows(nx) << by.f_q, by.f_v, by.f_x;
  out.B = Eigen::MatrixXd::Zero(n, by.tau_u.cols());
  out.B.middleRows(nv, nv) = inverse * by.tau_u;
  out.B.bottomRows(nx) = by.f_u;
  return out;
}

DriveEquilibrium equilibrium_with_drives(const Model& model, DriveSystem& drives, double t, Span q, Span x) {
  catalog::check_counts<"equilibrium_with_drives">(model);
  const std::vector<double> still(static_cast<std::size_t>(model.nv()));
  check(model, drives, q, still, x);
  constexpr int most_iterations = 100, most_halves = 40;
  constexpr double tolerance = 1e-9;
  Statics statics(model, drives, t);
  AtRest at{{q.begin(), q.end()}, {x.begin(), x.end()}, {}, 0, {}};
  statics.evaluate(at);
  bool moves = at.solvability.ok() && at.residual > 0;
  for (int iteration = 0; moves && iteration < most_iterations; ++iteration) {
    const Vector step = statics.step(at);
    moves = false;
    for (int k = 0; !moves && k < most_halves; ++k) {
      AtRest next = statics.moved(at, std::ldexp(1.0, -k) * step);
      statics.evaluate(next);
      if (!next.solvability.ok() || !(next.residual < at.residual)) continue;
      at = std::move(next);
      moves = true;
    }
  }
  return {std::move(at.q), std::move(at.x), at.solvability.ok() && at.residual <= tolerance, at.residual,
          at.solvability};
}

}  // namespace axode
