#include "axode/integration/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "axode/derivatives/spring_derivatives.hpp"
#include "axode/dynamics/check_loads.hpp"
#include "axode/dynamics/forward_dynamics.hpp"
#include "axode/dynamics/inverse_dynamics.hpp"
#include "axode/dynamics/momentum.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/integration/closed_motion.hpp"
#include "axode/integration/conserving.hpp"
#include "axode/integration/generalized_alpha.hpp"
#include "axode/integration/munthe_kaas.hpp"
#include "axode/integration/phase_space.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/finite.hpp"
#include "axode/model/workspace.hpp"

namespace axode {
namespace {

using Vector = std::vector<double>;
using Span = std::span<const double>;

/// What all schemes share: the motion so far, accelerations, events.
class Run {
 public:
  Run(const Model& model, Span q_0, Span v_0, double until, const SimulationOptions& options)
      : trajectory(model),
        q(q_0.begin(), q_0.end()),
        v(v_0.begin(), v_0.end()),
        a(v_0.size()),
        model_(model),
        options_(options),
        workspace_(model),
        tau_(v_0.size()),
        total_(v_0.size()),
        until_(until) {
    if (!model.loops().empty()) loops_.emplace(model);
    check_configuration(model, q);
    check_size("v", v.size(), static_cast<std::size_t>(model.nv()), "nv");
    if (!finite(v)) throw std::invalid_argument("v has numbers that are not finite");
    if (!(until >= 0) || !std::isfinite(until))
      throw std::invalid_argument("until is " + std::to_string(until) + "; expected a time of 0 s or more");
    check_loads(model, loads());
    if (loops_) loops_->check(q, v);
    if (!accelerate(0, q, v, a)) return;
    trajectory.append(0, q, v, a, tau_);
    values_ = values_at(0, q, v);
  }

  /// Accelerations under what acts; false, with the reason kept, where there are none.
  bool accelerate(double t, Span q_t, Span v_t, std::span<double> a_t) {
    if (!begin_evaluation(t, q_t, v_t)) return false;
    const Span tau = with_springs(q_t, v_t);
    const Solvability found = loops_ ? loops_->accelerate(q_t, v_t, tau, loads(), a_t)
                                     : forward_dynamics(model_, workspace_, q_t, v_t, tau, a_t, loads());
    if (!found.ok()) return stop(t, to_string(model_, found));
    return true;
  }

  /// ID(q, v, a) - tau, which is 0 where a is the acceleration; false, with the reason kept, where it is not finite.
  bool residual(double t, Span q_t, Span v_t, Span a_t, std::span<double> r) {
    ++trajectory.evaluations;
    if (!finite(q_t) || !finite(v_t) || !finite(a_t)) return stop(t, "the state is not finite");
    inverse_dynamics(model_, workspace_, q_t, v_t, a_t, r, loads());
    if (options_.drive) options_.drive(t, q_t, v_t, tau_);
    const Span tau = with_springs(q_t, v_t);
    for (std::size_t c = 0; c < r.size(); ++c) r[c] -= tau[c];
    return finite(r) || stop(t, "forces are not finite at " + joint_of(r));
  }
  /// Its derivatives, without those of the drive: by q, v and a.
  void residual_derivatives(Span q_t, Span v_t, Span a_t, const InverseDynamicsDerivatives<double>& dr) {
    inverse_dynamics_derivatives(model_, workspace_, q_t, v_t, a_t, dr, loads());
    if (model_.springs().empty()) return;
    Vector by_q(dr.q.size()), by_v(dr.v.size());
    spring_force_derivatives(model_, workspace_, q_t, v_t, {by_q, by_v});
    for (std::size_t k = 0; k < by_q.size(); ++k) dr.q[k] -= by_q[k], dr.v[k] -= by_v[k];
  }
  bool is_driven() const { return static_cast<bool>(options_.drive); }
  /// tau of the drive.
  Span drive(double t, Span q_t, Span v_t) {
    options_.drive(t, q_t, v_t, tau_);
    return tau_;
  }

