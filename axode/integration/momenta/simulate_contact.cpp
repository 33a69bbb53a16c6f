#include "axode/integration/momenta/simulate_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "axode/integration/methods.hpp"
#include "axode/integration/momenta/contact_step.hpp"
#include "axode/integration/schemes/explicit_steps.hpp"
#include "axode/model/building/checks/value_checks.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

/// The properties that simulations with contact count: those that rollouts with contact count, prescribed
/// motions and drives.
constexpr catalog::Counts of_simulations = [] {
  constexpr catalog::OtherId contact("contact");
  catalog::Counts counts = catalog::other_functions[contact.index].counts;
  counts.motions = counts.drives = catalog::counted;
  return counts;
}();

void check_all(const Model& model, const ContactShapes& shapes, const SimulationOptions& options) {
  check_shapes(model, shapes);
  catalog::check_counts("contact", of_simulations, model, catalog::Caller::whole);
  if (options.coordinates != Coordinates::relative)
    throw std::invalid_argument("contact needs coordinates = \"relative\"; got \"" +
                                std::string(to_string(options.coordinates)) + '"');
  if (options.local_coordinates != LocalCoordinates::exponential)
    throw std::invalid_argument("contact needs local_coordinates = \"exponential\"; got \"cayley\"");
}

/// The options of the free motion: losses of joints belong to the step with contact.
SimulationOptions without_losses(SimulationOptions options) {
  options.joint_losses = false;
  return options;
}

/// A motion with contact under integration.
class ContactMotion {
 public:
  ContactMotion(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                std::span<const double> v, double until, const SimulationOptions& options)
      : model_(model),
        free_options_(without_losses(options)),
        run_(model, q, v, until, free_options_, options.joint_losses),
        scheme_(run_, run_.closed_model(), shapes, options.joint_losses),
        until_(until) {
    for (int i = 0; i < shapes.size(); ++i) run_.trajectory.contact_shapes.push_back(shapes[i].name);
    const auto add = [&](const std::string& name) { moved_ += (moved_.empty() ? "" : ", ") + quoted(name); };
    for (const MotionDescription& motion : model.motions()) add(motion.of);
    for (const PrescribedMotion& motion : options.motions) add(motion.of);
  }

  Trajectory in_steps_of(double step) {
    each_part(run_, until_, step, [&](double t_1) {
      Computed end;
      if (Failure failure = compute_up_to_switch(t_1, end)) return failure;
      return take(t_1, end);
    });
    return std::move(run_.trajectory);
  }

  /// Integrates in adaptive steps: computes each step as a whole and in two halves, and takes the halves if
  /// both agree; otherwise tries a shorter step. A step not longer than `least` times the whole motion is
  /// always taken, because halves and whole may follow different solutions of the laws of contact.
  Trajectory within(const Tolerances& tolerances) {
    constexpr double first = 1e-3, least = 1e-9, order = 3;
    const double longest = tolerances.largest_step > 0 ? tolerances.largest_step : until_ / 50;
    double h = tolerances.first_step > 0 ? tolerances.first_step : first;
    while (!run_.done()) {
      const double t = run_.now(), latest = run_.step_end(until_), rest = latest - t;
      h = std::min({h, longest, rest});
      const bool last = h >= rest * (1 - 1e-12), shortest = h <= least * until_;
      const double planned = last ? latest : t + h;
      double t_1 = planned, middle = t;
      Computed whole, one, two;
      const Failure failure = [&] {
        if (Failure f = compute_up_to_switch(t_1, whole)) return f;
        middle = t + (t_1 - t) / 2;
        if (Failure f = compute(t, middle, present(), one)) return f;
        return compute(middle, t_1, one.end, two);
      }();
      if (failure && (shortest || run_.interruption(t))) {
        run_.stop(failure);
        break;
      }
      const double error = failure
                               ? std::numeric_limits<double>::infinity()
                               : difference(whole, two, std::max(one.unresolved, two.unresolved), tolerances);
      if (!(error <= 1) && !shortest) {
        ++run_.trajectory.rejected;
        h = t_1 - t;
        h *= std::isfinite(error) ? std::max(0.2, 0.9 * std::pow(error, -1 / order)) : 0.1;
        continue;
      }
      for (const auto& [end, half] : {std::pair{middle, &one}, std::pair{t_1, &two}})
        if (!run_.done())
          if (Failure f = take(end, *half)) run_.stop(f);
      if (!run_.done())
        if (Failure f = run_.switch_drives()) run_.stop(f);
      if (t_1 == planned) h *= std::clamp(0.9 * std::pow(std::max(error, 1e-10), -1 / order), 0.2, 5.0);
    }
    return std::move(run_.trajectory);
  }

 private:
  using Vector = Eigen::VectorXd;

  /// A step that the scheme has computed; its end has no accelerations.
  struct Computed {
    StepEnd end;
    double certificate = 0, unresolved = 0;
    bool touched = false;
    std::vector<ContactForce> forces = {};
  };

