#include "axode/constraints/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "axode/constraints/assembly.hpp"
#include "axode/constraints/loop_system/independent_rows.hpp"
#include "axode/derivatives/inverse_dynamics_derivatives.hpp"
#include "axode/derivatives/spring_derivatives.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/eigen.hpp"
#include "axode/model/finite.hpp"
#include "axode/recursion/least_squares.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {

std::string_view to_string(EquilibriumStatus status) {
  switch (status) {
    case EquilibriumStatus::solved: return "solved";
    case EquilibriumStatus::stalled: return "stalled";
    case EquilibriumStatus::iteration_limit: return "iteration_limit";
    case EquilibriumStatus::open: return "open";
  }
  return "unknown";
}

namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;

/// A configuration q with the forces r that are not in equilibrium there, and the derivative of r by q. If
/// the mechanism has loops, r and its derivative are projected onto the columns of N, an orthonormal basis of
/// the velocities that the loops allow; without loops N is empty.
struct Iterate {
  std::vector<double> q;
  Vector r;
  RowMajor dr_dq, N;
  double residual = 0;  ///< ‖r‖, N m and N

  Iterate(const Model& model, std::span<const double> at)
      : q(at.begin(), at.end()), r(model.nv()), dr_dq(model.nv(), model.nv()) {}
};

/// Computes the unbalanced forces: the forces that q needs for rest, minus those of drives and springs.
class Statics {
 public:
  Statics(const Model& model, std::span<const double> tau, const Loads<>& loads)
      : model_(model),
        tau_(tau.begin(), tau.end()),
        loads_{loads.wrenches},
        workspace_(model, cut_tree),
        rest_(static_cast<std::size_t>(model.nv())),
        springs_(rest_),
        by_v_(model.nv(), model.nv()),
        by_a_(model.nv(), model.nv()) {
    tau_.resize(rest_.size());
    if (!model.loops().empty()) loops_.emplace(model);
  }

  void evaluate(Iterate& at) {
    at.r.resize(model_.nv());
    at.dr_dq.resize(model_.nv(), model_.nv());
    inverse_dynamics_derivatives(model_, workspace_, at.q, rest_, rest_,
                                 {as_span(at.dr_dq), as_span(by_v_), as_span(by_a_), as_span(at.r)}, loads_);
    at.r -= as_eigen(std::span<const double>(tau_));
    if (!model_.springs().empty()) {
      spring_forces(model_, workspace_, at.q, rest_, springs_);
      spring_force_derivatives(model_, workspace_, at.q, rest_, {as_span(by_a_), as_span(by_v_)});
      at.r -= as_eigen(std::span<const double>(springs_));
      at.dr_dq -= by_a_;
    }
    if (loops_) close(at);
    at.residual = at.r.norm();
  }

 private:
  /// Projects the unbalanced forces r and their derivative by q onto the velocities that the loops allow. The
  /// derivative is that of r - Aᵀ λ, where A is the Jacobian of the loop equations. The multipliers λ are
  /// constant and make this difference least (least squares).
  void close(Iterate& at) {
    const Eigen::Index nv = model_.nv(), m = model_.loops().rows;
    Vector lambda(m), forces(nv);
    RowMajor by_q = RowMajor::Zero(m, nv), by_v = by_q, forces_q = RowMajor::Zero(nv, nv);
    loops_->update_kinematics(at.q.data());
    const IndependentRows<double> rows(*loops_, ConstraintLevel::velocity);
    rows.least_multipliers(at.r, as_span(lambda));
    loops_->move(at.q.data(), rest_.data(), {}, forces.data());
    loops_->make_rows(ConstraintLevel::velocity);
    loops_->differentiate(lambda.data(), by_q.data(), by_v.data(), forces_q.data());
    at.N = rows.kernel();
    at.r = Vector(at.N.transpose() * at.r);
    at.dr_dq = RowMajor(at.N.transpose() * (at.dr_dq - forces_q) * at.N);
  }