  /// Takes the end of a step, with the acceleration there where it is known; false where the motion ends. Loops are
  /// closed again, which changes it a little.
  bool take(double t, Span q_end, Span v_end, Span known = {}) {
    Vector q_1(q_end.begin(), q_end.end()), v_1(v_end.begin(), v_end.end()), a_1(known.begin(), known.end());
    if (loops_ && !loops_->close(q_1, v_1))
      return stop(t, "the loops cannot be kept closed; a shorter step may help");
    if (loops_ || known.size() != v_1.size()) {
      a_1.resize(v_1.size());
      if (!accelerate(t, q_1, v_1, a_1)) return false;
    }
    const double before = trajectory.t().back();
    trajectory.append(t, q_1, v_1, a_1, tau_);
    ++trajectory.steps;
    q = q_1, v = v_1, a = a_1;
    if (!options_.events.empty() && meets_end(before, t)) return false;
    if (options_.monitor && !options_.monitor(t)) return stop(t, "it was interrupted");
    return true;
  }
  bool stop(double t, const std::string& why) {
    trajectory.complete = false;
    trajectory.stopped = "at t = " + std::to_string(t) + " s: " + why;
    return false;
  }
  bool done() const { return trajectory.size() == 0 || ended_ || !trajectory.complete || now() >= until_; }
  double now() const { return trajectory.t().back(); }
  /// accelerate() as schemes call it.
  auto accelerations() {
    return
        [this](double t, Span q_t, Span v_t, std::span<double> a_t) { return accelerate(t, q_t, v_t, a_t); };
  }

  Trajectory trajectory;
  Vector q, v, a;  ///< now

 protected:
  /// tau of the drive, and of the springs of the model.
  Span with_springs(Span q_t, Span v_t) {
    if (model_.springs().empty()) return tau_;
    total_.assign(tau_.begin(), tau_.end());
    add_spring_forces(model_, workspace_, q_t, v_t, total_);
    return total_;
  }
  Loads<double> loads() const { return {options_.loads, options_.joint_losses}; }

  /// Drive forces at a state, and whether all is finite.
  bool begin_evaluation(double t, Span q_t, Span v_t) {
    ++trajectory.evaluations;
    if (!finite(q_t) || !finite(v_t)) return stop(t, "the state is not finite at " + joint_of(v_t));
    if (!options_.drive) return true;
    options_.drive(t, q_t, v_t, tau_);
    return finite(tau_) || stop(t, "the drive forces are not finite at " + joint_of(tau_));
  }
  std::string joint_of(Span x) const {
    for (std::size_t c = 0; c < x.size(); ++c)
      if (!std::isfinite(x[c])) return "joint \"" + velocity_names(model_)[c] + "\"";
    return "a joint";
  }

  const Model& model_;
  const SimulationOptions& options_;
  Workspace<> workspace_;
  std::optional<ClosedMotion> loops_;
  Vector tau_, total_;

 private:
  Vector values_at(double t, Span q_t, Span v_t) const {
    Vector values;
    for (const Event& event : options_.events) values.push_back(event.value(t, q_t, v_t));
    return values;
  }
  /// Looks for events between two times, the last step; where one is terminal the trajectory is cut off there.
  bool meets_end(double before, double after) {
    const Vector next = values_at(after, q, v);
    std::vector<Trajectory::Met> met;
    Vector q_t(q.size()), v_t(v.size());
    for (std::size_t e = 0; e < next.size(); ++e) {
      const Event& event = options_.events[e];
      if ((values_[e] < 0) == (next[e] < 0) || values_[e] == 0) continue;
      if (event.direction != 0 && (next[e] > values_[e]) != (event.direction > 0)) continue;
      double low = before, high = after;
      for (int k = 0; k < 60 && high - low > 1e-15 * std::max(1.0, std::abs(after)); ++k) {
        const double middle = low + (high - low) / 2;
        trajectory.at(middle, q_t, v_t);
        ((event.value(middle, q_t, v_t) < 0) == (values_[e] < 0) ? low : high) = middle;
      }
      met.push_back({e, high});
    }
    values_ = next;
    std::ranges::sort(met, {}, &Trajectory::Met::t);
    for (const Trajectory::Met& one : met) {
      trajectory.events.push_back(one);
      if (!options_.events[one.event].terminal) continue;
      ended_ = true;
      trajectory.at(one.t, q_t, v_t);
      trajectory.take_back();
      if (loops_ && !loops_->close(q_t, v_t)) return !stop(one.t, "the loops cannot be kept closed");
      Vector a_t(v_t.size());
      if (accelerate(one.t, q_t, v_t, a_t)) trajectory.append(one.t, q_t, v_t, a_t, tau_);
      return true;
    }
    return false;
  }

