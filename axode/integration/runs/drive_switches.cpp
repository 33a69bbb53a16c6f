#include <algorithm>
#include <utility>

#include "axode/eigen.hpp"
#include "axode/integration/runs/simulation_run.hpp"

/// Steps that end where a drive with states changes to another branch of its law.
namespace axode {

/// Whether the change of statuses at the end of a step changes forces, rates or states of the drives by more
/// than 1e-9 of the motion in one step, so that the end of the step depends on the time of the change.
bool SimulationRun::jumps_at_switch(double t, const StepEnd& end) const {
  constexpr double small = 1e-9;
  const double h = t - now();
  DriveSystem before = drives_.system(), after = before;
  const Eigen::Index n = end.x.size(), nv = model_.nv();
  Vector x = end.x, dx_0(n), dx_1(n), tau_0 = Vector::Zero(nv), tau_1 = tau_0;
  after.switch_at(t, as_span(end.q), as_span(end.v), as_span(x));
  before.evaluate(t, as_span(end.q), as_span(end.v), as_span(end.x), as_span(tau_0), as_span(dx_0));
  after.evaluate(t, as_span(end.q), as_span(end.v), as_span(std::as_const(x)), as_span(tau_1), as_span(dx_1));
  const Vector size = drives_.nominal().cwiseMax(x.cwiseAbs());
  const Vector change = (x - end.x).cwiseAbs() + h * (dx_1 - dx_0).cwiseAbs();
  return !(change.cwiseQuotient(size).lpNorm<Eigen::Infinity>() <= small &&
           h * norm_.of_forces(tau_1 - tau_0) <= small * velocity_scale(end.v, h));
}

/// The time of the change is found by regula falsi (Illinois) and bisection.
Failure SimulationRun::end_at_switch(double& t_1, StepEnd& end, const Attempt& attempt, bool abrupt) {
  if (drives_.empty()) return {};
  const auto margin = [&](double t) {
    return drives_.least_margin(t, as_span(end.q), as_span(end.v), as_span(end.x));
  };
  double f_high = margin(t_1);
  if (!(f_high < 0) || (abrupt && !jumps_at_switch(t_1, end))) return {};
  const double t_0 = now(), resolution = std::max(1e-13 * (t_1 - t_0), 1e-15 * t_1), h = t_1 - t_0;
  double low = t_0, high = t_1, t = t_1;
  double f_low = std::max(0.0, drives_.least_margin(t_0, as_span(q), as_span(v), as_span(drives_.x)));
  StepEnd after = end;
  for (int tries = 1; high - low > resolution; ++tries) {
    const double guess = low + (high - low) * (f_low / (f_low - f_high));
    t = tries % 4 == 0 ? low + (high - low) / 2
                       : std::clamp(guess, low + 0.5 * resolution, high - 0.5 * resolution);
    if (Failure failure = attempt(t, end)) return failure;
    const double f = margin(t);
    if (f < 0) {
      high = t;
      f_high = f;
      f_low *= 0.5;
      after = end;
    } else {
      low = t;
      f_low = f;
      f_high *= 0.5;
    }
  }
  short_steps_ = high - t_0 < short_part * h ? short_steps_ + 1 : 0;
  if (short_steps_ > most_short_steps) return {t_0, too_many_changes("statuses of drives")};
  if (t != high && friction_.active())
    if (Failure failure = attempt(high, after)) return failure;
  t_1 = high;
  end = std::move(after);
  return {};
}

Failure SimulationRun::switch_drives() {
  if (!drives_.switch_at(now(), as_span(q), as_span(v))) return {};
  accelerations_jumped_ = true;
  if (Failure failure = accelerate_now()) return failure;
  trajectory.jump(as_span(v), as_span(a), as_span(drives_.x), as_span(drives_.dx));
  return {};
}

}  // namespace axode
