#pragma once
#include <span>
#include <vector>

#include "axode/contact/contact_force.hpp"
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/law/contact_system.hpp"

namespace axode {

/// The points of contact of a step and their impulses, summed over its start, its end and all of its parts.
class ContactRecord {
 public:
  /// `capacity` is the number of points for which memory is reserved.
  ContactRecord(ContactShapes shapes, std::size_t capacity) : shapes_(std::move(shapes)) {
    contacts_.reserve(capacity);
  }

  void clear() noexcept;
  /// Updates the list of the points of contact of this step with those in `found`, at the end of the step or
  /// of a part of it. A point in `found` is added to the list or, if the list has it, receives the new
  /// position, normal and gap. A point of the list that is not in `found` is removed if it has not received
  /// an impulse in the step; otherwise it stays as it is.
  void locate(std::span<const Contact> found);
  /// Adds the impulses of `contacts`, whose constraints come first in `problem`. lambda are the multipliers
  /// of all constraints, and u the velocities along them after the impulses. A contact counts as sticking if
  /// its sliding velocity after the impulse is a rounding error of velocity_norm, the norm of all velocities.
  void add(const VelocityProblem& problem, std::span<const Contact> contacts, const double* lambda,
           const double* u, double velocity_norm);
  /// Ends a step of length h (s). Impulses are converted to mean forces, and points that received no impulse
  /// are removed if their gap is above the limit (the margin of the shapes) up to which contacts are
  /// considered.
  void finish(double h);

  /// The points of contact and their mean forces after finish(), in ascending order of their keys.
  std::span<const ContactForce> contacts() const { return contacts_; }

 private:
  ContactForce& at(const Contact& contact);

  ContactShapes shapes_;
  std::vector<ContactForce> contacts_;
};

}  // namespace axode
