#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "axode/integration/runs/simulation_run.hpp"
#include "axode/integration/schemes/anderson_iteration.hpp"
#include "axode/integration/schemes/munthe_kaas.hpp"
#include "axode/model/building/fault.hpp"
#include "axode/scalar/text.hpp"

/// Loops over the steps of explicit methods. The argument `run` is a simulation, such as a SimulationRun,
/// with the present q, v and a, accelerate() for accelerations, and take_up_to(), which accepts a step up to
/// a time.
namespace axode {

/// Takes equal steps from the present time to `until`; the last one may be shorter. take(t_1) computes the
/// step to t_1; if it fails, the motion ends. Throws std::invalid_argument if more than 1e9 steps would be
/// needed, because their states do not fit in memory.
template <class Run, class Take> void each_step(Run& run, double until, double step, const Take& take) {
  if (run.done()) return;
  constexpr double most_steps = 1e9;
  const double begin = run.now(), whole = std::ceil((until - begin) / step - 1e-9);
  if (whole > most_steps)
    throw std::invalid_argument("step is " + to_text(step) + " s, and a motion of " + to_text(until - begin) +
                                " s has at most 1e9 steps; choose a longer step, or a shorter motion");
  for (double k = 1; k <= whole && !run.done(); ++k)
    if (Failure failure = take(k == whole ? until : begin + k * step)) run.stop(failure);
}

/// Takes equal steps from the present time to `until`; the last one may be shorter. A step is taken in
/// several parts if a derivative of a prescribed motion or an input of a drive jumps within it. take(t_1)
/// computes a part that ends at t_1 or before. If the law of a drive changes its form, for example at a
/// limit, it does so at the end of a part.
template <class Run, class Take> void each_part(Run& run, double until, double step, const Take& take) {
  each_step(run, until, step, [&](double t_1) {
    while (run.now() < t_1 && !run.done()) {
      if (Failure failure = take(run.step_end(t_1))) return failure;
      if (run.done()) break;
      if (Failure failure = run.switch_drives()) return failure;
    }
    return Failure{};
  });
}

/// Advances the motion to t_1. Takes several steps if, before t_1, a joint begins to stick or slide, the law
/// of a drive changes its form (for example at a limit), a play (backlash) opens or closes, or a derivative
/// of a prescribed motion or an input of a drive jumps. `attempt` computes a step, and after() is called
/// after each step.
template <class Run, class After>
Failure take_until(Run& run, double t_1, StepEnd& end, const Attempt& attempt, const After& after) {
  while (run.now() < t_1 && !run.done()) {
    const double t = run.step_end(t_1);
    if (Failure failure = attempt(t, end)) return failure;
    if (Failure failure = run.take_up_to(t, end, attempt)) return failure;
    after();
  }
  return {};
}

/// Returns the vector (v, x) of velocities v and states x of the drives, or that of their rates.
std::vector<double> joined(const auto& v, const Eigen::VectorXd& x) {
  std::vector<double> y(v.begin(), v.end());
  y.insert(y.end(), x.begin(), x.end());
  return y;
}

/// Returns the function that attempts a step of an explicit method, see Attempt.
template <class Run, class Scheme> Attempt attempts(Run& run, Scheme& scheme) {
  return [&, group = run.group()](double t_1, StepEnd& end) {
    const double t = run.now();
    const std::size_t nv = run.v.size();
    DriveStates& drives = run.drives();
    Failure failure;
    const auto accelerate = [&](double t_i, auto q_i, auto y_i, auto dy_i) {
      drives.act_at(y_i.subspan(nv));
      failure = run.accelerate(t_i, q_i, y_i.first(nv), dy_i.first(nv));
      std::ranges::copy(drives.rates(), dy_i.begin() + static_cast<std::ptrdiff_t>(nv));
      return !failure;
    };
    run.begin_step();
    const auto y_0 = joined(run.v, drives.x), dy_0 = joined(run.a, drives.dx);
    if (!scheme.run(t, run.q.data(), y_0.data(), dy_0.data(), t_1 - t, accelerate)) return failure;
    end.q.resize(static_cast<Eigen::Index>(run.q.size()));
    group.move(run.q, scheme.theta, end.q);
    const std::span<const double> y(scheme.y), dy(scheme.end());
    end.v = as_eigen(y.first(nv));
    end.x = as_eigen(y.subspan(nv));
    end.a = as_eigen(dy.first(std::min(nv, dy.size())));
    end.dx = as_eigen(dy.subspan(std::min(nv, dy.size())));
    return failure;
  };
}

/// Takes steps of one length from time 0 until a time (s) by an explicit method.
template <class Run> void take_steps(Run& run, double until, double step, const Tableau& method) {
  MuntheKaas scheme(run.tree(), method, run.local_coordinates(), run.drives().size());
  const Attempt attempt = attempts(run, scheme);
  StepEnd end;
  each_step(run, until, step, [&](double t_1) { return take_until(run, t_1, end, attempt, [] {}); });
}

/// Limits that end a motion whose steps become ever shorter, because a drive force is discontinuous at a
/// state that the motion does not leave, for example -sign(v) at rest. The motion ends if `stall_window`
/// attempts at steps advance the time by less than `stall_step` (s) each on average, and if the time that
/// remains is more than `stall_ratio` times the time by which they advance.
inline constexpr int stall_window = 10'000;
inline constexpr double stall_ratio = 1e5, stall_step = 1e-9;
inline constexpr const char* jumps =
    "the step size has collapsed: a force is discontinuous at a state in which the motion stays, or grows "
    "without bound; use a method of fixed steps (rk4), and give dry friction as a joint property that "
    "joint_losses counts";

/// Limits of the step control near singular configurations, where the loop equations are nearly dependent and
/// the error estimate of a step jumps although the motion does not. weakest_row() of a step is 1 if the loop
/// equations are clearly independent; otherwise it is the least ratio of a pivot to a diagonal entry in the
/// factorisation of A M⁻¹ Aᵀ, with the Jacobian A of the loop equations and the mass matrix M: about 0.001 or
/// less, and 0 if they are dependent. A step is near a singular configuration if its weakest_row() is less
/// than 1. After a step far from singular configurations, up to `most_passing` steps in a row that are near
/// one are accepted whatever their error estimates are. If weakest_row() of such a step is even less than
/// `too_weak`, the step is first repeated up to `most_shortened` times, each time shorter by the factor
/// `shortened`, until weakest_row() is larger.
inline constexpr int most_passing = 20, most_shortened = 6;
inline constexpr double too_weak = 1e-5, shortened = 0.85;

/// Takes adaptive steps with Dormand's and Prince's method.
template <class Run> void take_adapted_steps(Run& run, double until, const Tolerances& tolerances) {
  const Tableau& method = runge_kutta(5);
  MuntheKaas scheme(run.tree(), method, run.local_coordinates(), run.drives().size());
  const auto to_array = [](const auto& x) {
    return Eigen::Map<const Eigen::ArrayXd>(x.data(), static_cast<Eigen::Index>(x.size()));
  };
  const std::vector<double> ones(run.v.size(), 1.0);
  // The root mean square of the error estimates of q, v and the states x of drives, relative to their
  // tolerances.
  const auto error_of_step = [&] {
    const double relative = tolerances.relative, absolute = tolerances.absolute;
    const auto theta = to_array(scheme.theta).abs().max(1.0);
    const auto y_0 = joined(run.v, run.drives().x), usual = joined(ones, run.drives().nominal());
    const auto size = to_array(y_0).abs().max(to_array(scheme.y).abs());
    const double squares =
        (to_array(scheme.error_theta) / (absolute + relative * theta)).square().sum() +
        (to_array(scheme.error_y) / (absolute * to_array(usual) + relative * size)).square().sum();
    return std::sqrt(squares /
                     std::max(1.0, static_cast<double>(scheme.theta.size() + scheme.error_y.size())));
  };
  // As long as nothing moves, error estimates do not show that a force or a prescribed motion will begin.
  const double unless_given = run.is_driven_in_time() ? until / 50 : until;
  const double most = tolerances.largest_step > 0 ? tolerances.largest_step : unless_given;
  double h = tolerances.first_step;
  if (!(h > 0)) {
    const Eigen::Index n = static_cast<Eigen::Index>(run.v.size());
    const double fastest = n > 0 ? to_array(run.v).abs().maxCoeff() : 0;
    const double largest = n > 0 ? to_array(run.a).abs().maxCoeff() : 0;
    h = 0.01 / std::max({1e-3, fastest, std::sqrt(largest)});
  }
  double last_error = 1e-4, window_start = 0;
  int tries = 0, passing = most_passing, shorter = 0;
  const Attempt attempt = attempts(run, scheme);
  StepEnd end;
  while (!run.done()) {
    const double t = run.now(), rest = run.step_end(until) - t;
    if (++tries == stall_window) {
      const double gone = t - window_start;
      if (gone < stall_step * stall_window && rest > stall_ratio * gone) return run.stop({t, jumps});
      tries = 0;
      window_start = t;
    }
    h = std::min({h, most, rest});
    const double length = h * std::pow(shortened, shorter);
    const bool last = length >= rest * (1 - 1e-12);
    if (!last && !(length > 1e-15 * until))
      return run.stop({t, "the step became too short for the tolerances; use larger tolerances, or rk4"});
    const double t_1 = last ? run.step_end(until) : t + length;
    if (Failure failure = attempt(t_1, end)) {  // the step may be too long
      ++run.trajectory.rejected;
      if (h < 1e-9 * until) {
        Failure stops = failure;
        if constexpr (requires { run.pass(t_1, failure); }) stops = run.pass(t_1, failure);
        if (stops) return run.stop(stops);
        continue;
      }
      h *= 0.1;
      continue;
    }
    const double error = error_of_step(), weakest = run.weakest_row();
    const bool passes = weakest < 1 && passing < most_passing && std::isfinite(error);
    if (passes && weakest < too_weak && shorter < most_shortened && !last) {
      ++run.trajectory.rejected;
      ++shorter;
      continue;
    }
    shorter = 0;
    if (!(error <= 1) && !passes) {
      ++run.trajectory.rejected;
      h *= std::isfinite(error) ? std::max(0.2, 0.9 * std::pow(error, -0.2)) : 0.1;
      continue;
    }
    if (!(error <= 1)) ++run.trajectory.uncontrolled;
    if (Failure failure = run.take_up_to(t_1, end, attempt)) return run.stop(failure);
    passing = weakest < 1 ? passing + 1 : 0;
    if (passes) continue;
    const double least = std::max(error, 1e-10);
    h *= std::clamp(0.9 * std::pow(least, -0.17) * std::pow(last_error, 0.04), 0.2, 10.0);
    last_error = std::max(error, 1e-4);
  }
}

}  // namespace axode
