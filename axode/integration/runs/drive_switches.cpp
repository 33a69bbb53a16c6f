#include <algorithm>
#include <utility>

#include "axode/eigen.hpp"
#include "axode/integration/runs/simulation_run.hpp"

/// Steps that end where a drive with states changes to another branch of its law.
namespace axode {

/// Returns whether drives jump if they change to other branches of their laws at time t with the state `end`,
/// the end of a step. A jump of a drive state counts, and so does a jump of the rate of a drive state or of a
/// drive force, multiplied by the length of the step. Jumps that would alter the drive states and the
/// velocities by at most 1e-9 of their size do not count.
bool SimulationRun::jumps_at_switch(double t, const StepEnd& end) {
  constexpr double small = 1e-9;
  const double h = t - now();
  jump_.resize(model_.nv());
  return drives_.jumps_at(t, h, as_span(end.q), as_span(end.v), end.x, jump_) ||
         !(h * norm_.of_forces(jump_) <= small * velocity_scale(end.v, h));
}

Failure SimulationRun::end_at_switch(double& t_1, StepEnd& end, const Attempt& attempt, bool abrupt) {
  if (drives_.empty()) return {};
  const auto margin = [&](double t) {
    return drives_.least_margin(t, as_span(end.q), as_span(end.v), as_span(end.x));
  };
  const double margin_1 = margin(t_1);
  if (!(margin_1 < 0) || (abrupt && !jumps_at_switch(t_1, end))) return {};
  const double t_0 = now(), h = t_1 - t_0;
  const double margin_0 = drives_.least_margin(t_0, as_span(q), as_span(v), as_span(drives_.x));
  SwitchSearch search(t_0, t_1, std::max(0.0, margin_0), margin_1);
  StepEnd& after = after_switch_;
  after = end;
  while (search.continues()) {
    const double t = search.next();
    if (Failure failure = attempt(t, end)) return failure;
    if (search.take(margin(t))) after = end;
  }
  short_steps_ = search.found() - t_0 < short_part * h ? short_steps_ + 1 : 0;
  if (short_steps_ > most_short_steps) return {t_0, too_many_changes("statuses of drives")};
  if (!search.found_last() && friction_.active())
    if (Failure failure = attempt(search.found(), after)) return failure;
  t_1 = search.found();
  std::swap(end, after);
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
