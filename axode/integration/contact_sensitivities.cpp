#include "axode/integration/contact_sensitivities.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "axode/integration/momenta/contact_motion.hpp"
#include "axode/integration/momenta/contact_step_derivative.hpp"
#include "axode/integration/runs/sized_arguments.hpp"
#include "axode/integration/schemes/explicit_steps.hpp"
#include "axode/model/finite.hpp"
#include "axode/scalar/index.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

using Span = std::span<const double>;

void check_motion(const Model& model, const ContactShapes& shapes, double step,
                  std::initializer_list<Sized<const double>> arguments,
                  std::initializer_list<Sized<double>> results) {
  check_step(step);
  check_shapes(model, shapes);
  catalog::check_counts<"contact">(model);
  check_sizes(arguments, results);
  for (const auto& in : arguments)
    if (!finite(in.x)) throw std::invalid_argument(std::string(in.name) + " is not finite");
}

/// The numbers of parameters of each kind, or 0 for those that are not asked for.
struct Counts {
  Eigen::Index surfaces, placement, inertia, geometry;

  /// Counts the parameters of those kinds (surfaces, placement, inertia, geometry) for which `asked` has a
  /// span that is not empty. Throws std::invalid_argument if `asked` has geometric parameters and the model
  /// has closed loops, prescribed motions or springs between frames, because the derivatives by geometry are
  /// then not known.
  template <class T>
  Counts(const Model& model, const ContactShapes& shapes, const ContactParameters<T>& asked)
      : surfaces(asked.surfaces.empty() ? 0 : 3 * shapes.size()),
        placement(asked.placement.empty() ? 0 : 6 * shapes.size()),
        inertia(asked.inertia.empty() ? 0 : 10 * model.n_bodies()),
        geometry(asked.geometry.empty() ? 0 : 6 * model.n_bodies()) {
    const char* const what = model.springs().between_frames() ? "springs between frames"
                             : !model.loops().empty()         ? "closed loops"
                             : !model.motions().empty()       ? "prescribed motions"
                                                              : nullptr;
    if (geometry > 0 && what)
      throw std::invalid_argument("model \"" + model.name() + "\" has " + what +
                                  ", so that derivatives of motions with contact by its geometry are not "
                                  "known; leave those by geometry out");
  }
};

/// Steps of a motion with contact under forces that are constant in each step, with their derivatives.
class TangentContactSteps {
 public:
  /// For K steps of length `step`.
  TangentContactSteps(const Model& model, const ContactShapes& shapes, Span q_0, Span v_0, std::size_t K,
                      double step, const Monitor& monitor)
      : q(as_eigen(q_0)),
        v(as_eigen(v_0)),
        tau_(model.nv(), 0.0),
        step_(step),
        options_{.drive = [this](double, Span, Span,
                                 std::span<double> tau) { std::ranges::copy(tau_, tau.begin()); },
                 .monitor = [monitor](double) { return !monitor || monitor(); }},
        run_(model, q_0, v_0, static_cast<double>(K) * step, options_, true),
        steps_(run_, shapes, true),
        derivative_(run_.closed_model(), shapes, true, true) {
    steps_.keep_parts();
  }
  TangentContactSteps(const TangentContactSteps&) = delete;
  TangentContactSteps& operator=(const TangentContactSteps&) = delete;

