#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/integration/simulation.hpp"

namespace axode {

/// Simulates a motion with contact with given collision shapes, which may include convex hulls of meshes.
/// Throws std::invalid_argument unless they are the shapes of the model.
Trajectory simulate_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                            std::span<const double> v, double until, double step,
                            const SimulationOptions& options = {});
Trajectory simulate_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                            std::span<const double> v, double until, const Tolerances& tolerances,
                            const SimulationOptions& options = {});

/// The check of motions with contact: throws std::invalid_argument if the shapes are not those of the model,
/// and for prescribed motions and couplings with play.
void check_contact(const Model& model, const ContactShapes& shapes);

}  // namespace axode
