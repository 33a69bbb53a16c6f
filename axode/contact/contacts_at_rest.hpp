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
  std::vector<ContactForce> contacts;  ///< in ascending order of their pairs of shapes
  std::vector<double> a;               ///< accelerations, nv; all 0 if the mechanism stays at rest
  double certificate = 0;              ///< how exactly the laws hold, see certificate(); 1e-12 is rounding
};

struct AtRestOptions {
  std::optional<double> margin;  ///< gap below which points are given, m; that of the shapes if it is empty
  double touching = 1e-6;        ///< gap, or room of a stop, up to which bodies touch, m or rad
  bool joint_losses = false;     ///< whether dry friction of joints holds
};

/// The points of contact at a configuration, and the forces that act there at the instant at which the
/// mechanism is at rest and let go: M a = τ - b(q, 0) + Jᵀ f, where a and f obey Signorini's and Coulomb's
/// laws (D11.1) for accelerations. Points with a gap of at most `touching` press, also in overlap; other
/// points, within the margin, are open. Hard stops, dry friction and closed loops take part. τ are the drive
/// forces (nv, or empty for none); springs of the mechanism act besides.
///
/// Where several points carry one load, the share of each is arbitrary, and their sum and moment are not.
/// Throws std::invalid_argument for wrong arguments, prescribed motions, drives with states, couplings with
/// play, more than 64 points for each shape, and a singular mass matrix. Allocates.
ContactsAtRest contacts_at_rest(const Model& model, const ContactShapes& shapes, Numbers<double> q,
                                Numbers<double> tau = {}, const AtRestOptions& options = {},
                                const Loads<>& loads = {});

}  // namespace axode
