#pragma once
#include <span>
#include <vector>

#include "axode/contact/contact_force.hpp"
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/law/contact_system.hpp"

namespace axode {

/// The points of contact of a step and the impulses that act there at its start and at its end, and in all of
/// its parts if it was repeated in parts.
class ContactRecord {
 public:
  /// `capacity` is the number of points for which memory is reserved.
  ContactRecord(ContactShapes shapes, std::size_t capacity) : shapes_(std::move(shapes)) {
    contacts_.reserve(capacity);
  }

  void clear() noexcept;
  /// Sets the points of contact at the end of the step, or of a part of it, to `found`. A point that has
  /// received an impulse and is not in `found` stays where it was.
  void locate(std::span<const Contact> found);
  /// Adds the impulses of `contacts`, which are the first blocks of `problem`, in the same order. `lambda`
  /// are the multipliers of all rows of the problem, see add_impulse(), and u the velocities along its rows
  /// after the impulses. The last impulse of a contact decides whether it counts as sticking or sliding: it
  /// sticks if its sliding velocity is a rounding error compared with velocity_norm, the norm of all
  /// velocities.
  void add(const VelocityProblem& problem, std::span<const Contact> contacts, const double* lambda,
           const double* u, double velocity_norm);
  /// Ends a step of length h (s): the sums of impulses become mean forces, and points without an impulse are
  /// removed unless their gap is below the margin of the shapes.
  void finish(double h);

  /// The points of contact and their mean forces after finish(), in ascending order of their keys.
  std::span<const ContactForce> contacts() const { return contacts_; }

 private:
  ContactForce& at(const Contact& contact);

  ContactShapes shapes_;
  std::vector<ContactForce> contacts_;
};

}  // namespace axode
