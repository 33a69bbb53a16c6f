#include "axode/integration/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "axode/dynamics/momentum.hpp"
#include "axode/integration/absolute_run.hpp"
#include "axode/integration/closed_midpoint.hpp"
#include "axode/integration/conserving.hpp"
#include "axode/integration/constrained_alpha.hpp"
#include "axode/integration/explicit_steps.hpp"
#include "axode/integration/generalized_alpha.hpp"
#include "axode/integration/half_explicit.hpp"
#include "axode/integration/phase_space.hpp"
#include "axode/integration/rattle.hpp"

namespace axode {
namespace {

using Vector = std::vector<double>;
using Span = std::span<const double>;

/// The same on Hamilton's side, what floats seen from its centre of mass.
class MomentumRun : public Run {
 public:
  MomentumRun(const Model& model, Span q_0, Span v_0, double until, const SimulationOptions& options)
      : Run(model, q_0, v_0, until, options),
        phase_space_(model),
        bases_(model, q_0.data(), v_0.data(), is_loaded()),
        q_t_(q_0.size()),
        v_t_(v_0.size()),
        p_(v_0.size()),
        none_(v_0.size()) {}

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
    const Span tau = in_joints(q_t_, v_t_);
    pushes_bases_ = is_loaded() || bases_.driven_by(tau.data());
    phase_space_.partials(q_t_.data(), v_t.data(), bases_.gravity(), tau, loads(), p.data(), f.data());
    return true;
  }
  bool factorize(double t, Span q_t) { return can(t, phase_space_.factorize(q_t.data())); }
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
    if (!velocity(t, q_t, p, v_t) || !partials(t, q_t, v_t, p_, f)) return false;
    if (!loops_) return true;
    return can(t, loops_->add_closing_forces(q_t_, v_t_, in_joints(q_t_, v_t_), loads(), f));
  }
  bool can(double t, const Solvability& found) { return found.ok() || stop(t, to_string(model_, found)); }
  /// Takes away of p what opens loops; and closes them.
  bool close(double t, Span q_t, Vector& p) {
    return !loops_ || loops_->close_momenta(q_t, p) || stop(t, open);
  }
  bool close_places(double t, Vector& q_t) { return !loops_ || loops_->close_places(q_t) || stop(t, open); }
  /// Whether anything but weight acted on a base in the last evaluation.
  bool pushes_bases() const { return pushes_bases_; }
  /// Takes the end of a step.
  bool take_momenta(double t, Span q_t, Span p) {
    Vector q_1(q_t.begin(), q_t.end()), v_1(p.size());
    if (!velocity(t, q_t, p, v_1)) return false;
    bases_.leave(t, q_1.data(), v_1.data());
    if (loops_) return take_closed(t, q_1, v_1);
    if (!begin_evaluation(t, q_1, v_1)) return false;  // M is factorised there: a = M⁻¹ (τ - h)
    const Span tau = in_joints(q_1, v_1);
    Vector a_1(p.size());
    inverse_dynamics(model_, workspace_, Span(q_1), v_1, none_, a_1, loads());
    for (std::size_t c = 0; c < a_1.size(); ++c) a_1[c] = tau[c] - a_1[c];
    solve(a_1);
    if (!finite(a_1)) return stop(t, "accelerations are not finite");
    return record(t, q_1, v_1, a_1);
  }

 private:
  bool is_loaded() const { return !options_.loads.empty() || options_.computed_loads; }

  PhaseSpace phase_space_;
  FloatingBases bases_;
  Vector q_t_, v_t_, p_, none_;
  bool pushes_bases_ = false;
};

/// f(run) in the coordinates asked for, and the motion.
template <class F>
Trajectory in_coordinates(const Model& model, Span q, Span v, double until, const SimulationOptions& options,
                          const F& f) {
  if (options.coordinates == Coordinates::relative) {
    Run run(model, q, v, until, options);
    f(run);
    return std::move(run.trajectory);
  }
  AbsoluteRun run(model, q, v, until, options);
  f(run);
  return std::move(run.trajectory);
}

/// For schemes on multipliers of places.
void check_holonomic(const Model& model) {
  for (const LoopRows& loop : model.loops().all)
    if (loop.rows != loop.residuals)
      throw std::invalid_argument("loop \"" + loop.name +
                                  "\" rolls, which a conserving scheme does not take; rattle in absolute "
                                  "coordinates and explicit methods do");
}
void check_absolute(const SimulationOptions& options, const char* scheme) {
  if (options.coordinates == Coordinates::relative)
    throw std::invalid_argument(std::string(scheme) + " is for absolute coordinates; these are relative");
}
void check_relative(const SimulationOptions& options, const char* scheme) {
  if (options.coordinates != Coordinates::relative)
    throw std::invalid_argument(std::string(scheme) +
                                " is for relative coordinates; in absolute ones RATTLE conserves");
}
/// Steps of a scheme that keeps joints and loops closed itself.
template <class Scheme> void take_closed_steps(AbsoluteRun& run, Scheme& scheme, double until, double step) {
  each_step(run, until, step, [&](double t_1) {
    const StepOutcome outcome = scheme.run(run.now(), t_1 - run.now());
    if (outcome == StepOutcome::diverged) run.stop(t_1, "the step did not converge; a shorter one may");
    return outcome == StepOutcome::found && run.take_closed(t_1, scheme.q, scheme.v);
  });
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
          ", a force that jumps, which conserving schemes do not take; rk4 and euler do");
}

}  // namespace

