#include "axode/integration/momenta/contact_motion.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "axode/integration/schemes/explicit_steps.hpp"

namespace axode {
namespace {

/// The options of the free motion: losses of joints belong to the step with contact.
SimulationOptions without_losses(SimulationOptions options) {
  options.joint_losses = false;
  return options;
}

}  // namespace

ContactSteps::ContactSteps(ContactSimulationRun& run, const ContactShapes& shapes, bool dry_friction)
    : run_(&run), scheme_(run, run.closed_model(), shapes, dry_friction) {}

Failure ContactSteps::compute(double t, double t_1, const StepEnd& from, ComputedContactStep& out) {
  if (Failure failure = scheme_.run(t, t_1 - t, from.q, from.v, from.x)) return failure;
  out.end.q = scheme_.q;
  out.end.v = scheme_.v;
  out.end.x = scheme_.drive_states;
  out.certificate = scheme_.certificate;
  out.unresolved = scheme_.unresolved;
  out.touched = scheme_.touched;
  out.forces.assign(scheme_.forces().begin(), scheme_.forces().end());
  return run_->check_closed(t_1, out.end.q, out.certificate);
}

Failure ContactSteps::compute_up_to_switch(double& t_1, ComputedContactStep& out) {
  from_.q = run_->q;
  from_.v = run_->v;
  from_.x = run_->drives().x;
  const double t = run_->now(), planned = t_1;
  if (Failure failure = compute(t, t_1, from_, out)) return failure;
  if (run_->drives().empty()) return {};
  double last = t;
  const auto attempt = [&](double t_end, StepEnd& end) {
    // The search goes back only from an attempt that ended after the change.
    if (t_end < last) std::swap(after_, attempt_);
    last = t_end;
    Failure failure = compute(t, t_end, from_, attempt_);
    end = attempt_.end;
    return failure;
  };
  end_ = out.end;
  if (Failure failure = run_->end_at_switch(t_1, end_, std::ref(attempt), true)) return failure;
  if (t_1 < planned) std::swap(out, t_1 == last ? attempt_ : after_);
  return {};
}

ContactMotion::ContactMotion(const Model& model, const ContactShapes& shapes, Span q, Span v, double until,
                             const SimulationOptions& options)
    : model_(model),
      shapes_(shapes),
      options_(options),
      free_options_(without_losses(options)),
      q_0_(as_eigen(q)),
      v_0_(as_eigen(v)),
      run_(model_, q, v, until, free_options_, options.joint_losses),
      steps_(run_, shapes_, options.joint_losses),
      until_(until) {
  for (int i = 0; i < shapes.size(); ++i) run_.trajectory.contact_shapes.push_back(shapes[i].name);
}

std::unique_ptr<ContactMotion> ContactMotion::fork() const {
  auto made =
      std::make_unique<ContactMotion>(model_, shapes_, as_span(q_0_), as_span(v_0_), until_, options_);
  made->run_.continue_from(run_);
  made->steps_.continue_from(steps_);
  made->length_ = length_;
  return made;
}

void ContactMotion::take_steps(double step) {
  each_part(run_, until_, step, [&](double t_1) {
    ComputedContactStep computed;
    if (Failure failure = steps_.compute_up_to_switch(t_1, computed)) return failure;
    return take(t_1, computed);
  });
}

void ContactMotion::take_steps(const Tolerances& tolerances) {
  constexpr double first = 1e-3, least = 1e-9, order = 3;
  const double longest = tolerances.largest_step > 0 ? tolerances.largest_step : until_ / 50;
  if (length_ == 0) length_ = tolerances.first_step > 0 ? tolerances.first_step : first;
  std::vector<Rejection> rejections;  // those whose ends have not been reached
  while (!run_.done()) {
    const double t = run_.now(), latest = run_.step_end(until_), rest = latest - t;
    const double h = std::min({length_, longest, rest});
    const bool last = h >= rest * (1 - 1e-12), shortest = h <= least * until_;
    const double planned = last ? latest : t + h;
    double t_1 = planned, middle = t;
    ComputedContactStep whole, one, two;
    const Failure failure = [&] {
      if (Failure f = steps_.compute_up_to_switch(t_1, whole)) return f;
      middle = t + (t_1 - t) / 2;
      if (Failure f = steps_.compute(t, middle, present(), one)) return f;
      return steps_.compute(middle, t_1, one.end, two);
    }();
    if (failure && (shortest || run_.interruption(t))) return run_.stop(failure);
    Difference found;
    if (!failure)
      found = difference(whole, two, std::max(one.unresolved, two.unresolved), t_1 - t, tolerances);
    std::erase_if(rejections, [t](const Rejection& old) { return old.end <= t; });
    const double error = found.of_all;
    const bool undecided = found.of_places <= 1 && std::ranges::any_of(rejections, [&](const Rejection& old) {
                             return old.h >= 100 * (t_1 - t) && error >= 0.25 * old.error;
                           });
    if (!(error <= 1) && !shortest && !undecided) {
      ++run_.trajectory.rejected;
      if (std::isfinite(error)) rejections.push_back({t_1, t_1 - t, error});
      length_ = t_1 - t;
      length_ *= std::isfinite(error) ? std::max(0.2, 0.9 * std::pow(error, -1 / order)) : 0.1;
      continue;
    }
    for (const auto& [end, half] : {std::pair{middle, &one}, std::pair{t_1, &two}})
      if (!run_.done())
        if (Failure f = take(end, *half)) run_.stop(f);
    if (!run_.done())
      if (Failure f = run_.switch_drives()) run_.stop(f);
    if (t_1 < planned) continue;
    const double next = h * std::clamp(0.9 * std::pow(std::max(error, 1e-10), -1 / order), 0.2, 5.0);
    length_ = last ? std::max(length_, next) : next;
  }
}

void ContactMotion::continue_until(double until) {
  until_ = until;
  if (Failure failure = run_.continue_until(until)) run_.stop(failure);
}

Failure ContactMotion::take(double t_1, ComputedContactStep& step) {
  run_.trajectory.certificates.push_back(step.certificate);
  // Without accelerations, those of the free motion are taken.
  if (step.touched || !run_.closed_model().loops().empty())
    step.end.a = (step.end.v - run_.v) / (t_1 - run_.now());
  if (Failure failure = run_.take_contact(t_1, std::move(step.end))) return failure;
  run_.trajectory.set_contacts(step.forces);
  return {};
}

/// Computes two errors of a step of length h (s), as multiples of the tolerances, from the differences
/// between the end of the whole step and the end of its two halves. The first is the root mean square of the
/// differences of positions, velocities and drive states, each divided by its tolerance. In the second, a
/// difference of velocities counts only as a displacement: its magnitude times h is added to that of the
/// difference of positions. Neither error is less than `unresolved` (m) divided by the sum of the absolute
/// and the relative tolerance. `unresolved` estimates an error that the differences do not show, which arises
/// because a contact began to stick at an unknown time in the step.
ContactMotion::Difference ContactMotion::difference(const ComputedContactStep& whole,
                                                    const ComputedContactStep& halves, double unresolved,
                                                    double h, const Tolerances& tolerances) {
  const StepEnd &one = whole.end, &two = halves.end;
  const auto nv = static_cast<std::size_t>(one.v.size());
  if (nv == 0) return {0, 0};
  const std::vector<double> d = axode::difference(model_, as_span(one.q), as_span(two.q)),
                            moved = axode::difference(model_, as_span(run_.q), as_span(two.q));
  const double relative = tolerances.relative, absolute = tolerances.absolute;
  double squares = 0, of_places = 0;
  for (std::size_t c = 0; c < nv; ++c) {
    const auto k = static_cast<Eigen::Index>(c);
    const double for_q = absolute + relative * std::max(1.0, std::abs(moved[c]));
    const double v = std::max(std::abs(run_.v[k]), std::abs(two.v[k])), dv = one.v[k] - two.v[k];
    squares += std::pow(d[c] / for_q, 2) + std::pow(dv / (absolute + relative * v), 2);
    of_places += std::pow((std::abs(d[c]) + h * std::abs(dv)) / for_q, 2);
  }
  const DriveStates& drives = run_.drives();
  const auto size_of_x = drives.x.array().abs().max(two.x.array().abs());
  const double of_drives =
      ((one.x - two.x).array() / (absolute * drives.nominal().array() + relative * size_of_x)).square().sum();
  const double n = static_cast<double>(2 * nv + drives.size()), slip = unresolved / (absolute + relative);
  return {std::max(std::sqrt((squares + of_drives) / n), slip),
          std::max(std::sqrt((of_places + of_drives) / n), slip)};
}

}  // namespace axode
