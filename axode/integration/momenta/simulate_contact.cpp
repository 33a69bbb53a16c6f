#include "axode/integration/momenta/simulate_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "axode/integration/methods.hpp"
#include "axode/integration/momenta/contact_step.hpp"
#include "axode/integration/schemes/explicit_steps.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

constexpr const char* instead = "simulate without contact, or drive the joints by tau";

void check_all(const Model& model, const ContactShapes& shapes, const SimulationOptions& options) {
  check_contact(model, shapes);
  if (options.coordinates != Coordinates::relative)
    throw std::invalid_argument("contact needs coordinates = \"relative\"; got \"" +
                                std::string(to_string(options.coordinates)) + '"');
  if (!options.motions.empty())
    throw std::invalid_argument("contact does not count the prescribed motion of \"" +
                                options.motions.front().of + "\"; " + instead);
  if (!options.x.empty())
    throw std::invalid_argument("x is given, and contact does not count drives with states");
  if (!options.drives.empty())
    throw std::invalid_argument("contact does not count drive \"" + options.drives.front().name + "\"; " +
                                instead);
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
        scheme_(run_, model, shapes, options.joint_losses),
        until_(until) {
    for (int i = 0; i < shapes.size(); ++i) run_.trajectory.contact_shapes.push_back(shapes[i].name);
  }

  Trajectory in_steps_of(double step) {
    each_step(run_, until_, step, [&](double t_1) {
      if (Failure failure = scheme_.run(run_.now(), t_1 - run_.now(), run_.q, run_.v)) return failure;
      return take(t_1, computed());
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
      const double t = run_.now(), rest = until_ - t;
      h = std::min({h, longest, rest});
      const bool last = h >= rest * (1 - 1e-12), shortest = h <= least * until_;
      const double t_1 = last ? until_ : t + h, middle = t + (t_1 - t) / 2;
      Computed whole, one, two;
      const Failure failure = [&] {
        if (Failure f = compute(t, t_1, run_.q, run_.v, whole)) return f;
        if (Failure f = compute(t, middle, run_.q, run_.v, one)) return f;
        return compute(middle, t_1, one.q, one.v, two);
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
        h *= std::isfinite(error) ? std::max(0.2, 0.9 * std::pow(error, -1 / order)) : 0.1;
        continue;
      }
      for (const auto& [end, half] : {std::pair{middle, &one}, std::pair{t_1, &two}})
        if (!run_.done())
          if (Failure f = take(end, *half)) run_.stop(f);
      h *= std::clamp(0.9 * std::pow(std::max(error, 1e-10), -1 / order), 0.2, 5.0);
    }
    return std::move(run_.trajectory);
  }

 private:
  using Vector = Eigen::VectorXd;

  /// A step that the scheme has computed.
  struct Computed {
    Vector q, v;
    double certificate = 0, unresolved = 0;
    bool touched = false;
    std::vector<ContactForce> forces = {};
  };

  Computed computed() const {
    return {scheme_.q,          scheme_.v,       scheme_.certificate,
            scheme_.unresolved, scheme_.touched, {scheme_.forces().begin(), scheme_.forces().end()}};
  }
  Failure compute(double t, double t_1, const Vector& q, const Vector& v, Computed& out) {
    if (Failure failure = scheme_.run(t, t_1 - t, q, v)) return failure;
    out = computed();
    return {};
  }
  Failure take(double t_1, const Computed& step) {
    run_.trajectory.certificates.push_back(step.certificate);
    Vector a;  // that of the free motion if it is empty
    if (step.touched || !model_.loops().empty()) a = (step.v - run_.v) / (t_1 - run_.now());
    if (Failure failure = run_.take_contact(t_1, step.q, step.v, a)) return failure;
    run_.trajectory.set_contacts(step.forces);
    return {};
  }
  /// The error of a step as a multiple of the tolerances: the root mean square of the differences between the
  /// whole step and its halves or, if larger, `unresolved`, an error by slip that the differences do not
  /// show.
  double difference(const Computed& whole, const Computed& halves, double unresolved,
                    const Tolerances& tolerances) {
    const auto nv = static_cast<std::size_t>(whole.v.size());
    if (nv == 0) return 0;
    const std::vector<double> d = axode::difference(model_, as_span(whole.q), as_span(halves.q)),
                              moved = axode::difference(model_, as_span(run_.q), as_span(halves.q));
    const double relative = tolerances.relative, absolute = tolerances.absolute;
    double squares = 0;
    for (std::size_t c = 0; c < nv; ++c) {
      const auto k = static_cast<Eigen::Index>(c);
      const double by_q = d[c] / (absolute + relative * std::max(1.0, std::abs(moved[c])));
      const double v = std::max(std::abs(run_.v[k]), std::abs(halves.v[k]));
      const double by_v = (whole.v[k] - halves.v[k]) / (absolute + relative * v);
      squares += by_q * by_q + by_v * by_v;
    }
    return std::max(std::sqrt(squares / static_cast<double>(2 * nv)), unresolved / (absolute + relative));
  }

  Model model_;
  SimulationOptions free_options_;
  ContactSimulationRun run_;
  ContactStep scheme_;
  double until_;
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