  /// Takes a step under the drive forces tau. On entry dq and dv are the changes of the state at its start
  /// along k directions (nv × k each), and on return those at its end. Returns false if this fails, for the
  /// reason in `result`. The step is divided where a prescribed motion jumps.
  bool run(Span tau, Changes& dq, Changes& dv, const ContactDirections& directions) {
    const double t = run_.now(), t_1 = step_ * static_cast<double>(++count_);
    result.failure = run_.interruption(t);
    tau_.assign(tau.begin(), tau.end());
    while (result.ok() && run_.now() < t_1) {
      double t_end = run_.step_end(t_1);
      result.failure = steps_.compute_up_to_switch(t_end, computed_);
      if (!result.ok()) break;
      result.certificate = std::max(computed_.certificate, result.certificate);
      for (const ContactPart& part : steps_.parts())
        if (!derivative_.run(part, dq, dv, directions)) {
          result.failure = {run_.now(), derivative_.why()};
          return false;
        }
      run_.move_to(t_end, as_span(computed_.end.q), as_span(computed_.end.v), computed_.end.x);
    }
    if (!result.ok()) return false;
    q = run_.q;
    v = run_.v;
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
  ContactSteps steps_;
  ComputedContactStep computed_;
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

/// Unit changes of q, v and τ (nv each), and then of those parameters whose numbers are not 0.
struct AllDirections {
  Changes dq, dv;
  ContactDirections others;

  AllDirections(Eigen::Index nv, const Counts& counts) {
    const Eigen::Index state = 3 * nv + counts.surfaces, shapes = counts.surfaces / 3;
    const Eigen::Index p = counts.placement + counts.inertia + counts.geometry;
    const auto unit = [](Eigen::Index rows, Eigen::Index first, Eigen::Index columns) {
      Changes x = Changes::Zero(rows, rows > 0 ? columns : 0);
      if (rows > 0) x.middleCols(first, rows).setIdentity();
      return x;
    };
    dq = unit(nv, 0, state + p);
    dv = unit(nv, nv, state + p);
    others.tau = unit(nv, 2 * nv, state + p);
    others.friction = unit(shapes, 3 * nv, state + p);
    others.restitution = unit(shapes, 3 * nv + shapes, state + p);
    others.thickness = unit(shapes, 3 * nv + 2 * shapes, state + p);
    others.parameters = {unit(counts.inertia, counts.placement, p),
                         unit(counts.geometry, counts.placement + counts.inertia, p),
                         unit(counts.placement, 0, p)};
  }
};

}  // namespace

ContactSensitivity contact_rollout_derivatives(const Model& model, const ContactShapes& shapes, Span q,
                                               Span v, Span tau, double step,
                                               const ContactRolloutDerivatives& out, const Monitor& monitor) {
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv()),
                    K = steps_of(model, tau);
  const Counts counts(model, shapes,
                      ContactParameters<double>{out.C, out.by.placement, out.by.inertia, out.by.geometry});
  const auto rows_of = [&](Eigen::Index count) { return 2 * K * nv * static_cast<std::size_t>(count); };
  check_motion(
      model, shapes, step, {{"q", q, nq, "nq"}, {"v", v, nv, "nv"}, {"tau", tau, K * nv, "K nv"}},
      {{"out.q", out.q, (K + 1) * nq, "(K + 1) nq"},
       {"out.v", out.v, (K + 1) * nv, "(K + 1) nv"},
       {"out.A", out.A, 4 * K * nv * nv, "K * 2 nv * 2 nv"},
       {"out.B", out.B, 2 * K * nv * nv, "K * 2 nv * nv"},
       {"out.C", out.C, rows_of(counts.surfaces), "K * 2 nv * 3 n for n shapes, or empty"},
       {"out.by.surfaces", out.by.surfaces, 0, "empty: out.C receives them"},
       {"out.by.placement", out.by.placement, rows_of(counts.placement),
        "K * 2 nv * 6 n for n shapes, or empty"},
       {"out.by.inertia", out.by.inertia, rows_of(counts.inertia), "K * 2 nv * 10 n_bodies, or empty"},
       {"out.by.geometry", out.by.geometry, rows_of(counts.geometry), "K * 2 nv * 6 n_bodies, or empty"}});
  TangentContactSteps steps(model, shapes, q, v, K, step, monitor);
  const Eigen::Index n = model.nv();
  const AllDirections along(n, counts);
  std::ranges::copy(q, out.q.begin());
  std::ranges::copy(v, out.v.begin());
  for (std::size_t k = 0; k < K; ++k) {
    Changes dq = along.dq, dv = along.dv;
    if (!steps.run(tau.subspan(k * nv, nv), dq, dv, along.others)) break;
    as_eigen(out.q.subspan((k + 1) * nq, nq)) = steps.q;
    as_eigen(out.v.subspan((k + 1) * nv, nv)) = steps.v;
    Eigen::Index first = 0;
    const auto write = [&](std::span<double> to, Eigen::Index columns) {
      if (columns == 0) return;
      Eigen::Map<Changes> matrix(to.data() + static_cast<std::ptrdiff_t>(k) * 2 * n * columns, 2 * n,
                                 columns);
      matrix << dq.middleCols(first, columns), dv.middleCols(first, columns);
      first += columns;
    };
    write(out.A, 2 * n);
    write(out.B, n);
    write(out.C, counts.surfaces);
    write(out.by.placement, counts.placement);
    write(out.by.inertia, counts.inertia);
    write(out.by.geometry, counts.geometry);
  }
  return finished(steps.result,
                  {out.q, out.v, out.A, out.B, out.C, out.by.placement, out.by.inertia, out.by.geometry});
}

