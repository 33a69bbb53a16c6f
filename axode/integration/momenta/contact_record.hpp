#pragma once
#include <span>
#include <vector>

#include "axode/contact/contact_force.hpp"
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/law/contact_system.hpp"

namespace axode {

/// The points of contact of a step and the impulses that act there, at its start, at its end and in its
/// parts.
class ContactRecord {
 public:
  /// `capacity` is the number of points for which memory is reserved.
  ContactRecord(ContactShapes shapes, std::size_t capacity) : shapes_(std::move(shapes)) {
    contacts_.reserve(capacity);
  }

  void clear() noexcept;
  /// Sets the points at the end of the step, or of a part of it. A point that has received an impulse and is
  /// not among them stays where it was.
  void locate(std::span<const Contact> found);
  /// Adds the impulses of contacts, which have the first blocks of a problem, see add_impulse(). The status
  /// of a contact is that of the last impulses, by the velocities u of the rows beside the norm of all
  /// velocities.
  void add(const VelocityProblem& problem, std::span<const Contact> contacts, const double* lambda,
           const double* u, double velocity_norm);
  /// Ends a step of length h: impulses become mean forces, and points without an impulse remain if their gap
  /// is below the margin of the shapes.
  void finish(double h);

  /// After finish(): the points, in ascending order of their keys.
  std::span<const ContactForce> contacts() const { return contacts_; }

 private:
  ContactForce& at(const Contact& contact);

  ContactShapes shapes_;
  std::vector<ContactForce> contacts_;
};

}  // namespace axode
