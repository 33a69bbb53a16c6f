#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/integration/simulation.hpp"

namespace axode {

/// simulate_contact() with given collision shapes, for example with hulls of meshes:
/// `ContactShapes(model, hull_of_mesh)`. They must be those of the model.
Trajectory simulate_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                            std::span<const double> v, double until, double step,
                            const SimulationOptions& options = {});
Trajectory simulate_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                            std::span<const double> v, double until, const Tolerances& tolerances,
                            const SimulationOptions& options = {});

/// Checks that steps with contact count everything that a mechanism has, and that the shapes are those of the
/// model. Throws std::invalid_argument if not.
void check_contact(const Model& model, const ContactShapes& shapes);

}  // namespace axode
