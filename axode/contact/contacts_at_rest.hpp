#pragma once
#include <optional>
#include <span>
#include <vector>

#include "axode/contact/contact_force.hpp"
#include "axode/contact/contact_shapes.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// The result of contacts_at_rest().
struct ContactsAtRest {
  std::vector<ContactForce> contacts;  ///< contact points, in ascending order of their pairs of shapes
  std::vector<double> a;               ///< accelerations, nv; 0 to rounding if the mechanism stays at rest
  double certificate = 0;              ///< error of the contact laws, see certificate(); 1e-12 is rounding
};

struct AtRestOptions {
  std::optional<double> margin;  ///< gap below which points are returned, m; if empty, that of the shapes
  double touching = 1e-6;        ///< largest gap or distance from a hard stop that counts as closed, m or rad
  bool joint_losses = false;     ///< whether dry friction of joints acts
};

/// Computes the contact points at a configuration q, and the forces that act there when the mechanism is let
/// go at rest: M a = τ - b(q, 0) + Jᵀ f, with the mass matrix M, the forces b of gravity and loads, and the
/// Jacobian J of the contact velocities. The accelerations a and the contact forces f obey Signorini's and
/// Coulomb's laws (D11.1), written for accelerations instead of velocities. The normal force of a compliant
/// contact is that of its stiffness at the gap. Only points with a gap of at most `touching` (m), or with an
/// overlap, can have forces. Hard stops and closed loops act; if joint_losses is set, dry friction of joints
/// acts too. τ are the drive forces (nv, or empty if they are 0), to which the forces of the springs of the
/// mechanism are added.
///
/// If several points carry one load, its distribution over the points is not unique, but the sum of their
/// forces and the sum of their moments are. Throws std::invalid_argument for arguments of a wrong size or
/// with numbers that are not finite, a loop that is open at q by more than 1e-6 rad or m, a load on a frame
/// that does not exist, prescribed motions, drives with states, couplings with play, gears with losses if
/// joint_losses is set, a singular mass matrix, and more contact points than 64 times the number of shapes.
/// Allocates.
ContactsAtRest contacts_at_rest(const Model& model, const ContactShapes& shapes, Numbers<double> q,
                                Numbers<double> tau = {}, const AtRestOptions& options = {},
                                const Loads<>& loads = {});

}  // namespace axode
