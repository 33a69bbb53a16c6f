#include "axode/integration/exact/simulate_contact_exact.hpp"

#include <stdexcept>
#include <utility>

#include "axode/eigen.hpp"
#include "axode/integration/exact/exact_contact_run.hpp"
#include "axode/integration/methods.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "axode/integration/schemes/explicit_steps.hpp"
#include "axode/kinematics/check_arguments.hpp"

namespace axode {
namespace {

void check_exact(const Model& model, const ContactShapes& shapes, const SimulationOptions& options) {
  check_contact_simulation("contact_exact", model, shapes, options);
  if (options.joint_losses) refuse_gears(model);
  for (const auto& [a, b] : shapes.pairs())
    if (shapes.surface(a, b).compliance)
      throw std::invalid_argument("contact_exact has rigid contacts; shapes \"" + shapes[a].name +
                                  "\" and \"" + shapes[b].name + "\" are compliant; use the method contact");
}

}  // namespace

Trajectory simulate_contact_exact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                                  std::span<const double> v, double until, const Tolerances& tolerances,
                                  const SimulationOptions& options) {
  check_tolerances(tolerances);
  check_exact(model, shapes, options);
  SimulationOptions smooth = options;
  smooth.joint_losses = false;
  ExactContactRun run(model, shapes, q, v, until, smooth, options.joint_losses, tolerances);
  take_adapted_steps(run, until, tolerances);
  return std::move(run.trajectory);
}

Trajectory simulate_contact_exact(const Model& model, std::span<const double> q, std::span<const double> v,
                                  double until, const Tolerances& tolerances,
                                  const SimulationOptions& options) {
  return simulate_contact_exact(model, ContactShapes(model), q, v, until, tolerances, options);
}

}  // namespace axode