  Computed computed() const {
    return {{.q = scheme_.q, .v = scheme_.v, .x = scheme_.drive_states},
            scheme_.certificate,
            scheme_.unresolved,
            scheme_.touched,
            {scheme_.forces().begin(), scheme_.forces().end()}};
  }
  StepEnd present() { return {.q = run_.q, .v = run_.v, .x = run_.drives().x}; }
  Failure compute(double t, double t_1, const StepEnd& from, Computed& out) {
    if (Failure failure = scheme_.run(t, t_1 - t, from.q, from.v, from.x)) return failure;
    out = computed();
    constexpr double blocked = 0.1;  // a certificate with which no step makes sense
    Failure failure = run_.check_closed(t_1, out.end.q);
    if (moved_.empty() || !(failure || out.certificate > blocked)) return failure;
    return {t_1, "contacts, stops or loops block the prescribed motion of " + moved_};
  }
  /// Computes the step from the present state to t_1, or to an earlier time at which a drive changes to a
  /// branch of its law with other forces; t_1 then becomes this time.
  Failure compute_up_to_switch(double& t_1, Computed& out) {
    const StepEnd from = present();
    const double t = run_.now();
    if (Failure failure = compute(t, t_1, from, out)) return failure;
    if (run_.drives().empty()) return {};
    std::map<double, Computed> attempts;  // by their ends
    const Attempt attempt = [&](double t_end, StepEnd& end) {
      Computed& it = attempts[t_end];
      Failure failure = compute(t, t_end, from, it);
      end = it.end;
      return failure;
    };
    StepEnd end = out.end;
    if (Failure failure = run_.end_at_switch(t_1, end, attempt, true)) return failure;
    if (const auto cut = attempts.find(t_1); cut != attempts.end()) out = std::move(cut->second);
    return {};
  }
  Failure take(double t_1, Computed& step) {
    run_.trajectory.certificates.push_back(step.certificate);
    // Without accelerations, those of the free motion are taken.
    if (step.touched || !run_.closed_model().loops().empty())
      step.end.a = (step.end.v - run_.v) / (t_1 - run_.now());
    if (Failure failure = run_.take_contact(t_1, std::move(step.end))) return failure;
    run_.trajectory.set_contacts(step.forces);
    return {};
  }
  /// The error of a step as a multiple of the tolerances: the root mean square of the differences between the
  /// whole step and its halves or, if larger, `unresolved`, an error by slip that the differences do not
  /// show.
  double difference(const Computed& whole, const Computed& halves, double unresolved,
                    const Tolerances& tolerances) {
    const StepEnd &one = whole.end, &two = halves.end;
    const auto nv = static_cast<std::size_t>(one.v.size());
    if (nv == 0) return 0;
    const std::vector<double> d = axode::difference(model_, as_span(one.q), as_span(two.q)),
                              moved = axode::difference(model_, as_span(run_.q), as_span(two.q));
    const double relative = tolerances.relative, absolute = tolerances.absolute;
    double squares = 0;
    for (std::size_t c = 0; c < nv; ++c) {
      const auto k = static_cast<Eigen::Index>(c);
      const double by_q = d[c] / (absolute + relative * std::max(1.0, std::abs(moved[c])));
      const double v = std::max(std::abs(run_.v[k]), std::abs(two.v[k]));
      const double by_v = (one.v[k] - two.v[k]) / (absolute + relative * v);
      squares += by_q * by_q + by_v * by_v;
    }
    const DriveStates& drives = run_.drives();
    const auto size_of_x = drives.x.array().abs().max(two.x.array().abs());
    squares += ((one.x - two.x).array() / (absolute * drives.nominal().array() + relative * size_of_x))
                   .square()
                   .sum();
    const double n = static_cast<double>(2 * nv + drives.size());
    return std::max(std::sqrt(squares / n), unresolved / (absolute + relative));
  }

  Model model_;
  SimulationOptions free_options_;
  ContactSimulationRun run_;
  ContactStep scheme_;
  double until_;
  std::string moved_;  ///< the joints and rods that follow motions, for messages
};

}  // namespace

void check_contact(const Model& model, const ContactShapes& shapes) {
  check_shapes(model, shapes);
  catalog::check_counts<"contact">(model);
}

Trajectory simulate_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                            std::span<const double> v, double until, double step,
                            const SimulationOptions& options) {
  check_step(step);
  check_all(model, shapes, options);
  return ContactMotion(model, shapes, q, v, until, options).in_steps_of(step);
}

Trajectory simulate_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                            std::span<const double> v, double until, const Tolerances& tolerances,
                            const SimulationOptions& options) {
  check_tolerances(tolerances);
  check_all(model, shapes, options);
  return ContactMotion(model, shapes, q, v, until, options).within(tolerances);
}

Trajectory simulate_contact(const Model& model, std::span<const double> q, std::span<const double> v,
                            double until, double step, const SimulationOptions& options) {
  return simulate_contact(model, ContactShapes(model), q, v, until, step, options);
}

Trajectory simulate_contact(const Model& model, std::span<const double> q, std::span<const double> v,
                            double until, const Tolerances& tolerances, const SimulationOptions& options) {
  return simulate_contact(model, ContactShapes(model), q, v, until, tolerances, options);
}

}  // namespace axode
