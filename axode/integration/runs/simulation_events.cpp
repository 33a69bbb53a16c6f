#include <numbers>

#include "axode/eigen.hpp"
#include "axode/integration/runs/simulation_run.hpp"
#include "axode/kinematics/twists.hpp"

/// The functions of SimulationRun that find the events of a motion.
namespace axode {
std::vector<double> SimulationRun::values_at(double t, Span q_t, Span v_t) const {
  std::vector<double> values;
  for (const Event& event : options_.events) values.push_back(event.value(t, q_t, v_t));
  return values;
}

/// The value of an event at a time t in the last step, whose state is interpolated.
double SimulationRun::value_at(const Event& event, double t) const {
  Vector q_t(q.size()), v_t(v.size());
  trajectory.at(t, as_span(q_t), as_span(v_t));
  return event.value(t, as_span(q_t), as_span(v_t));
}

/// Returns a number of equal parts of the last step, which begins at time `before`, such that no body turns
/// by much more than a quarter turn in a part. If events are searched in each part, two changes of sign of an
/// event function of an attitude cannot both be missed.
int SimulationRun::parts_by_rotation(double before) {
  const double h = now() - before;
  const std::size_t k = trajectory.size() - 1;
  std::vector<Twist<BodyFixed>> V(static_cast<std::size_t>(model_.n_frames()));
  double fastest = 0;
  for (const std::size_t end : {k - 1, k}) {
    twists<BodyFixed, double>(model_, workspace_, trajectory.q(end), trajectory.v(end), V);
    for (const Twist<BodyFixed>& V_i : V) fastest = std::max(fastest, axode::norm(V_i.w));
  }
  return static_cast<int>(std::clamp(std::ceil(h * fastest / (std::numbers::pi / 2)), 1.0, 1e9));
}

/// Finds the times between `before` and `after`, two times in the last step, at which the function of event
/// number e changes its sign, and appends them to `met`. The function has the value `begin` at `before` and
/// the value `end` at `after`. If the signs of these values differ, one time is found. If they are equal, two
/// times are found if the function approaches zero at `before`, moves away from zero at `after`, and has the
/// other sign in between; otherwise none. Changes of sign in a direction that the event excludes are left
/// out.
void SimulationRun::find_occurrences(std::size_t e, double before, double after, double begin, double end,
                                     std::vector<Trajectory::EventOccurrence>& met) const {
  const Event& event = options_.events[e];
  const auto value = [&](double t) { return value_at(event, t); };
  const double near = 1e-6 * (after - before);
  double soon = value(before + near);
  if (begin == 0) {  // an event at the start of the step has been found already
    before += near;
    begin = soon;
    soon = value(before + near);
  }
  const double sign = begin < 0 ? -1 : 1;
  const auto cross = [&](double low, double high, bool rises) {
    if (event.direction != 0 && rises != (event.direction > 0)) return;
    for (int k = 0; k < 60 && high - low > 1e-15 * std::abs(after); ++k) {
      const double middle = low + (high - low) / 2;
      ((value(middle) < 0) == rises ? low : high) = middle;
    }
    met.push_back({e, high});
  };
  if ((begin < 0) != (end < 0)) return cross(before, after, begin < 0);
  if (!(sign * (soon - begin) < 0 && sign * (end - value(after - near)) > 0)) return;
  double low = before, high = after;
  for (int k = 0; k < 40; ++k) {  // each iteration discards the outer third next to the larger value
    const double a_third = (high - low) / 3, one = low + a_third, two = high - a_third;
    const double at_one = sign * value(one), at_two = sign * value(two);
    if (std::min(at_one, at_two) < 0) {
      const double turn = at_one < at_two ? one : two;
      cross(before, turn, begin < 0);
      cross(turn, after, begin >= 0);
      return;
    }
    (at_one < at_two ? high : low) = at_one < at_two ? two : one;
  }
}

/// Finds the events of the last step, from `before` to `after`. A terminal event ends the trajectory.
Failure SimulationRun::find_events(double before, double after) {
  const std::vector<double> next = values_at(after, as_span(q), as_span(v));
  std::vector<Trajectory::EventOccurrence> met;
  const int parts = parts_by_rotation(before);
  for (std::size_t e = 0; e < next.size(); ++e) {
    double from = before, begin = values_[e];
    for (int k = 1; k <= parts; ++k) {
      const bool last = k == parts;
      const double to = last ? after : before + k * ((after - before) / parts);
      const double end = last ? next[e] : value_at(options_.events[e], to);
      find_occurrences(e, from, to, begin, end, met);
      from = to;
      begin = end;
    }
  }
  values_ = next;
  std::ranges::sort(met, {}, &Trajectory::EventOccurrence::t);
  for (const Trajectory::EventOccurrence& one : met) {
    trajectory.events.push_back(one);
    if (!options_.events[one.event].terminal) continue;
    ended_ = true;
    Vector q_t(q.size()), v_t(v.size()), a_t(v.size());
    trajectory.at(one.t, as_span(q_t), as_span(v_t));
    trajectory.drive_states_at(one.t, as_span(drives_.x));
    drives_.act_at(as_span(drives_.x));
    trajectory.pop_back();
    if (loops_) loops_->set_time(one.t);
    if (loops_ && !loops_->close(as_span(q_t), as_span(v_t))) return {one.t, open};
    if (Failure failure = accelerate(one.t, as_span(q_t), as_span(v_t), as_span(a_t))) return failure;
    trajectory.append(one.t, as_span(q_t), as_span(v_t), as_span(a_t), as_span(tau_), as_span(drives_.x),
                      drives_.rates());
    return {};
  }
  return {};
}

}  // namespace axode
