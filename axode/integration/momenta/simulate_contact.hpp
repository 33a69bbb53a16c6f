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

/// Checks the arguments of rollouts with contact: throws std::invalid_argument if the shapes are not those of
/// the model, and for prescribed motions and couplings with play.
void check_contact(const Model& model, const ContactShapes& shapes);
/// Checks the arguments of a simulation with contact: throws std::invalid_argument if the shapes are not
/// those of the model, for couplings with play, and for coordinates in `options` that are not the default.
/// `method` is the name of the simulation method in messages.
void check_contact_simulation(const char* method, const Model& model, const ContactShapes& shapes,
                              const SimulationOptions& options);

}  // namespace axode
