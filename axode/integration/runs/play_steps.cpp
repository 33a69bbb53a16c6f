#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "axode/eigen.hpp"
#include "axode/integration/runs/simulation_run.hpp"

/// The part of SimulationRun for steps that end where a play reaches or leaves one of its ends (D16.18).
namespace axode {
namespace {

/// The time at which a cubic that describes a gap in a step is least, as a fraction of the step. g_0 and g_1
/// are its values at both ends, and d_0 and d_1 its rates there, multiplied by the length of the step.
double part_of_least(double g_0, double d_0, double g_1, double d_1) {
  const double c2 = 3 * (g_1 - g_0) - 2 * d_0 - d_1, c3 = 2 * (g_0 - g_1) + d_0 + d_1;
  const double root = std::sqrt(std::max(0.0, c2 * c2 - 3 * c3 * d_0));
  const double s = -d_0 / (c2 + root);  // the root of the derivative at which the cubic turns upwards
  return std::clamp(s, 0.0, 1.0);
}

}  // namespace

/// Finds which couplings with play (backlash) are at an end of their play when the motion starts. Throws
/// std::invalid_argument if one is beyond an end, and if joints have dry friction or gears with losses.
void SimulationRun::start_plays() {
  if (friction_.active())
    throw std::invalid_argument(
        "coupling \"" + plays_.name(0) +
        "\" has play, and joints have dry friction or gears with losses; a simulation "
        "counts one of both: set joint_losses to false or the friction to 0");
  note_plays(plays_.start(as_span(q), as_span(v), engagement()));
  if (Failure failure = settle_plays()) {
    stop(failure);
    return;
  }
  plays_.allow_overshoot(as_span(q));
  trajectory.pop_back();
  trajectory.append(0, as_span(q), as_span(v), as_span(a), as_span(tau_), as_span(drives_.x),
                    as_span(drives_.dx));
}

/// Sets up the loops of the mechanism anew, with a coupling without play for every play that is at an end.
void SimulationRun::engage_plays() {
  const Model& model = plays_.any_at_an_end() ? plays_.engaged() : model_;
  loops_.reset();
  if (model.loops().empty() && model.motions().empty() && options_.motions.empty()) return;
  loops_.emplace(model, options_.motions);
  loops_->set_time(now());
  loops_->determine_rank(as_span(q));
}

Plays::Engage SimulationRun::engagement() {
  return [this] {
    engage_plays();
    return loops_ ? &*loops_ : nullptr;
  };
}

/// Adds events of plays at the present time to the trajectory.
void SimulationRun::note_plays(Plays::Events events) {
  for (Trajectory::PlayEvent& event : events) {
    event.t = now();
    trajectory.play_events.push_back(std::move(event));
  }
}

/// Computes a number for each play (backlash of a coupling) that becomes negative when the play must open or
/// close. For a free play it is the gap to the nearer end. For a play at an end it is the force with which
/// this end pushes.
Failure SimulationRun::reserves(double t, const StepEnd& end, std::vector<double>& out) {
  out.resize(plays_.size());
  if (plays_.any_at_an_end()) {
    Vector a_end(end.v.size());
    if (end.x.size() > 0) drives_.act_at(as_span(end.x));
    if (Failure failure = accelerate(t, as_span(end.q), as_span(end.v), as_span(a_end))) return failure;
  }
  for (std::size_t k = 0; k < plays_.size(); ++k)
    out[k] = plays_.reserve(k, as_span(end.q), loops_ ? &*loops_ : nullptr);
  return {};
}

/// Searches the step up to time t_1 (s) for a free play (backlash) that passes an end and comes back. This is
/// the case if the gap to the end falls at the start of the step, rises at the end of the step, and is
/// negative at its least value in between; the gap is approximated by a cubic in time. Returns the time of
/// the least value, or t_1 if there is no such play.
double SimulationRun::time_of_dip(double t_1, const StepEnd& end) const {
  const double h = t_1 - now();
  for (std::size_t k = 0; k < plays_.size(); ++k)
    for (const int side : {Plays::upper, Plays::lower}) {
      if (plays_.side(k) != 0) continue;
      const double g_0 = plays_.gap_to(k, side, as_span(q)), g_1 = plays_.gap_to(k, side, as_span(end.q)),
                   d_0 = -side * h * plays_.rate(k, as_span(v)),
                   d_1 = -side * h * plays_.rate(k, as_span(end.v));
      if (!(d_0 < 0 && d_1 > 0)) continue;
      const double s = part_of_least(g_0, d_0, g_1, d_1), r = 1 - s;
      const double least =
          g_0 * r * r * (1 + 2 * s) + g_1 * s * s * (3 - 2 * s) + d_0 * s * r * r - d_1 * s * s * r;
      if (least < 0 && s > 0 && s < 1) return now() + s * h;
    }
  return t_1;
}

/// Shortens a step in which a play (the backlash of a coupling) reaches or leaves one of its two ends, so
/// that the step ends just after this change. t_1 and `end` are the time and the state at the end of the
/// step, and `reserve` has a number for each play that is negative if the play must open or close at t_1. All
/// three are those of the whole step before the call, and those of the shorter step after it.
Failure SimulationRun::find_change(double& t_1, StepEnd& end, const Attempt& attempt,
                                   std::vector<double>& reserve) {
  const double t_0 = now(), resolution = std::max(1e-13 * (t_1 - t_0), 1e-15 * t_1);
  std::vector<double> found;
  StepEnd here{q, v, a, drives_.x, drives_.dx}, after = end;
  if (Failure failure = reserves(t_0, here, found)) return failure;
  ChangeSearch search(t_0, t_1, resolution, found, reserve);
  while (search.continues()) {
    if (Failure failure = attempt(search.t(), end)) return failure;
    if (Failure failure = reserves(search.t(), end, found)) return failure;
    if (search.take(found)) after = end;
  }
  t_1 = search.found();
  reserve = search.numbers();
  end = after;
  end.a.resize(0);  // the last evaluation was another one
  return {};
}

std::string SimulationRun::too_many_changes(const char* what) {
  return std::string(what) + " changed more than " + std::to_string(most_short_steps) +
         " times in succession, each time within " + to_text(short_part) + " of a step; use a shorter step";
}

Failure SimulationRun::take_up_to_play(double t_1, StepEnd& end, const Attempt& attempt) {
  std::vector<double> reserve;
  const auto changes = [&] { return ChangeSearch::changed(reserve); };
  const double t_0 = now(), length = t_1 - t_0;
  if (Failure failure = reserves(t_1, end, reserve)) return failure;
  if (const double dip = time_of_dip(t_1, end); !changes() && dip < t_1) {
    if (Failure failure = attempt(dip, end)) return failure;
    if (Failure failure = reserves(dip, end, reserve)) return failure;
    if (changes())
      t_1 = dip;
    else if (Failure failure = attempt(t_1, end))
      return failure;
  }
  if (!changes()) {
    short_steps_ = 0;
    if (Failure failure = take(t_1, end)) return failure;
    plays_.reduce_overshoot(as_span(q));
    return {};
  }
  if (Failure failure = find_change(t_1, end, attempt, reserve)) return failure;
  short_steps_ = t_1 - t_0 < short_part * length ? short_steps_ + 1 : 0;
  if (short_steps_ > most_short_steps) return {t_0, too_many_changes("plays of couplings")};
  if (Failure failure = take(t_1, end)) return failure;
  if (done()) return {};
  accelerations_jumped_ = true;
  return change_plays(reserve);
}

/// Changes plays with a negative `reserve`: a free one meets its end, and one at an end becomes free.
Failure SimulationRun::change_plays(const std::vector<double>& reserve) {
  note_plays(plays_.change(reserve, as_span(q), as_span(v), engagement()));
  if (Failure failure = settle_plays()) return failure;
  plays_.allow_overshoot(as_span(q));
  trajectory.jump(as_span(v), as_span(a), as_span(drives_.x), as_span(drives_.dx));
  values_ = values_at(now(), as_span(q), as_span(v));
  return {};
}

/// Computes the accelerations at the present state. A play at an end that would be pulled becomes free.
Failure SimulationRun::settle_plays() {
  for (;;) {
    if (Failure failure = accelerate_now()) return failure;
    Plays::Events released = plays_.release_pulled(loops_ ? &*loops_ : nullptr);
    if (released.empty()) return {};
    note_plays(std::move(released));
    engage_plays();
  }
}

}  // namespace axode
