#include "axode/integration/momenta/simulate_contact.hpp"

#include <stdexcept>

#include "axode/integration/momenta/contact_step.hpp"
#include "axode/integration/schemes/explicit_steps.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {
namespace {

constexpr const char* instead = "simulate without contact, or drive the joints by tau";

}  // namespace

void check_contact(const Model& model, const ContactShapes& shapes) {
  check_shapes(model, shapes);
  catalog::check_counts<"contact">(model);
}

Trajectory simulate_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                            std::span<const double> v, double until, double step,
                            const SimulationOptions& options) {
  check_step(step);
  check_contact(model, shapes);
  if (options.coordinates != Coordinates::relative)
    throw std::invalid_argument("contact needs relative coordinates, and these are absolute");
  if (!options.motions.empty())
    throw std::invalid_argument("contact does not count the prescribed motion of \"" +
                                options.motions.front().of + "\"; " + instead);
  if (!options.x.empty())
    throw std::invalid_argument("x is given, and contact does not count drives with states");
  if (!options.drives.empty())
    throw std::invalid_argument("contact does not count drive \"" + options.drives.front().name + "\"; " +
                                instead);
  if (options.local_coordinates != LocalCoordinates::exponential)
    throw std::invalid_argument("contact steps in exponential local coordinates, and these are Cayley's");
  SimulationOptions free = options;  // losses of joints belong to the step with contact
  free.joint_losses = false;
  ContactSimulationRun run(model, q, v, until, free, options.joint_losses);
  for (int i = 0; i < shapes.size(); ++i) run.trajectory.contact_shapes.push_back(shapes[i].name);
  if (run.done()) return std::move(run.trajectory);
  ContactStep scheme(run, model, shapes, options.joint_losses);
  each_step(run, until, step, [&](double t_1) {
    const double h = t_1 - run.now();
    const Eigen::VectorXd v_0 = run.v;
    if (Failure failure = scheme.run(run.now(), h, run.q, run.v)) return failure;
    run.trajectory.certificates.push_back(scheme.certificate);
    Eigen::VectorXd a;  // that of the free motion if it is empty
    if (scheme.touched || !model.loops().empty()) a = (scheme.v - v_0) / h;
    if (Failure failure = run.take_contact(t_1, scheme.q, scheme.v, a)) return failure;
    run.trajectory.set_contacts(scheme.forces());
    return Failure{};
  });
  return std::move(run.trajectory);
}

Trajectory simulate_contact(const Model& model, std::span<const double> q, std::span<const double> v,
                            double until, double step, const SimulationOptions& options) {
  return simulate_contact(model, ContactShapes(model), q, v, until, step, options);
}

}  // namespace axode