  Vector values_;
  double until_;
  bool ended_ = false;
};

/// The same on Hamilton's side, what floats seen from its centre of mass.
class MomentumRun : public Run {
 public:
  MomentumRun(const Model& model, Span q_0, Span v_0, double until, const SimulationOptions& options)
      : Run(model, q_0, v_0, until, options),
        phase_space_(model),
        bases_(model, q_0.data(), v_0.data(), !options.loads.empty()),
        q_t_(q_0.size()),
        v_t_(v_0.size()),
        p_(v_0.size()) {}

  FloatingBases& bases() { return bases_; }
  /// The start: q, v and p = M v, against the frames of the bases.
  void enter(Vector& q_0, Vector& v_0, Vector& p_0) {
    q_0 = q, v_0 = v, p_0.resize(v.size());
    bases_.enter(0, q_0.data(), v_0.data());
    momenta(model_, workspace_, Span(q_0), v_0, p_0);
  }

  /// p = M v and f = τ + ∂L/∂q; false, with the reason kept, where there are none.
  bool partials(double t, Span q_t, Span v_t, Vector& p, std::span<double> f) {
    q_t_.assign(q_t.begin(), q_t.end()), v_t_.assign(v_t.begin(), v_t.end());
    bases_.leave(t, q_t_.data(), v_t_.data());
    if (!begin_evaluation(t, q_t_, v_t_)) return false;
    const Span tau = with_springs(q_t_, v_t_);
    pushes_bases_ = !options_.loads.empty() || bases_.driven_by(tau.data());
    phase_space_.partials(q_t_.data(), v_t.data(), bases_.gravity(), tau, loads(), p.data(), f.data());
    return true;
  }
  bool factorize(double t, Span q_t) {
    const Solvability found = phase_space_.factorize(q_t.data());
    return found.ok() || stop(t, to_string(model_, found));
  }
  void solve(std::span<double> x) { phase_space_.solve(x.data()); }
  /// v of a state (q, p).
  bool velocity(double t, Span q_t, Span p, std::span<double> v_t) {
    if (!factorize(t, q_t)) return false;
    std::ranges::copy(p, v_t.begin());
    solve(v_t);
    return finite(v_t) || stop(t, "the state is not finite at " + joint_of(v_t));
  }
  /// v, and p' less ad_vᵀ p.
  bool rates(double t, Span q_t, Span p, std::span<double> v_t, std::span<double> f) {
    return velocity(t, q_t, p, v_t) && partials(t, q_t, v_t, p_, f);
  }
  /// Whether anything but weight acted on a base in the last evaluation.
  bool pushes_bases() const { return pushes_bases_; }
  /// Takes the end of a step.
  bool take_momenta(double t, Span q_t, Span p) {
    Vector q_1(q_t.begin(), q_t.end()), v_1(p.size());
    if (!velocity(t, q_t, p, v_1)) return false;
    bases_.leave(t, q_1.data(), v_1.data());
    return take(t, q_1, v_1);
  }

