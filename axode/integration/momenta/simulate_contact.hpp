#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/integration/simulation.hpp"

namespace axode {

/// Simulates a motion with contact as simulate_contact() of simulation.hpp does, but with given collision
/// shapes, for example convex hulls of meshes: `ContactShapes(model, hull_of_mesh)`. The shapes must be those
/// of the model, otherwise std::invalid_argument is thrown.
Trajectory simulate_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                            std::span<const double> v, double until, double step,
                            const SimulationOptions& options = {});
Trajectory simulate_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                            std::span<const double> v, double until, const Tolerances& tolerances,
                            const SimulationOptions& options = {});

/// Throws std::invalid_argument if the model has something that steps with contact do not support (prescribed
/// motions, drives with states, couplings with play), and if the shapes are not those of the model.
void check_contact(const Model& model, const ContactShapes& shapes);

}  // namespace axode