Trajectory simulate_fixed(const Model& model, Span q, Span v, double until, double step,
                          const Tableau& method, const SimulationOptions& options) {
  check(method), check_step(step);
  return in_coordinates(model, q, v, until, options,
                        [&](auto& run) { take_steps(run, until, step, method); });
}

Trajectory simulate_stiff(const Model& model, Span q, Span v, double until, double step, double rho,
                          const SimulationOptions& options, bool stabilized) {
  check_step(step);
  if (!(rho >= 0 && rho <= 1))
    throw std::invalid_argument("spectral radius is " + std::to_string(rho) + "; expected 0 to 1");
  if (options.coordinates != Coordinates::relative) {
    AbsoluteRun run(model, q, v, until, options);
    if (run.done()) return std::move(run.trajectory);
    ConstrainedAlpha<AbsoluteRun> scheme(run, rho, stabilized, run.q, run.v, run.a, run.lambda);
    take_closed_steps(run, scheme, until, step);
    return std::move(run.trajectory);
  }
  if (!stabilized) check_absolute(options, "generalised-alpha of index 3");
  Run run(model, q, v, until, options);
  GeneralizedAlpha scheme(run, model.tree<double>(), rho, run.a);
  using Outcome = GeneralizedAlpha<Run>::Outcome;
  const auto attempt = [&](double t_1, StepEnd& end) {
    const Outcome outcome = scheme.run(t_1, t_1 - run.now(), run.q, run.v, run.a);
    if (outcome == Outcome::diverged)
      run.stop(t_1, "Newton's method did not converge; a shorter step may help");
    if (outcome != Outcome::found) return false;
    end = {scheme.q, scheme.v, scheme.a};
    return run.can_hold(t_1, end);
  };
  StepEnd end;
  each_step(run, until, step, [&](double t_1) {
    while (run.now() < t_1 && !run.done()) {
      if (!attempt(t_1, end) || !run.take_up_to(t_1, end, attempt)) return false;
      run.friction_changed() ? scheme.begin(run.a) : scheme.go_on();
    }
    return true;
  });
  return std::move(run.trajectory);
}

Trajectory simulate_rattle(const Model& model, Span q, Span v, double until, double step, int order,
                           const SimulationOptions& options) {
  check_step(step), check_absolute(options, "RATTLE"), check_smooth(model, options);
  AbsoluteRun run(model, q, v, until, options);
  if (run.done()) return std::move(run.trajectory);
  Rattle scheme(run, order, run.q, run.v);
  take_closed_steps(run, scheme, until, step);
  return std::move(run.trajectory);
}

Trajectory simulate_half_explicit(const Model& model, Span q, Span v, double until, double step,
                                  const SimulationOptions& options) {
  check_step(step), check_absolute(options, "the half-explicit method");
  AbsoluteRun run(model, q, v, until, options);
  if (run.done()) return std::move(run.trajectory);
  HalfExplicit scheme(run, run.q, run.v);
  take_closed_steps(run, scheme, until, step);
  return std::move(run.trajectory);
}

Trajectory simulate_conserving(const Model& model, Span q, Span v, double until, double step, int order,
                               const SimulationOptions& options) {
  check_step(step), check_smooth(model, options), check_holonomic(model);
  check_relative(options, "a conserving scheme");
  MomentumRun run(model, q, v, until, options);
  if (run.done()) return std::move(run.trajectory);
  Vector q_0, v_0, p_0;
  run.enter(q_0, v_0, p_0);
  const auto take = [&](auto part) {
    ConservingStep scheme(run, std::move(part), order, q_0, p_0, v_0);
    using Outcome = Midpoint<MomentumRun>::Outcome;
    each_step(run, until, step, [&](double t_1) {
      const Outcome outcome = scheme.run(run.now(), t_1 - run.now());
      if (outcome == Outcome::diverged) run.stop(t_1, "the step did not converge; a shorter one may");
      return outcome == Outcome::found && run.take_momenta(t_1, scheme.q, scheme.p);
    });
  };
  if (model.loops().empty())
    take(Midpoint<MomentumRun>(run, model.tree<double>()));
  else
    take(ClosedMidpoint<MomentumRun>(run, model));
  return std::move(run.trajectory);
}

Trajectory simulate_momenta(const Model& model, Span q, Span v, double until, double step,
                            const Tableau& method, const SimulationOptions& options) {
  check(method), check_step(step), check_smooth(model, options);
  check_relative(options, "a scheme on momenta");
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
    if (!run.close_places(t_1, q_1)) return false;
    bases.settle(q_1.data());
    bases.to_momenta(q_1.data(), y.data(), p.data());
    const Vector before = p;
    if (!run.close(t_1, q_1, p)) return false;
    for (std::size_t c = 0; c < p.size(); ++c) y[c] += p[c] - before[c];  // which is 0 of what floats
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
  return in_coordinates(model, q, v, until, options,
                        [&](auto& run) { take_adapted_steps(run, until, tolerances); });
}

}  // namespace axode
