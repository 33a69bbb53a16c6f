#include "axode/integration/momenta/contact_record.hpp"

#include <algorithm>

#include "axode/contact/contact_point.hpp"

namespace axode {

void ContactRecord::clear() noexcept { contacts_.clear(); }

/// Finds the entry for a contact in a list sorted by keys, or inserts one with its point, normal and gap.
ContactForce& ContactRecord::at(const Contact& contact) {
  const auto place = std::ranges::lower_bound(contacts_, contact.key, {}, &ContactForce::key);
  if (place != contacts_.end() && place->key == contact.key) return *place;
  const auto [a, b] = shapes_of_key(contact.key);
  return *contacts_.insert(place, {.a = a,
                                   .b = b,
                                   .body_a = contact.a,
                                   .body_b = contact.b,
                                   .point = contact.point,
                                   .normal = contact.normal,
                                   .gap = contact.gap,
                                   .friction = contact.surface.friction,
                                   .key = contact.key});
}

void ContactRecord::locate(std::span<const Contact> found) {
  std::erase_if(contacts_, [](const ContactForce& contact) { return contact.branch == LawBranch::open; });
  for (const Contact& contact : found) {
    ContactForce& here = at(contact);
    here.point = contact.point;
    here.normal = contact.normal;
    here.gap = contact.gap;
  }
}

void ContactRecord::add(const VelocityProblem& problem, std::span<const Contact> contacts,
                        const double* lambda, const double* u, double velocity_norm) {
  const double at_rest = 1e-8 * std::max(1e-3, velocity_norm);
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const LawBranch branch = branch_after(problem, k, lambda, u, at_rest);
    if (branch == LawBranch::open) continue;
    ContactForce& here = at(contacts[k]);
    here.branch = branch;
    add_impulse(problem, k, lambda, contacts[k].normal, here);
  }
}

void ContactRecord::finish(double h) {
  std::erase_if(contacts_, [&](const ContactForce& contact) {
    return contact.branch == LawBranch::open && !(contact.gap < shapes_.margin());
  });
  for (ContactForce& contact : contacts_) {
    contact.force = (1 / h) * contact.force;
    contact.moment = (1 / h) * contact.moment;
  }
}

}  // namespace axode
