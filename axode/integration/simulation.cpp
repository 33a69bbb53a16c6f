#include "axode/integration/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "axode/integration/methods.hpp"
#include "axode/integration/runs/absolute_simulation_run.hpp"
#include "axode/integration/runs/momentum_simulation_run.hpp"
#include "axode/integration/schemes/closed_midpoint.hpp"
#include "axode/integration/schemes/constrained_alpha.hpp"
#include "axode/integration/schemes/explicit_steps.hpp"
#include "axode/integration/schemes/generalized_alpha.hpp"
#include "axode/integration/schemes/half_explicit.hpp"
#include "axode/integration/schemes/rattle.hpp"
#include "axode/integration/schemes/symplectic_step.hpp"
#include "axode/scalar/text.hpp"

namespace axode {
namespace {

using Span = std::span<const double>;

/// Throws std::invalid_argument for couplings with play, unsupported by `scheme`.
void check_no_plays(const Model& model, const char* scheme) {
  if (!model.loops().backlashes.empty())
    throw std::invalid_argument(
        "coupling \"" + model.loops().backlashes[0].name + "\" has play, which " + scheme +
        " do not count; use dopri5, rk4 or generalized_alpha in relative coordinates");
}

/// Calls f(run) with a simulation run in the coordinates of the options, and returns the resulting motion.
template <class F>
Trajectory in_coordinates(const Model& model, Span q, Span v, double until, const SimulationOptions& options,
                          const F& f) {
  if (options.coordinates == Coordinates::relative) {
    SimulationRun run(model, q, v, until, options);
    f(run);
    return std::move(run.trajectory);
  }
  check_no_plays(model, "absolute coordinates");
  AbsoluteSimulationRun run(model, q, v, until, options);
  f(run);
  return std::move(run.trajectory);
}

/// The names of symplectic methods by their order, as in `methods`.
std::string symplectic_method(int order) {
  return order == 6 ? "kahan_li6" : order == 4 ? "suzuki4" : "midpoint";
}
std::string rattle_method(int order) {
  return order == 4 || order == 6 ? "rattle_" + symplectic_method(order) : "rattle";
}

/// Throws std::invalid_argument if a loop has rows without a residual, as rolling contacts and belts have.
void check_holonomic(const Model& model, const std::string& method) {
  for (const Loop& loop : model.loops().joints)
    if (loop.rows != loop.residuals)
      throw std::invalid_argument(
          "loop \"" + loop.name + "\" is of kind \"" + std::string(to_string(loop.kind)) +
          "\", which method \"" + method +
          "\" does not support; use rattle in absolute coordinates or an explicit method");
}
void check_absolute(const SimulationOptions& options, const char* scheme) {
  if (options.coordinates == Coordinates::relative)
    throw std::invalid_argument(std::string(scheme) + " needs coordinates = \"absolute\"; got \"relative\"");
}
void check_exponential(const SimulationOptions& options, const char* scheme) {
  if (options.local_coordinates != LocalCoordinates::exponential)
    throw std::invalid_argument(std::string(scheme) +
                                " in absolute coordinates needs local_coordinates = \"exponential\"; got "
                                "\"cayley\"");
}
void check_relative(const SimulationOptions& options, const std::string& method) {
  if (options.coordinates != Coordinates::relative)
    throw std::invalid_argument("method \"" + method + "\" needs coordinates = \"relative\"; got \"" +
                                std::string(to_string(options.coordinates)) +
                                "\"; in absolute coordinates use rattle");
}
/// Takes the steps of a scheme in absolute coordinates that keeps joints and loops closed itself.
template <class Scheme>
void take_closed_steps(AbsoluteSimulationRun& run, Scheme& scheme, double until, double step) {
  each_part(run, until, step, [&](double t_1) {
    if (Failure failure = scheme.run(run.now(), t_1 - run.now())) return failure;
    return run.take_closed(t_1, scheme.q, scheme.v, scheme.drive_states);
  });
}

/// Throws std::invalid_argument for forces that may jump (elastic stops, dry friction, gears with losses),
/// and for events, which would cut a step.
void check_smooth(const Model& model, const SimulationOptions& options, const std::string& method) {
  if (!options.events.empty())
    throw std::invalid_argument("events: method \"" + method +
                                "\" does not support them, because its steps must not be cut; use dopri5 or "
                                "rk4");
  for (const int i : model.springs().joints)
    for (const Dof& dof : model.joint(i).dof)
      if (dof.stop_stiffness > 0)
        throw std::invalid_argument("joint \"" + model.joint(i).name + "\" has stops, which method \"" +
                                    method + "\" does not support; use dopri5 or rk4");
  if (!options.joint_losses) return;
  if (!model.gears().empty())
    throw std::invalid_argument(
        "the gear of joint \"" + velocity_names(model)[static_cast<std::size_t>(model.gears()[0].velocity)] +
        "\" loses a part of its force, which method \"" + method + "\" does not support; use dopri5 or rk4");
  const Tree<double>& tree = model.tree<double>();
  for (std::size_t c = 0; c < tree.friction.size(); ++c)
    if (tree.friction[c] != 0)
      throw std::invalid_argument("joint \"" + velocity_names(model)[c] + "\" has dry friction of " +
                                  to_text(tree.friction[c]) + ", a discontinuous force, which method \"" +
                                  method + "\" does not support; use rk4 or euler");
}

}  // namespace

Trajectory simulate_fixed(const Model& model, Span q, Span v, double until, double step,
                          const Tableau& method, const SimulationOptions& options) {
  check(method);
  check_step(step);
  return in_coordinates(model, q, v, until, options,
                        [&](auto& run) { take_steps(run, until, step, method); });
}

Trajectory simulate_stiff(const Model& model, Span q, Span v, double until, double step, double rho,
                          const SimulationOptions& options, bool stabilized) {
  check_step(step);
  if (!(rho >= 0 && rho <= 1))
    throw std::invalid_argument("spectral radius is " + to_text(rho) + "; expected 0 to 1");
  if (options.coordinates != Coordinates::relative) {
    check_no_plays(model, "absolute coordinates");
    check_exponential(options, "generalised-alpha");
    AbsoluteSimulationRun run(model, q, v, until, options);
    if (run.done()) return std::move(run.trajectory);
    ConstrainedAlpha<AbsoluteSimulationRun> scheme(run, rho, stabilized, run.q, run.v, run.a, run.lambda);
    DriveStates& drives = run.drives();
    drives.restart();
    each_part(run, until, step, [&](double t_1) {
      drives.begin_implicit_step(t_1 - run.now(), rho);
      if (Failure failure = scheme.run(run.now(), t_1 - run.now())) return failure;
      if (Failure failure = run.take_closed(t_1, scheme.q, scheme.v, as_eigen(drives.states())))
        return failure;
      drives.accept_implicit_step();
      if (run.done()) return Failure{};
      Failure failure = run.switch_drives();
      if (run.accelerations_jumped()) {
        scheme.restart(run.a);
        drives.restart();
      }
      return failure;
    });
    return std::move(run.trajectory);
  }
  if (!stabilized) check_absolute(options, "generalised-alpha of index 3");
  SimulationRun run(model, q, v, until, options);
  GeneralizedAlpha scheme(run, model.tree<double>(), rho, run.a);
  DriveStates& drives = run.drives();
  drives.restart();
  const Attempt attempt = [&](double t_1, StepEnd& end) {
    drives.begin_implicit_step(t_1 - run.now(), rho);
    if (Failure failure = scheme.run(t_1, t_1 - run.now(), run.q, run.v, run.a)) return failure;
    end = {scheme.q, scheme.v, scheme.a, as_eigen(drives.states()), as_eigen(drives.rates())};
    return run.check_sticking(t_1, end);
  };
  StepEnd end;
  each_step(run, until, step, [&](double t_1) {
    return take_until(run, t_1, end, attempt, [&] {
      if (run.accelerations_jumped()) {
        scheme.restart(run.a);
        drives.restart();
      } else {
        scheme.accept();
        drives.accept_implicit_step();
      }
    });
  });
  return std::move(run.trajectory);
}

Trajectory simulate_rattle(const Model& model, Span q, Span v, double until, double step, int order,
                           const SimulationOptions& options) {
  check_step(step);
  check_absolute(options, "RATTLE");
  check_no_plays(model, "absolute coordinates");
  check_exponential(options, "RATTLE");
  check_smooth(model, options, rattle_method(order));
  AbsoluteSimulationRun run(model, q, v, until, options);
  if (run.done()) return std::move(run.trajectory);
  Rattle scheme(run, order, run.q, run.v);
  take_closed_steps(run, scheme, until, step);
  return std::move(run.trajectory);
}

Trajectory simulate_half_explicit(const Model& model, Span q, Span v, double until, double step,
                                  const SimulationOptions& options) {
  check_step(step);
  check_absolute(options, "the half-explicit method");
  check_no_plays(model, "absolute coordinates");
  check_exponential(options, "the half-explicit method");
  AbsoluteSimulationRun run(model, q, v, until, options);
  if (run.done()) return std::move(run.trajectory);
  HalfExplicit scheme(run, run.q, run.v);
  take_closed_steps(run, scheme, until, step);
  return std::move(run.trajectory);
}

Trajectory simulate_symplectic(const Model& model, Span q, Span v, double until, double step, int order,
                               const SimulationOptions& options) {
  check_step(step);
  const std::string method = symplectic_method(order);
  check_smooth(model, options, method);
  check_holonomic(model, method);
  check_relative(options, method);
  check_no_plays(model, "schemes on momenta");
  MomentumSimulationRun run(model, q, v, until, options);
  if (run.done()) return std::move(run.trajectory);
  Eigen::VectorXd q_0, v_0, p_0;
  run.initial_state(q_0, v_0, p_0);
  const auto take = [&](auto part) {
    SymplecticStep scheme(run, std::move(part), order, q_0, p_0, v_0);
    each_part(run, until, step, [&](double t_1) {
      if (Failure failure = scheme.run(run.now(), t_1 - run.now())) return failure;
      return run.take_momenta(t_1, scheme.q, scheme.p, scheme.drive_states);
    });
  };
  if (run.closed_model().loops().empty())
    take(Midpoint<MomentumSimulationRun>(run, model.tree<double>()));
  else
    take(ClosedMidpoint<MomentumSimulationRun>(run));
  return std::move(run.trajectory);
}

Trajectory simulate_momenta(const Model& model, Span q, Span v, double until, double step,
                            const Tableau& method, const SimulationOptions& options) {
  check(method);
  check_step(step);
  check_smooth(model, options, "rk4_momenta");
  check_relative(options, "rk4_momenta");
  check_no_plays(model, "schemes on momenta");
  MomentumSimulationRun run(model, q, v, until, options);
  if (run.done()) return std::move(run.trajectory);
  FloatingBases& bases = run.bases();
  DriveStates& drives = run.drives();
  MuntheKaas scheme(model.tree<double>(), method, options.local_coordinates, drives.size());
  const ConfigurationGroup<double> group = run.group();
  Eigen::VectorXd q_1, v_1, p;
  run.initial_state(q_1, v_1, p);
  const Eigen::Index nv = p.size(), nx = drives.x.size();
  Eigen::VectorXd q_i, v_i, dp = p, y(nv + nx),
                            dy = y;  // y contains the momenta, and then the states of the drives
  y.head(nv) = p;
  bases.begin(q_1.data(), y.data());
  Failure failure;
  const auto rates = [&](double t, Span q_t, Span y_t, std::span<double> v_t, std::span<double> dy_t) {
    q_i = as_eigen(q_t);
    p = as_eigen(y_t).head(nv);
    bases.to_momenta(q_t.data(), y_t.data(), p.data());
    drives.act_at(y_t.subspan(p.size()));
    failure = run.rates(t, q_i, p, v_i, dp);
    if (failure) return false;
    as_eigen(v_t) = v_i;
    group.ad_transpose(v_i, p, dy_t.first(v_t.size()));
    as_eigen(dy_t).head(nv) += dp;
    as_eigen(dy_t).tail(nx) = as_eigen(drives.rates());
    bases.rates(q_t.data(), run.pushes_bases(), dp.data(), dy_t.data());
    return true;
  };
  each_part(run, until, step, [&](double t_1) {
    const double t = run.now();
    y.tail(nx) = drives.x;
    if (!rates(t, as_span(q_1), as_span(y), as_span(v_1), as_span(dy)) ||
        !scheme.run(t, q_1.data(), y.data(), v_1.data(), dy.data(), t_1 - t, rates))
      return failure;
    group.move(q_1, scheme.theta, q_1);
    y = as_eigen(scheme.y);
    p = y.head(nv);
    failure = run.close_places(t_1, q_1);
    if (failure) return failure;
    bases.restore_centers(q_1.data());
    bases.to_momenta(q_1.data(), y.data(), p.data());
    const Eigen::VectorXd before = p;
    failure = run.close(t_1, q_1, p);
    if (failure) return failure;
    y.head(nv) += p - before;  // the states of floating bases do not change
    return run.take_momenta(t_1, q_1, p, y.tail(nx));
  });
  return std::move(run.trajectory);
}

void check_tolerances(const Tolerances& tolerances) {
  for (const auto& [name, x] : {std::pair{"relative tolerance", tolerances.relative},
                                {"absolute tolerance", tolerances.absolute},
                                {"first step", tolerances.first_step},
                                {"largest step", tolerances.largest_step}})
    if (!(x >= 0) || !std::isfinite(x))
      throw std::invalid_argument(std::string(name) + " is " + to_text(x) +
                                  "; expected a finite number, 0 or more");
  if (tolerances.relative == 0 && tolerances.absolute == 0)
    throw std::invalid_argument("relative and absolute tolerance are 0; at least one must be positive");
}

Trajectory simulate(const Model& model, Span q, Span v, double until, const Tolerances& tolerances,
                    const SimulationOptions& options) {
  check_tolerances(tolerances);
  return in_coordinates(model, q, v, until, options,
                        [&](auto& run) { take_adapted_steps(run, until, tolerances); });
}

}  // namespace axode
