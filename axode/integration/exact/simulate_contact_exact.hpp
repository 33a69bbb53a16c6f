#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/integration/simulation.hpp"

namespace axode {

/// Integrates a motion with rigid contacts in smooth phases, each by the adaptive method of simulate() within
/// the tolerances. The events that end a phase are impacts, separation, and the beginning and the end of
/// sliding; their times are found to about 1e-13 s, see Trajectory::contact_events. Contacts, hard stops,
/// loops and, if joint_losses is set, dry friction of joints obey the laws (D11.1), which hold for
/// accelerations in a phase and for velocities in an impact; Trajectory::certificates has the relative errors
/// of the laws. Contact forces are those at the ends of steps, without impacts. The method is meant for few
/// contacts: a step takes O(nv³ + m³) for m scalar constraints that are closed, and every event shortens a
/// step. If several contacts share a load and slide in different directions, the laws leave the motion open;
/// it is that to which surfaces of equal stiffness converge. If the method cannot decide the motion (a face
/// whose points of contact change, too many events), the trajectory ends and says so.
///
/// Throws std::invalid_argument for a wrong size, a quaternion that is not of unit norm, a number that is not
/// finite, until < 0, tolerances that are negative or both 0, absolute coordinates, compliant shapes, and
/// collision shapes that contact cannot use, such as a mesh without a convex hull.
Trajectory simulate_contact_exact(const Model& model, const ContactShapes& shapes, std::span<const double> q,
                                  std::span<const double> v, double until, const Tolerances& tolerances = {},
                                  const SimulationOptions& options = {});
Trajectory simulate_contact_exact(const Model& model, std::span<const double> q, std::span<const double> v,
                                  double until, const Tolerances& tolerances = {},
                                  const SimulationOptions& options = {});

}  // namespace axode
