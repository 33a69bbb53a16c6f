#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/integration/simulation.hpp"

namespace axode {

/// Simulates a motion with contact. The collision shapes must have been made from `model`, with convex hulls
/// that replace meshes. Throws std::invalid_argument if they were made from a model with another number of
/// moving bodies, for couplings with play, and for the options `coordinates` and `local_coordinates` if they
/// are not the default.
Trajectory simulate_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                            std::span<const double> v, double until, double step,
                            const SimulationOptions& options = {});
Trajectory simulate_contact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                            std::span<const double> v, double until, const Tolerances& tolerances,
                            const SimulationOptions& options = {});

/// Whether a joint has hard stops.
bool has_hard_stops(const Model& model);

/// Checks the arguments of rollouts with contact. Throws std::invalid_argument if the shapes were made from a
/// model with another number of moving bodies, and for couplings with play.
void check_contact(const Model& model, const ContactShapes& shapes);
/// Checks the arguments of a simulation with contact. Throws std::invalid_argument if the shapes were made
/// from a model with another number of moving bodies, for couplings with play, and for the options
/// `coordinates` and `local_coordinates` if they are not the default. `method` is the name of the simulation
/// method in messages.
void check_contact_simulation(const char* method, const Model& model, const ContactShapes& shapes,
                              const SimulationOptions& options);

}  // namespace axode
