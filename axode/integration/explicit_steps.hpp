#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "axode/integration/munthe_kaas.hpp"
#include "axode/integration/simulation.hpp"

/// Explicit methods on a run: it has q, v and a of now on the group of tree(), accelerations(), and takes the ends of steps.
namespace axode {

/// Steps of one length from 0 on, the last as long as is left; take(t_1) goes to t_1 and says whether to go on.
template <class Run, class Take> void each_step(const Run& run, double until, double step, const Take& take) {
  const double whole = std::ceil(until / step - 1e-9);
  for (double k = 1; k <= whole && !run.done(); ++k)
    if (!take(k == whole ? until : k * step)) break;
}

/// attempt(t_1, end) of an explicit method: the end of a step from now to t_1.
template <class Run, class Scheme, class Group> auto attempts(Run& run, Scheme& scheme, const Group& group) {
  return [&](double t_1, StepEnd& end) {
    const double t = run.now();
    run.begin_step();
    if (!scheme.run(t, run.q.data(), run.v.data(), run.a.data(), t_1 - t, run.accelerations())) return false;
    end.q.resize(run.q.size());
    group.move(run.q.data(), scheme.theta.data(), end.q.data());
    end.v = scheme.y;
    end.a.assign(scheme.end().begin(), scheme.end().end());
    return true;
  };
}

/// Steps of one length until a time, or two where friction changes between.
template <class Run> void take_steps(Run& run, double until, double step, const Tableau& method) {
  MuntheKaas scheme(run.tree(), method);
  const ConfigurationGroup<double> group(run.tree());
  const auto attempt = attempts(run, scheme, group);
  StepEnd end;
  each_step(run, until, step, [&](double t_1) {
    while (run.now() < t_1 && !run.done())
      if (!attempt(t_1, end) || !run.take_up_to(t_1, end, attempt)) return false;
    return true;
  });
}

/// A drive force that jumps where the motion dwells, as -sign(v) does at rest, is crossed in ever shorter steps: so many are
/// looked at together, and so many times as many are not begun, where one is shorter than anything that swings and
/// dies out (s).
inline constexpr int watched = 10'000;
inline constexpr double hopeless = 1e5, too_short = 1e-9;
inline constexpr const char* jumps =
    "the steps have become so short that a thousand million more would not do: a force jumps where the "
    "motion dwells, or "
    "grows without bound; methods in steps of one length go on, and dry friction of a joint is one of its "
    "own "
    "properties (joint losses)";

/// Where branches of a motion meet, rows of the loops depend on each other. Accelerations close by are those of a mechanism with more
/// freedoms, so that the error estimate sees a jump that is not in the motion, and shorter steps would only look closer at
/// it. So many steps in a row, after one without such rows, are taken with the length before and whatever their error estimate; an
/// attempt with a row that is weaker than `too_weak` is repeated so many times with a part of the length.
inline constexpr int most_passing = 20, most_shortened = 6;
inline constexpr double too_weak = 1e-6, shortened = 0.85;

/// Steps as long as the estimated error allows, with Dormand's and Prince's method.
template <class Run> void take_adapted_steps(Run& run, double until, const Tolerances& tolerances) {
  const Tableau& method = runge_kutta(5);
  MuntheKaas scheme(run.tree(), method);
  const ConfigurationGroup<double> group(run.tree());
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
  double last_error = 1e-4, watched_from = 0;
  int tries = 0, passing = most_passing, shorter = 0;
  const auto attempt = attempts(run, scheme, group);
  StepEnd end;
  while (!run.done()) {
    const double t = run.now(), rest = until - t;
    if (++tries == watched) {
      const double gone = t - watched_from;
      if (gone < too_short * watched && rest > hopeless * gone) {
        run.stop(t, jumps);
        break;
      }
      tries = 0, watched_from = t;
    }
    h = std::min({h, most, rest});
    const double length = h * std::pow(shortened, shorter);
    const bool last = length >= rest * (1 - 1e-12);
    if (!last && !(length > 1e-15 * until)) {
      run.stop(t, "the step became too short for the tolerances");
      break;
    }
    const double t_1 = last ? until : t + length;
    if (!attempt(t_1, end)) {
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
    const double weakest = run.weakest_row();
    const bool passes = weakest < 1 && passing < most_passing && std::isfinite(error);
    if (passes && weakest < too_weak && shorter < most_shortened && !last) {
      ++run.trajectory.rejected, ++shorter;
      continue;
    }
    shorter = 0;
    if (!(error <= 1) && !passes) {
      ++run.trajectory.rejected;
      h *= std::isfinite(error) ? std::max(0.2, 0.9 * std::pow(error, -0.2)) : 0.1;
      continue;
    }
    if (!run.take_up_to(t_1, end, attempt)) break;
    passing = weakest < 1 ? passing + 1 : 0;
    if (passes) continue;
    const double least = std::max(error, 1e-10);
    h *= std::clamp(0.9 * std::pow(least, -0.17) * std::pow(last_error, 0.04), 0.2, 10.0);
    last_error = std::max(error, 1e-4);
  }
}

}  // namespace axode
