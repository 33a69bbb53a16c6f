#include "axode/integration/exact/exact_contact_run.hpp"

#include <algorithm>
#include <limits>

#include "axode/eigen.hpp"
#include "axode/scalar/text.hpp"

namespace axode {
namespace {

using Kind = Trajectory::ContactEvent::Kind;
constexpr double infinite = std::numeric_limits<double>::infinity();
/// The rounding error of ContactPhase::reserve(), which is the least distance of the constraint forces from
/// their limits (no unit). The limits are violated, and the phase ends, only if reserve() is below minus this
/// number.
constexpr double reserve_rounding = 5e-14;

/// Events with a smaller distance occur together, s.
constexpr double at_once = 5e-13;
/// The least step that is divided, as a part of the duration of the motion.
constexpr double least_divided = 1e-11;
/// Part of the resolution of places below which a flight is not followed.
constexpr double unresolved_part = 0.1;
/// The multiple of the resolution of velocities that counts as rest.
constexpr double slow = 2;

bool is_negative(double x) { return x < 0; }

bool is_as_before(const ClosedConstraint& a, const ClosedConstraint& b) {
  return a.same_as(b) && a.branch == b.branch;
}

}  // namespace

ExactContactRun::ExactContactRun(const Model& model, const ContactShapes& shapes, Span q_0, Span v_0,
                                 double until, const SimulationOptions& options, bool losses,
                                 const Tolerances& tolerances)
    : SimulationRun(model, q_0, v_0, until, options, losses),
      phase_(closed_model(), shapes, losses),
      last_(until),
      tolerances_(tolerances) {
  for (int i = 0; i < shapes.size(); ++i) trajectory.contact_shapes.push_back(shapes[i].name);
  if (trajectory.size() > 0) begin();
}

/// Chooses the first phase, after the impacts at the start.
void ExactContactRun::begin() {
  constexpr double touching = 1e-9;
  const auto fails = [&](const std::string& why) {
    if (!why.empty()) stop({0, why});
    return !why.empty();
  };
  bool impacts = false;
  follow(0);
  if (fails(phase_.overlap(q, touching)) || fails(phase_.start(q, v, touching, impacts))) return;
  std::vector<ContactPhase::Impact> met;
  if (impacts) {
    const auto never = [](const Gap&, double) { return false; };
    if (fails(phase_.impact(q, v, never, met, certificate_))) return;
  }
  if (fails(phase_.project(q, v))) return;
  if (Failure failure = decide(0)) return stop(failure);
  for (const ContactPhase::Impact& it : met) add_event(it, 0);
  if (Failure failure = settle(0)) return stop(failure);
  trajectory.pop_back();
  trajectory.append(0, as_span(q), as_span(v), as_span(a), as_span(tau_), as_span(drives_.x),
                    as_span(drives_.dx));
}

Failure ExactContactRun::decide(double t) {
  drives_.act_at(as_span(drives_.x));
  ContactPhase::Forces acting;
  if (Failure failure = find_forces(t, as_span(q), as_span(v), acting)) return failure;
  std::string why = phase_.decide(q, v, acting);
  return why.empty() ? Failure{} : Failure{t, std::move(why)};
}

Failure ExactContactRun::find_forces(double t, Span q_t, Span v_t, ContactPhase::Forces& out) {
  Span tau;
  follow(t);
  if (Failure failure = joint_forces(t, q_t, v_t, tau)) return failure;
  out = {tau, {loads_, false}};
  return {};
}

Failure ExactContactRun::accelerate(double t, Span q_t, Span v_t, std::span<double> a_t) {
  ContactPhase::Forces forces;
  if (Failure failure = find_forces(t, q_t, v_t, forces)) return failure;
  std::string why = phase_.accelerate(as_eigen(q_t), as_eigen(v_t), forces, a_t);
  return why.empty() ? Failure{} : Failure{t, std::move(why)};
}

Failure ExactContactRun::mark(double t, StepEnd& end, Marks& out) {
  return mark(t, end.q, end.v, end.x, end.a, out);
}

Failure ExactContactRun::mark(double t, const Vector& q_t, const Vector& v_t, const Vector& x_t, Vector& a_t,
                              Marks& out) {
  a_t.resize(v_t.size());
  drives_.act_at(as_span(x_t));
  if (Failure failure = accelerate(t, as_span(q_t), as_span(v_t), as_span(a_t))) return failure;
  out.reserve = phase_.reserve();
  out.slips.assign(phase_.slips().begin(), phase_.slips().end());
  out.speeds.assign(phase_.speeds().begin(), phase_.speeds().end());
  std::string why = phase_.gaps(q_t, v_t, a_t, out.gaps);
  return why.empty() ? Failure{} : Failure{t, std::move(why)};
}

void ExactContactRun::predict(double t_1, const Marks& at_end) {
  const double t_0 = now(), h = t_1 - t_0;
  windows_.clear();
  for (const Gap& start : now_.gaps) {
    const auto end = std::ranges::find_if(
        at_end.gaps, [&](const Gap& g) { return g.law == start.law && g.key == start.key; });
    if (end == at_end.gaps.end()) {
      windows_.push_back({-infinite, infinite});
      continue;
    }
    const bool opens = start.g <= phase_.touching();
    const GapClosure closure = closure_of(start, *end, h, phase_.touching());
    const double from = opens ? t_0 + h * std::max(0.0, closure.before) : -infinite;
    windows_.push_back({from, t_0 + h * closure.after});
  }
}

std::vector<double> ExactContactRun::entries(double t, const Marks& marks) const {
  std::vector<double> all{marks.reserve + reserve_rounding};
  all.insert(all.end(), marks.slips.begin(), marks.slips.end());
  double least_new = infinite;
  const std::size_t first = all.size();
  all.resize(first + now_.gaps.size(), infinite);
  for (const Gap& gap : marks.gaps) {
    const auto start =
        std::ranges::find_if(now_.gaps, [&](const Gap& g) { return g.law == gap.law && g.key == gap.key; });
    const auto k = static_cast<std::size_t>(start - now_.gaps.begin());
    if (start == now_.gaps.end())
      least_new = std::min(least_new, gap.g + phase_.touching());
    else if (windows_.empty() || t > windows_[k].from)
      all[first + k] = gap.g;
  }
  all.push_back(least_new);
  return all;
}

Failure ExactContactRun::take_up_to(double t_1, StepEnd& end, const Attempt& attempt) {
  if (Failure failure = end_at_switch(t_1, end, attempt)) return failure;
  if (Failure failure = take_in_phase(t_1, end, attempt)) return failure;
  return done() || step_limit_ < infinite ? Failure{} : switch_drives();
}

/// Lets inputs jump and drives change their statuses, after which forces may begin another phase.
Failure ExactContactRun::switch_drives() {
  const double t = now();
  if (!drives_.switch_at(t, as_span(q), as_span(v))) return {};
  return begin_phase(t, phase_.closed);
}

Failure ExactContactRun::begin_phase(double t, std::vector<ClosedConstraint> before) {
  if (Failure failure = decide(t)) return failure;
  note_changes(t, before, {}, {});
  if (Failure failure = settle(t)) return failure;
  trajectory.jump(as_span(v), as_span(a), as_span(drives_.x), as_span(drives_.dx));
  return {};
}

Failure ExactContactRun::pass(double t_1, const Failure& why) {
  if (!phase_.points_change()) return why;
  const double t = now(), rest = step_end(last_) - t;
  StepEnd end;
  end.q.resize(q.size());
  ContactPhase::Points here, later;
  const auto points_after = [&](double h, ContactPhase::Points& points) {
    end.v = h * v;
    group().move(q, end.v, end.q);
    return phase_.points_at(end.q, points);
  };
  // Where a corner has just passed an edge, points coincide to rounding. The motion is followed until they
  // are apart.
  constexpr double longest = 1e-6;
  double h = t_1 - t;
  if (std::string fails = points_after(h, here); !fails.empty()) return {t, fails};
  while (h < rest && h < longest * last_) {
    if (std::string fails = points_after(2 * h, later); !fails.empty()) return {t, fails};
    if (here.apart && here == later) break;
    here = later;
    h = std::min(2 * h, rest);
  }
  t_1 = h < rest ? t + h : step_end(last_);
  end.v = h * v;
  group().move(q, end.v, end.q);
  end.v = v + h * a;
  end.x = drives_.x + h * drives_.dx;
  follow(t_1);
  std::vector<ClosedConstraint> before;
  if (std::string fails = phase_.replace_points(end.q, end.v, before); !fails.empty()) return {t, fails};
  if (Failure failure = accept(t_1, end)) return failure;
  if (done()) return {};
  before.insert(before.end(), phase_.closed.begin(), phase_.closed.end());
  return begin_phase(t_1, before);
}

Failure ExactContactRun::take_in_phase(double t_1, StepEnd& end, const Attempt& attempt) {
  const double t_0 = now();
  Marks marks;
  if (Failure failure = mark(t_1, end, marks)) return failure;
  predict(t_1, marks);
  std::vector<double> found = entries(t_1, marks);
  double closes = infinite;  // the first gap that closes before the end, of those that are open there
  for (std::size_t k = 0; k < windows_.size(); ++k)
    if (const double g = found[1 + marks.slips.size() + k]; !(g < 0))
      closes = std::min(closes, windows_[k].closes);
  if (closes < t_1 && closes > t_0) {
    StepEnd dip;
    Marks at_dip;
    if (Failure failure = attempt(closes, dip)) return failure;
    if (Failure failure = mark(closes, dip, at_dip)) return failure;
    if (std::vector<double> there = entries(closes, at_dip); std::ranges::any_of(there, is_negative)) {
      t_1 = closes;
      end = dip;
      marks = at_dip;
      found = there;
    }
  }
  const auto go_on = [&](double t) {
    if (Failure failure = accept(t, end)) return failure;
    return done() ? Failure{} : settle(t);
  };
  if (!std::ranges::any_of(found, is_negative)) return go_on(t_1);
  const double t_far = t_1, reserve_far = found[0];
  if (Failure failure = find_event(t_1, end, found, marks, attempt)) return failure;
  // A step that is shortened for these reasons is repeated with its error estimate.
  step_limit_ = before_turn(t_1, found, marks);
  if (t_1 - t_0 > least_divided * last_ && is_beyond_a_root(found, marks.slips.size()))
    step_limit_ = t_0 + (t_1 - t_0) / 2;
  if (step_limit_ < t_1) return {};
  std::vector<ClosedConstraint> next;
  if (std::none_of(found.begin() + 1, found.end(), is_negative)) {
    if (Failure failure = look_ahead(t_1, t_far, reserve_far, attempt, next)) return failure;
    // If the step is too short to decide what changes, the phase lasts until its end.
    constexpr double undecided = 1e-8;  // part of a force
    const bool changes = reserve_far < -undecided || !std::ranges::equal(next, phase_.closed, is_as_before);
    if (Failure failure = attempt(changes ? t_1 : t_far, end)) return failure;
    if (!changes) return go_on(t_far);
  }
  constexpr double quick = 1e-11;
  constexpr int most_quick = 100;
  quick_events_ = t_1 - last_event_ < quick * last_ ? quick_events_ + 1 : 0;
  last_event_ = t_1;
  if (quick_events_ > most_quick)
    return {t_1, "contacts change more than " + std::to_string(most_quick) + " times at nearly one time" +
                     ContactPhase::instead};
  const std::vector<char> stopped = stopping(t_1, found, marks);
  if (Failure failure = accept(t_1, end)) return failure;
  return done() ? Failure{} : change(t_1, found, stopped, next);
}

Failure ExactContactRun::find_event(double& t_1, StepEnd& end, std::vector<double>& at_high, Marks& marks,
                                    const Attempt& attempt) {
  const double t_0 = now(), resolution = std::max(2e-15 * (t_1 - t_0), 2.3e-16 * t_1);
  ChangeSearch search(t_0, t_1, resolution, entries(t_0, now_), at_high);
  StepEnd here, after = end;
  while (search.continues()) {
    const double t = search.t();
    Marks there;
    if (Failure failure = attempt(t, here)) return failure;
    if (Failure failure = mark(t, here, there)) return failure;
    if (!search.take(entries(t, there))) continue;
    marks = there;
    after = here;
  }
  t_1 = search.found();
  at_high = search.numbers();
  end = after;
  return {};
}

/// Says whether a gap of an event is so negative that it was 0 before: predict() then expected that it closes
/// later, because the step is too long for the course of the gap to be a polynomial.
bool ExactContactRun::is_beyond_a_root(const std::vector<double>& found, std::size_t slips) const {
  constexpr double several = 10;
  return std::any_of(found.begin() + 1 + static_cast<std::ptrdiff_t>(slips), found.end(),
                     [&](double gap) { return gap < -several * phase_.touching(); });
}

double ExactContactRun::before_turn(double t, const std::vector<double>& found, const Marks& marks) const {
  const double length = t - now();
  double part = 1;
  for (std::size_t k = 0; k < marks.slips.size(); ++k) {
    if (!(found[1 + k] < 0) || !(now_.speeds[k] > 0)) continue;
    // The velocity vanishes at this time to within the time that it takes to change by itself.
    const bool rests = marks.speeds[k] <= slow * phase_.resolution;
    if (!rests && marks.speeds[k] / now_.speeds[k] * length > at_once) part = 0.5;
  }
  return now() + part * length;
}

/// Says for each constraint whether it ceases to slide at t, or would do so a moment later.
std::vector<char> ExactContactRun::stopping(double t, const std::vector<double>& found,
                                            const Marks& marks) const {
  const double length = t - now();
  const std::size_t n = marks.slips.size();
  const bool any =
      std::any_of(found.begin() + 1, found.begin() + 1 + static_cast<std::ptrdiff_t>(n), is_negative);
  std::vector<char> out(n);
  if (!any) return out;
  for (std::size_t k = 0; k < n; ++k)
    out[k] = found[1 + k] < 0 || marks.speeds[k] * length < at_once * now_.speeds[k] ||
             marks.speeds[k] <= slow * phase_.resolution;
  return out;
}

/// Chooses the next phase (which contacts are closed, and which of them stick or slide) if the forces of the
/// present one reach their limits at the time t. The choice is made with the state at a slightly later time,
/// at which the violation of these limits is certain to be no rounding error.
Failure ExactContactRun::look_ahead(double t, double t_far, double reserve_far, const Attempt& attempt,
                                    std::vector<ClosedConstraint>& next) {
  constexpr double violation = 1e-5;
  const double part = reserve_far < -violation ? violation / -reserve_far : 1;
  const double t_ahead = std::max(t, t + part * (t_far - t));
  StepEnd ahead;
  if (Failure failure = attempt(t_ahead, ahead)) return failure;
  const std::vector<ClosedConstraint> present = phase_.closed;
  ContactPhase::Forces acting;
  drives_.act_at(as_span(ahead.x));
  if (Failure failure = find_forces(t_ahead, as_span(ahead.q), as_span(ahead.v), acting)) return failure;
  if (std::string why = phase_.decide(ahead.q, ahead.v, acting); !why.empty()) return {t, why};
  next = phase_.closed;
  phase_.closed = present;
  return {};
}

/// Projects the state at the end of a step on the constraints of the phase and appends it to the trajectory.
Failure ExactContactRun::accept(double t, StepEnd& end) {
  step_limit_ = infinite;
  follow(t);
  if (phase_.any()) {
    if (std::string why = phase_.project(end.q, end.v); !why.empty()) return {t, why};
    phase_.follow_directions(end.v);
  }
  end.a.resize(end.v.size());
  drives_.act_at(as_span(end.x));
  if (Failure failure = accelerate(t, as_span(end.q), as_span(end.v), as_span(end.a))) return failure;
  end.dx = as_eigen(drives_.rates());
  static_cast<void>(phase_.reserve());
  if (phase_.any()) certificate_ = std::max(certificate_, phase_.certificate());
  constexpr double lawless = 1e-3;
  if (certificate_ > lawless)
    return {t, "no forces were found that obey the laws of contact (certificate " + to_text(certificate_) +
                   ")" + ContactPhase::instead};
  Failure failure = record(t, {.q = end.q, .v = end.v, .a = end.a, .x = end.x, .dx = end.dx});
  if (const double t_end = trajectory.t().back(); t_end < t) {  // a terminal event of the caller
    const std::size_t k = trajectory.size() - 1;
    const Vector q_end = as_eigen(trajectory.q(k)), v_end = as_eigen(trajectory.v(k));
    const Vector x_end = drives_.x;  // at the event
    if (Failure f = accelerate(t_end, as_span(q_end), as_span(v_end), as_span(end.a))) return f;
    static_cast<void>(phase_.reserve());
    trajectory.pop_back();
    trajectory.append(t_end, as_span(q_end), as_span(v_end), as_span(end.a), as_span(tau_), as_span(x_end),
                      drives_.rates());
  }
  trajectory.certificates.push_back(certificate_);
  trajectory.set_contacts(phase_.forces());
  certificate_ = 0;
  return failure;
}

/// Changes to the next phase: that of look_ahead() or, if this is empty, the one after impacts and stops.
Failure ExactContactRun::change(double t, const std::vector<double>& found, const std::vector<char>& stopped,
                                const std::vector<ClosedConstraint>& next) {
  const bool by_forces = std::none_of(found.begin() + 1, found.end(), is_negative);
  if (!by_forces) {
    if (Failure failure = meet(t, found, stopped)) return failure;
  } else {
    const std::vector<ClosedConstraint> before = phase_.closed;
    phase_.take_next(next);
    note_changes(t, before, {}, {});
    if (Failure failure = settle(t)) return failure;
  }
  trajectory.jump(as_span(v), as_span(a), as_span(drives_.x), as_span(drives_.dx));
  trajectory.certificates.back() = std::max(trajectory.certificates.back(), certificate_);
  return {};
}

/// Stops what has ceased to slide, computes the impacts at the present time, and chooses the next phase.
Failure ExactContactRun::meet(double t, const std::vector<double>& found, const std::vector<char>& stopped) {
  const std::vector<ClosedConstraint> before = phase_.closed;
  for (std::size_t k = 0; k < before.size(); ++k)
    if (stopped[k]) phase_.closed[k].branch = LawBranch::stick;
  const auto fails = [&](const std::string& why) { return why.empty() ? Failure{} : Failure{t, why}; };
  follow(t);
  if (Failure failure = fails(phase_.project(q, v))) return failure;
  std::vector<ContactPhase::Impact> met;
  const bool touches =
      std::any_of(found.begin() + 1 + static_cast<std::ptrdiff_t>(before.size()), found.end(), is_negative);
  if (touches) {
    // A bounce is the last one if the next flight is lower than places can be resolved (D11.35).
    const auto is_last = [&](const Gap& of, double e) {
      const auto last = last_impact_.find({of.law, of.key});
      return last != last_impact_.end() &&
             e * e * -of.dg * (t - last->second) / 4 < unresolved_part * phase_.touching();
    };
    if (Failure failure = fails(phase_.impact(q, v, is_last, met, certificate_))) return failure;
    for (const ContactPhase::Impact& it : met) last_impact_[{it.law, it.key}] = t;
  }
  if (Failure failure = fails(phase_.project(q, v))) return failure;
  if (Failure failure = decide(t)) return failure;
  if (Failure failure = settle(t)) return failure;
  if (touches)
    if (Failure failure = end_short_flights(t, met)) return failure;
  note_changes(t, before, met, stopped);
  return {};
}

/// Closes the contacts and stops that open in an impact at the present time t so slowly that their next
/// flight is lower than places can be resolved (D11.35a). A body that rocks to rest would open and close them
/// infinitely often. The impacts in `met` then count as shortened. settle() must have been called.
Failure ExactContactRun::end_short_flights(double t, std::vector<ContactPhase::Impact>& met) {
  const double touching = phase_.touching(), highest = unresolved_part * touching;
  std::vector<Gap> brief;
  for (const Gap& gap : now_.gaps)
    if (gap.g <= touching && gap.dg > 0 && gap.dg * gap.dg < -2 * gap.ddg * highest) brief.push_back(gap);
  if (brief.empty()) return {};
  if (std::string why = phase_.close(brief, q, v); !why.empty()) return {t, std::move(why)};
  for (ContactPhase::Impact& it : met) {
    it.bounces = false;
    it.shortened = true;
  }
  if (Failure failure = decide(t)) return failure;
  return settle(t);
}

/// Computes the accelerations at the present state in the present phase, and what may end this phase.
Failure ExactContactRun::settle(double t) {
  constexpr double several = 10;  // errors of velocities of one body that act together
  const double fastest = v.size() > 0 ? v.lpNorm<Eigen::Infinity>() : 0;
  phase_.resolution = several * tolerances_.absolute + tolerances_.relative * fastest;
  if (Failure failure = mark(t, q, v, drives_.x, a, now_)) return failure;
  drives_.dx = as_eigen(drives_.rates());
  return {};
}

void ExactContactRun::add_event(const ContactPhase::Impact& it, double t) {
  trajectory.contact_events.push_back({.kind = it.bounces ? Kind::bounce : Kind::close,
                                       .t = t,
                                       .of = phase_.name_of(it.law, it.key),
                                       .key = it.law == ContactLaw::contact ? it.key : 0,
                                       .speed = it.speed,
                                       .shortened = it.shortened});
}

/// Adds the events at time t to the trajectory: the impacts in `met`, each a bounce or a closure; contacts
/// and stops that have closed or opened without an impact; and contacts and joints with dry friction that
/// have begun, ceased or reversed sliding. All but the impacts follow from a comparison of the constraints
/// before the events, in `before`, with the present ones: closed contacts and stops, and all joints with dry
/// friction. stopped[k] says whether the sliding velocity of constraint k of `before` has become 0; if it
/// still slides, it has reversed.
void ExactContactRun::note_changes(double t, const std::vector<ClosedConstraint>& before,
                                   const std::vector<ContactPhase::Impact>& met,
                                   const std::vector<char>& stopped) {
  for (const ContactPhase::Impact& it : met) add_event(it, t);
  const auto add = [&](Kind kind, const ClosedConstraint& c) {
    trajectory.contact_events.push_back({.kind = kind,
                                         .t = t,
                                         .of = phase_.name_of(c.law, c.key),
                                         .key = c.law == ContactLaw::contact ? c.key : 0});
  };
  const auto in = [](const auto& list, const ClosedConstraint& c) {
    return std::ranges::find_if(list, [&](const auto& x) { return x.law == c.law && x.key == c.key; });
  };
  for (std::size_t k = 0; k < before.size(); ++k) {
    const auto now = in(phase_.closed, before[k]);
    const bool slid = before[k].branch == LawBranch::slide, stops = !stopped.empty() && stopped[k];
    if (now == phase_.closed.end()) {
      if (in(met, before[k]) == met.end()) add(Kind::open, before[k]);
    } else if (now->branch == LawBranch::stick) {
      if (slid) add(Kind::stick, before[k]);
    } else if (!slid) {
      add(Kind::slip, before[k]);
    } else if (stops) {
      add(Kind::reverse, before[k]);
    }
  }
  for (const ClosedConstraint& c : phase_.closed)
    if (in(before, c) == before.end() && in(met, c) == met.end()) add(Kind::close, c);
}

}  // namespace axode