 private:
  PhaseSpace phase_space_;
  FloatingBases bases_;
  Vector q_t_, v_t_, p_;
  bool pushes_bases_ = false;
};

/// For schemes that know of no loops.
void check_open(const Model& model, const char* scheme) {
  if (!model.loops().empty())
    throw std::invalid_argument("model \"" + model.name() + "\" has loops, which " + scheme +
                                " does not keep closed; explicit methods (dopri5, rk4) do");
}

/// Conserving schemes are for forces without jumps, in steps of one length.
void check_smooth(const Model& model, const SimulationOptions& options) {
  if (!options.events.empty())
    throw std::invalid_argument(
        "events are not met by conserving schemes, whose steps must not be cut; dopri5 and rk4 do");
  for (const int i : model.springs().joints)
    for (const Dof& dof : model.joint(i).dof)
      if (dof.stop_stiffness > 0)
        throw std::invalid_argument("joint \"" + model.joint(i).name +
                                    "\" has stops, which conserving schemes do not take; dopri5 and rk4 do");
  if (!options.joint_losses) return;
  const Tree<double>& tree = model.tree<double>();
  for (std::size_t c = 0; c < tree.friction.size(); ++c)
    if (tree.friction[c] != 0)
      throw std::invalid_argument(
          "joint \"" + velocity_names(model)[c] + "\" has dry friction of " +
          std::to_string(tree.friction[c]) +
          ", a force that jumps, which conserving schemes do not take; dopri5 and rk4 do");
}

/// Steps of one length from 0 on, the last as long as is left; take(t_1) goes to t_1 and says whether to go on.
template <class Take> void each_step(const Run& run, double until, double step, const Take& take) {
  const double whole = std::ceil(until / step - 1e-9);
  for (double k = 1; k <= whole && !run.done(); ++k)
    if (!take(k == whole ? until : k * step)) break;
}

}  // namespace

Trajectory simulate_fixed(const Model& model, Span q, Span v, double until, double step,
                          const Tableau& method, const SimulationOptions& options) {
  check(method), check_step(step);
  Run run(model, q, v, until, options);
  MuntheKaas scheme(model.tree<double>(), method);
  const ConfigurationGroup<double> group(model.tree<double>());
  Vector q_1(run.q.size());
  each_step(run, until, step, [&](double t_1) {
    const double t = run.now();
    if (!scheme.run(t, run.q.data(), run.v.data(), run.a.data(), t_1 - t, run.accelerations())) return false;
    group.move(run.q.data(), scheme.theta.data(), q_1.data());
    return run.take(t_1, q_1, scheme.y, scheme.end());
  });
  return std::move(run.trajectory);
}

Trajectory simulate_stiff(const Model& model, Span q, Span v, double until, double step, double rho,
                          const SimulationOptions& options) {
  check_step(step), check_open(model, "generalised-alpha");
  if (!(rho >= 0 && rho <= 1))
    throw std::invalid_argument("spectral radius is " + std::to_string(rho) + "; expected 0 to 1");
  Run run(model, q, v, until, options);
  GeneralizedAlpha scheme(run, model.tree<double>(), rho, run.a);
  using Outcome = GeneralizedAlpha<Run>::Outcome;
  each_step(run, until, step, [&](double t_1) {
    const Outcome outcome = scheme.run(t_1, t_1 - run.now(), run.q, run.v, run.a);
    if (outcome == Outcome::diverged)
      run.stop(t_1, "Newton's method did not converge; a shorter step may help");
    return outcome == Outcome::found && run.take(t_1, scheme.q, scheme.v, scheme.a);
  });
  return std::move(run.trajectory);
}

Trajectory simulate_conserving(const Model& model, Span q, Span v, double until, double step, int order,
                               const SimulationOptions& options) {
  check_step(step), check_smooth(model, options), check_open(model, "a conserving scheme");
  MomentumRun run(model, q, v, until, options);
  if (run.done()) return std::move(run.trajectory);
  Vector q_0, v_0, p_0;
  run.enter(q_0, v_0, p_0);
  ConservingStep scheme(run, model.tree<double>(), order, q_0, p_0, v_0);
  using Outcome = ConservingStep<MomentumRun>::Outcome;
  each_step(run, until, step, [&](double t_1) {
    const Outcome outcome = scheme.run(run.now(), t_1 - run.now());
    if (outcome == Outcome::diverged) run.stop(t_1, "the step did not converge; a shorter one may");
    return outcome == Outcome::found && run.take_momenta(t_1, scheme.q, scheme.p);
  });
  return std::move(run.trajectory);
}

Trajectory simulate_momenta(const Model& model, Span q, Span v, double until, double step,
                            const Tableau& method, const SimulationOptions& options) {
  check(method), check_step(step), check_smooth(model, options), check_open(model, "a scheme on momenta");
  MomentumRun run(model, q, v, until, options);
  if (run.done()) return std::move(run.trajectory);
  FloatingBases& bases = run.bases();
  MuntheKaas scheme(model.tree<double>(), method);
  const ConfigurationGroup<double> group(model.tree<double>());
  Vector q_1, v_1, y;
  run.enter(q_1, v_1, y);
  Vector p(y), turning(y), dy(y);
  bases.begin(q_1.data(), y.data());
  const auto rates = [&](double t, Span q_t, Span y_t, std::span<double> v_t, std::span<double> dy_t) {
    p.assign(y_t.begin(), y_t.end());
    bases.to_momenta(q_t.data(), y_t.data(), p.data());
    if (!run.rates(t, q_t, p, v_t, dy_t)) return false;
    group.cobracket(v_t.data(), p.data(), turning.data());
    for (std::size_t c = 0; c < p.size(); ++c) turning[c] += dy_t[c];
    bases.rates(q_t.data(), run.pushes_bases(), dy_t.data(), turning.data());
    std::ranges::copy(turning, dy_t.begin());
    return true;
  };
  each_step(run, until, step, [&](double t_1) {
    const double t = run.now();
    if (!rates(t, q_1, y, v_1, dy) ||
        !scheme.run(t, q_1.data(), y.data(), v_1.data(), dy.data(), t_1 - t, rates))
      return false;
    group.move(q_1.data(), scheme.theta.data(), q_1.data());
    y = p = scheme.y;
    bases.settle(q_1.data());
    bases.to_momenta(q_1.data(), y.data(), p.data());
    return run.take_momenta(t_1, q_1, p);
  });
  return std::move(run.trajectory);
}

Trajectory simulate(const Model& model, Span q, Span v, double until, const Tolerances& tolerances,
                    const SimulationOptions& options) {
  for (const auto& [name, x] : {std::pair{"relative tolerance", tolerances.relative},
                                {"absolute tolerance", tolerances.absolute},
                                {"first step", tolerances.first_step},
                                {"largest step", tolerances.largest_step}})
    if (!(x >= 0) || !std::isfinite(x))
      throw std::invalid_argument(std::string(name) + " is " + std::to_string(x) + "; expected 0 or more");
  if (tolerances.relative == 0 && tolerances.absolute == 0)
    throw std::invalid_argument("both tolerances are 0; one must be more");
  const Tableau& method = runge_kutta(5);
  Run run(model, q, v, until, options);
  MuntheKaas scheme(model.tree<double>(), method);
  const ConfigurationGroup<double> group(model.tree<double>());
  const std::size_t nv = run.v.size();
  const auto mean = [&](const auto& of) {
    double squares = 0;
    for (std::size_t c = 0; c < nv; ++c) squares += of(c) * of(c);
    return nv == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(2 * nv));
  };
  const double most = tolerances.largest_step > 0 ? tolerances.largest_step : until;
  double h = tolerances.first_step;
  if (!(h > 0)) {  // in which little happens
    double rate = 1e-3;
    for (std::size_t c = 0; c < nv; ++c)
      rate = std::max({rate, std::abs(run.v[c]), std::sqrt(std::abs(run.a[c]))});
    h = 0.01 / rate;
  }
  double last_error = 1e-4;
  Vector q_1(run.q.size());
  while (!run.done()) {
    const double t = run.now(), rest = until - t;
    h = std::min({h, most, rest});
    const bool last = h >= rest * (1 - 1e-12);
    if (!last && !(h > 1e-15 * until)) {
      run.stop(t, "the step became too short for the tolerances");
      break;
    }
    if (!scheme.run(t, run.q.data(), run.v.data(), run.a.data(), h, run.accelerations())) {
      if (h < 1e-9 * until) break;
      run.trajectory.complete = true, run.trajectory.stopped.clear();  // perhaps the step was too long
      ++run.trajectory.rejected;
      h *= 0.1;
      continue;
    }
    const double error = std::hypot(
        mean([&](std::size_t c) {
          return scheme.error_theta[c] /
                 (tolerances.absolute + tolerances.relative * std::max(1.0, std::abs(scheme.theta[c])));
        }),
        mean([&](std::size_t c) {
          return scheme.error_y[c] /
                 (tolerances.absolute +
                  tolerances.relative * std::max(std::abs(run.v[c]), std::abs(scheme.y[c])));
        }));
    if (!(error <= 1)) {
      ++run.trajectory.rejected;
      h *= std::isfinite(error) ? std::max(0.2, 0.9 * std::pow(error, -0.2)) : 0.1;
      continue;
    }
    group.move(run.q.data(), scheme.theta.data(), q_1.data());
    if (!run.take(last ? until : t + h, q_1, scheme.y, scheme.end())) break;
    const double least = std::max(error, 1e-10);
    h *= std::clamp(0.9 * std::pow(least, -0.17) * std::pow(last_error, 0.04), 0.2, 10.0);
    last_error = std::max(error, 1e-4);
  }
  return std::move(run.trajectory);
}

}  // namespace axode
