#include "axode/integration/contact_sensitivities.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "axode/integration/momenta/contact_step.hpp"
#include "axode/integration/momenta/contact_step_derivative.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "axode/integration/runs/sized_arguments.hpp"
#include "axode/integration/schemes/explicit_steps.hpp"
#include "axode/model/finite.hpp"

namespace axode {
namespace {

using Span = std::span<const double>;
using Matrix = Eigen::MatrixXd;

void check_motion(const Model& model, const ContactShapes& shapes, double step,
                  std::initializer_list<Sized<const double>> arguments,
                  std::initializer_list<Sized<double>> results) {
  check_step(step);
  check_contact(model, shapes);
  check_sizes(arguments, results);
  for (const auto& in : arguments)
    if (!finite(in.x)) throw std::invalid_argument(std::string(in.name) + " is not finite");
}

/// Steps of a motion with contact under forces that are constant in each step, with their derivatives.
class TangentContactSteps {
 public:
  TangentContactSteps(const Model& model, const ContactShapes& shapes, Span q_0, Span v_0, double step,
                      const Monitor& monitor)
      : q(as_eigen(q_0)),
        v(as_eigen(v_0)),
        tau_(model.nv(), 0.0),
        step_(step),
        options_{.drive = [this](double, Span, Span,
                                 std::span<double> tau) { std::ranges::copy(tau_, tau.begin()); },
                 .monitor = [monitor](double) { return !monitor || monitor(); }},
        run_(model, q_0, v_0, 0, options_, true),
        scheme_(run_, model, shapes, true),
        derivative_(model, shapes, true, true) {
    scheme_.keep_parts = true;
  }
  TangentContactSteps(const TangentContactSteps&) = delete;
  TangentContactSteps& operator=(const TangentContactSteps&) = delete;

  /// Takes a step under the drive forces tau. On entry dq and dv are the changes of the state at its start
  /// along k directions (nv × k each), and on return those at its end. Returns false if this fails, for the
  /// reason in `result`.
  bool run(Span tau, Matrix& dq, Matrix& dv, const ContactDirections& directions) {
    const double t = step_ * static_cast<double>(count_++);
    result.failure = run_.interruption(t);
    if (!result.ok()) return false;
    tau_.assign(tau.begin(), tau.end());
    result.failure = scheme_.run(t, step_, q, v);
    if (!result.ok()) return false;
    result.certificate = std::max(scheme_.certificate, result.certificate);
    for (const ContactPart& part : scheme_.kept)
      if (!derivative_.run(part, dq, dv, directions)) {
        result.failure = {t, derivative_.why()};
        return false;
      }
    q = scheme_.q;
    v = scheme_.v;
    result.unique = derivative_.unique;
    result.at_kink = derivative_.at_kink;
    if (finite(q) && finite(v) && dq.allFinite() && dv.allFinite()) return true;
    result.failure = {t, "the derivatives of the step are not finite"};
    return false;
  }

  Eigen::VectorXd q, v;  ///< the present state
  ContactSensitivity result;

 private:
  std::vector<double> tau_;
  double step_;
  SimulationOptions options_;
  ContactSimulationRun run_;
  ContactStep scheme_;
  ContactStepDerivative derivative_;
  int count_ = 0;
};

/// Fills the results with NaN if the computation failed.
ContactSensitivity finished(const ContactSensitivity& result,
                            std::initializer_list<std::span<double>> results) {
  if (!result.ok())
    for (const std::span<double> x : results) std::ranges::fill(x, std::numeric_limits<double>::quiet_NaN());
  return result;
}

/// Unit changes of q, v and τ (nv each), and of the friction, the restitution and the layer thickness of each
/// shape. Every matrix has a column for each of these directions.
struct AllDirections {
  Matrix dq, dv;
  ContactDirections others;

  AllDirections(Eigen::Index nv, Eigen::Index shapes) {
    const auto unit = [&](Eigen::Index rows, Eigen::Index first) {
      Matrix x = Matrix::Zero(rows, 3 * nv + 3 * shapes);
      x.middleCols(first, rows).setIdentity();
      return x;
    };
    dq = unit(nv, 0);
    dv = unit(nv, nv);
    others.tau = unit(nv, 2 * nv);
    if (shapes == 0) return;
    others.friction = unit(shapes, 3 * nv);
    others.restitution = unit(shapes, 3 * nv + shapes);
    others.thickness = unit(shapes, 3 * nv + 2 * shapes);
  }
};

}  // namespace

ContactSensitivity contact_rollout_derivatives(const Model& model, const ContactShapes& shapes, Span q,
                                               Span v, Span tau, double step,
                                               const ContactRolloutDerivatives& out, const Monitor& monitor) {
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv()),
                    K = steps_of(model, tau);
  const std::size_t n_shapes = out.C.empty() ? 0 : static_cast<std::size_t>(shapes.size());
  check_motion(model, shapes, step, {{"q", q, nq, "nq"}, {"v", v, nv, "nv"}, {"tau", tau, K * nv, "K nv"}},
               {{"out.q", out.q, (K + 1) * nq, "(K + 1) nq"},
                {"out.v", out.v, (K + 1) * nv, "(K + 1) nv"},
                {"out.A", out.A, 4 * K * nv * nv, "K * 2 nv * 2 nv"},
                {"out.B", out.B, 2 * K * nv * nv, "K * 2 nv * nv"},
                {"out.C", out.C, 6 * K * nv * n_shapes, "K * 2 nv * 3 n for n shapes, or empty"}});
  TangentContactSteps steps(model, shapes, q, v, step, monitor);
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Index n = model.nv(), surfaces = 3 * static_cast<Eigen::Index>(n_shapes);
  const AllDirections along(n, surfaces / 3);
  std::ranges::copy(q, out.q.begin());
  std::ranges::copy(v, out.v.begin());
  for (std::size_t k = 0; k < K; ++k) {
    Matrix dq = along.dq, dv = along.dv;
    if (!steps.run(tau.subspan(k * nv, nv), dq, dv, along.others)) break;
    as_eigen(out.q.subspan((k + 1) * nq, nq)) = steps.q;
    as_eigen(out.v.subspan((k + 1) * nv, nv)) = steps.v;
    Eigen::Map<Rows> A(out.A.data() + 4 * k * nv * nv, 2 * n, 2 * n);
    Eigen::Map<Rows> B(out.B.data() + 2 * k * nv * nv, 2 * n, n);
    Eigen::Map<Rows> C(out.C.data() + 6 * k * nv * n_shapes, 2 * n, surfaces);
    A << dq.leftCols(2 * n), dv.leftCols(2 * n);
    B << dq.middleCols(2 * n, n), dv.middleCols(2 * n, n);
    if (surfaces > 0) C << dq.rightCols(surfaces), dv.rightCols(surfaces);
  }
  return finished(steps.result, {out.q, out.v, out.A, out.B, out.C});
}