ContactSensitivity contact_rollout_jvp(const Model& model, const ContactShapes& shapes, Span q, Span v,
                                       Span tau, double step, Span dq, Span dv, Span dtau,
                                       std::span<double> dq_out, std::span<double> dv_out,
                                       const Monitor& monitor,
                                       const ContactParameters<const double>& parameters) {
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv()),
                    K = steps_of(model, tau);
  const Counts counts(model, shapes, parameters);
  check_motion(
      model, shapes, step,
      {{"q", q, nq, "nq"},
       {"v", v, nv, "nv"},
       {"tau", tau, K * nv, "K nv"},
       {"dq", dq, nv, "nv"},
       {"dv", dv, nv, "nv"},
       {"dtau", dtau, K * nv, "K nv"},
       {"parameters.surfaces", parameters.surfaces, index(counts.surfaces), "3 n for n shapes, or empty"},
       {"parameters.placement", parameters.placement, index(counts.placement), "6 n for n shapes, or empty"},
       {"parameters.inertia", parameters.inertia, index(counts.inertia), "10 n_bodies, or empty"},
       {"parameters.geometry", parameters.geometry, index(counts.geometry), "6 n_bodies, or empty"}},
      {{"dq_out", dq_out, (K + 1) * nv, "(K + 1) nv"}, {"dv_out", dv_out, (K + 1) * nv, "(K + 1) nv"}});
  TangentContactSteps steps(model, shapes, q, v, K, step, monitor);
  Changes dq_k = as_eigen(dq), dv_k = as_eigen(dv);
  const auto column = [](Span x) { return x.empty() ? Changes() : Changes(as_eigen(x)); };
  const std::size_t n = index(counts.surfaces) / 3;
  ContactDirections along;
  if (n > 0) {
    along.friction = column(parameters.surfaces.first(n));
    along.restitution = column(parameters.surfaces.subspan(n, n));
    along.thickness = column(parameters.surfaces.last(n));
  }
  along.parameters = {column(parameters.inertia), column(parameters.geometry), column(parameters.placement)};
  std::ranges::copy(dq, dq_out.begin());
  std::ranges::copy(dv, dv_out.begin());
  for (std::size_t k = 0; k < K; ++k) {
    along.tau = as_eigen(dtau.subspan(k * nv, nv));
    if (!steps.run(tau.subspan(k * nv, nv), dq_k, dv_k, along)) break;
    std::copy_n(dq_k.data(), nv, dq_out.data() + (k + 1) * nv);
    std::copy_n(dv_k.data(), nv, dv_out.data() + (k + 1) * nv);
  }
  return finished(steps.result, {dq_out, dv_out});
}

ContactSensitivity contact_rollout_vjp(const Model& model, const ContactShapes& shapes, Span q, Span v,
                                       Span tau, double step, Span w_q, Span w_v,
                                       const RolloutGradients& gradient, const Monitor& monitor,
                                       const ContactParameters<double>& by_parameters) {
  const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv()),
                    K = steps_of(model, tau);
  const Counts counts(model, shapes, by_parameters);
  const ContactParameters<double>& by = by_parameters;
  check_motion(
      model, shapes, step,
      {{"q", q, nq, "nq"},
       {"v", v, nv, "nv"},
       {"tau", tau, K * nv, "K nv"},
       {"w_q", w_q, (K + 1) * nv, "(K + 1) nv"},
       {"w_v", w_v, (K + 1) * nv, "(K + 1) nv"}},
      {{"gradient.q", gradient.q, nv, "nv"},
       {"gradient.v", gradient.v, nv, "nv"},
       {"gradient.tau", gradient.tau, K * nv, "K nv"},
       {"gradient.geometry", gradient.geometry, 0, "empty: by_parameters.geometry receives it"},
       {"by_parameters.surfaces", by.surfaces, index(counts.surfaces), "3 n for n shapes, or empty"},
       {"by_parameters.placement", by.placement, index(counts.placement), "6 n for n shapes, or empty"},
       {"by_parameters.inertia", by.inertia, index(counts.inertia), "10 n_bodies, or empty"},
       {"by_parameters.geometry", by.geometry, index(counts.geometry), "6 n_bodies, or empty"}});
  TangentContactSteps steps(model, shapes, q, v, K, step, monitor);
  const Eigen::Index n = model.nv();
  std::vector<Changes> changes;  // (dq; dv) at the end of each step, 2nv rows
  const AllDirections along(n, counts);
  for (std::size_t k = 0; k < K; ++k) {
    Changes dq = along.dq, dv = along.dv;
    if (!steps.run(tau.subspan(k * nv, nv), dq, dv, along.others)) break;
    changes.emplace_back(2 * n, dq.cols());
    changes.back() << dq, dv;
  }
  if (steps.result.ok()) {
    const auto weights = [&](std::size_t k) {
      Eigen::VectorXd w(2 * n);
      w << as_eigen(w_q.subspan(k * nv, nv)), as_eigen(w_v.subspan(k * nv, nv));
      return w;
    };
    Eigen::VectorXd w = weights(K), all = Eigen::VectorXd::Zero(along.dq.cols());
    for (std::size_t k = K; k-- > 0;) {
      const Eigen::VectorXd of_step = changes[k].transpose() * w;
      as_eigen(gradient.tau.subspan(k * nv, nv)) = of_step.segment(2 * n, n);
      all += of_step;
      w = weights(k) + of_step.head(2 * n);
    }
    as_eigen(gradient.q) = w.head(n);
    as_eigen(gradient.v) = w.tail(n);
    const double* from = all.data() + 3 * n;
    for (const std::span<double> to : {by.surfaces, by.placement, by.inertia, by.geometry}) {
      std::copy_n(from, to.size(), to.data());
      from += to.size();
    }
  }
  return finished(steps.result,
                  {gradient.q, gradient.v, gradient.tau, by.surfaces, by.placement, by.inertia, by.geometry});
}

}  // namespace axode
