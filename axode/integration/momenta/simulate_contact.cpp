#include "axode/integration/momenta/simulate_contact.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "axode/integration/methods.hpp"
#include "axode/integration/momenta/contact_motion.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

/// The properties that simulations and rollouts with contact count: those that their sensitivities count, and
/// drives.
constexpr catalog::Counts counts = [] {
  constexpr catalog::OtherId contact("contact");
  catalog::Counts out = catalog::other_functions[contact.index].counts;
  out.drives = catalog::counted;
  return out;
}();

}  // namespace

bool has_hard_stops(const Model& model) {
  const auto is_stopped = [](const Joint& joint) { return std::ranges::any_of(joint.dof, &Dof::hard_stops); };
  return std::ranges::any_of(model.joints(), is_stopped);
}

void check_contact(const Model& model, const ContactShapes& shapes) {
  check_shapes(model, shapes);
  catalog::check_counts("contact", counts, model, catalog::Caller::whole);
}

void check_contact_simulation(const char* method, const Model& model, const ContactShapes& shapes,
                              const SimulationOptions& options) {
  check_shapes(model, shapes);
  catalog::check_counts(method, counts, model, catalog::Caller::whole);
  if (options.coordinates != Coordinates::relative)
    throw std::invalid_argument(std::string(method) + " needs coordinates = \"relative\"; got \"" +
                                std::string(to_string(options.coordinates)) + '"');
  if (options.local_coordinates != LocalCoordinates::exponential)
    throw std::invalid_argument(std::string(method) +
                                " needs local_coordinates = \"exponential\"; got \"cayley\"");
}

Trajectory simulate_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                            std::span<const double> v, double until, double step,
                            const SimulationOptions& options) {
  check_step(step);
  check_contact_simulation("contact", model, shapes, options);
  ContactMotion motion(model, shapes, q, v, until, options);
  motion.take_steps(step);
  return std::move(motion.run().trajectory);
}

Trajectory simulate_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                            std::span<const double> v, double until, const Tolerances& tolerances,
                            const SimulationOptions& options) {
  check_tolerances(tolerances);
  check_contact_simulation("contact", model, shapes, options);
  ContactMotion motion(model, shapes, q, v, until, options);
  motion.take_steps(tolerances);
  return std::move(motion.run().trajectory);
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