ContactSensitivity contact_rollout_jvp(const Model& model, const ContactShapes& shapes, Span q, Span v,
                                       Span tau, double step, Span dq, Span dv, Span dtau,
                                       std::span<double> dq_out, std::span<double> dv_out,
                                       const Monitor& monitor) {
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv()),
                    K = steps_of(model, tau);
  check_motion(
      model, shapes, step,
      {{"q", q, nq, "nq"},
       {"v", v, nv, "nv"},
       {"tau", tau, K * nv, "K nv"},
       {"dq", dq, nv, "nv"},
       {"dv", dv, nv, "nv"},
       {"dtau", dtau, K * nv, "K nv"}},
      {{"dq_out", dq_out, (K + 1) * nv, "(K + 1) nv"}, {"dv_out", dv_out, (K + 1) * nv, "(K + 1) nv"}});
  TangentContactSteps steps(model, shapes, q, v, step, monitor);
  Matrix dq_k = as_eigen(dq), dv_k = as_eigen(dv);
  std::ranges::copy(dq, dq_out.begin());
  std::ranges::copy(dv, dv_out.begin());
  for (std::size_t k = 0; k < K; ++k) {
    if (!steps.run(tau.subspan(k * nv, nv), dq_k, dv_k, {.tau = as_eigen(dtau.subspan(k * nv, nv))})) break;
    std::copy_n(dq_k.data(), nv, dq_out.data() + (k + 1) * nv);
    std::copy_n(dv_k.data(), nv, dv_out.data() + (k + 1) * nv);
  }
  return finished(steps.result, {dq_out, dv_out});
}

ContactSensitivity contact_rollout_vjp(const Model& model, const ContactShapes& shapes, Span q, Span v,
                                       Span tau, double step, Span w_q, Span w_v,
                                       const RolloutGradients& gradient, const Monitor& monitor) {
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv()),
                    K = steps_of(model, tau);
  check_motion(model, shapes, step,
               {{"q", q, nq, "nq"},
                {"v", v, nv, "nv"},
                {"tau", tau, K * nv, "K nv"},
                {"w_q", w_q, (K + 1) * nv, "(K + 1) nv"},
                {"w_v", w_v, (K + 1) * nv, "(K + 1) nv"}},
               {{"gradient.q", gradient.q, nv, "nv"},
                {"gradient.v", gradient.v, nv, "nv"},
                {"gradient.tau", gradient.tau, K * nv, "K nv"},
                {"gradient.geometry", gradient.geometry, 0, "empty: it is not known with contact"}});
  TangentContactSteps steps(model, shapes, q, v, step, monitor);
  const Eigen::Index n = model.nv();
  std::vector<Matrix> by_state;  // (dq; dv) at the end of each step, 2nv × 3nv
  const AllDirections along(n, 0);
  for (std::size_t k = 0; k < K; ++k) {
    Matrix dq = along.dq, dv = along.dv;
    if (!steps.run(tau.subspan(k * nv, nv), dq, dv, along.others)) break;
    by_state.emplace_back(2 * n, 3 * n);
    by_state.back() << dq, dv;
  }
  if (steps.result.ok()) {
    const auto weights = [&](std::size_t k) {
      Eigen::VectorXd w(2 * n);
      w << as_eigen(w_q.subspan(k * nv, nv)), as_eigen(w_v.subspan(k * nv, nv));
      return w;
    };
    Eigen::VectorXd w = weights(K);
    for (std::size_t k = K; k-- > 0;) {
      const Eigen::VectorXd by = by_state[k].transpose() * w;
      as_eigen(gradient.tau.subspan(k * nv, nv)) = by.tail(n);
      w = weights(k) + by.head(2 * n);
    }
    as_eigen(gradient.q) = w.head(n);
    as_eigen(gradient.v) = w.tail(n);
  }
  return finished(steps.result, {gradient.q, gradient.v, gradient.tau});
}

}  // namespace axode