  const Model& model_;
  std::vector<double> tau_;
  Loads<> loads_;
  Workspace<> workspace_;
  std::optional<LoopSystem<double>> loops_;
  std::vector<double> rest_, springs_;
  RowMajor by_v_, by_a_;
};

/// The Newton step -(∂r/∂q)⁺ r for the unbalanced forces r. If its largest entry is above 1 rad or m, the
/// whole step is scaled so that this entry is 1. Directions along which r changes only by rounding errors are
/// left out.
Vector newton_step(const Iterate& at) {
  Vector step = -least_squares(at.dr_dq, at.r, 1e-10);
  if (at.N.rows() > 0) step = Vector(at.N * step);
  return step / std::max(1.0, step.lpNorm<Eigen::Infinity>());
}

/// Replaces q by a closed configuration near it. Returns whether one was found.
bool closed(const Model& model, std::vector<double>& q) {
  if (model.loops().empty()) return true;
  AssemblyResult found = assemble(model, q);
  q = std::move(found.q);
  return found.status == AssemblyStatus::closed;
}

/// Moves the configuration `at` along the step. If this does not reduce the unbalanced forces, the step is
/// halved, again and again. Returns false, and leaves `at` unchanged, if no part of the step reduces them.
bool improve(const Model& model, Statics& statics, const Vector& step, Iterate& at, Iterate& next) {
  constexpr int most_halves = 40;
  constexpr double decrease = 1e-4;
  for (int k = 0; k < most_halves; ++k) {
    const double s = std::ldexp(1.0, -k);
    const Vector part = s * step;
    next.q = integrate(model, at.q, as_span(part));
    if (!closed(model, next.q)) continue;
    statics.evaluate(next);
    if (next.residual <= (1 - decrease * s) * at.residual) {
      std::swap(at, next);
      return true;
    }
  }
  return false;
}

void check(const Model& model, std::span<const double> q0, std::span<const double> tau, const Loads<>& loads,
           const EquilibriumOptions& options) {
  const auto need = [](bool good, const std::string& what) {
    if (!good) throw std::invalid_argument("equilibrium: " + what);
  };
  check_configuration(model, q0, "q0");
  if (!tau.empty()) check_size("tau", tau.size(), static_cast<std::size_t>(model.nv()), "nv");
  need(finite(q0), "q0 is not finite");
  need(finite(tau), "tau is not finite");
  for (const AppliedWrench<>& W : loads.wrenches) need(finite(W.m) && finite(W.f), "a load is not finite");
  need(options.tolerance > 0, "tolerance is " + to_text(options.tolerance) + "; it must be positive");
  need(options.iterations > 0,
       "iterations is " + std::to_string(options.iterations) + "; it must be positive");
}

}  // namespace

EquilibriumResult equilibrium(const Model& model, std::span<const double> q0, std::span<const double> tau,
                              const Loads<>& loads, const EquilibriumOptions& options) {
  catalog::check_counts<"equilibrium">(model);
  check(model, q0, tau, loads, options);
  Statics statics(model, tau, loads);
  Iterate at(model, q0), next(model, q0);
  if (!closed(model, at.q))
    return {EquilibriumStatus::open, std::move(at.q), std::numeric_limits<double>::infinity(), 0};
  statics.evaluate(at);
  const auto solved = [&] { return at.residual <= options.tolerance; };
  bool moves = true;
  int iterations = 0;
  for (; !solved() && moves && iterations < options.iterations; ++iterations) {
    const Vector step = newton_step(at);
    moves = step.allFinite() && improve(model, statics, step, at, next);
  }
  const EquilibriumStatus status = solved() ? EquilibriumStatus::solved
                                   : moves  ? EquilibriumStatus::iteration_limit
                                            : EquilibriumStatus::stalled;
  return {status, std::move(at.q), at.residual, iterations};
}

}  // namespace axode
