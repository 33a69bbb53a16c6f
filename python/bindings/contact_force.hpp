#pragma once
#include <span>
#include <string>
#include <vector>

#include "axode/integration/trajectory.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/text.hpp"

namespace axode::python {

/// A list of axode.ContactForce. `shapes` has the names to which the indices ContactForce::a and b refer.
inline nb::list contact_list(const std::vector<std::string>& shapes, std::span<const ContactForce> contacts) {
  nb::list all;
  for (const ContactForce& x : contacts)
    all.append(record("ContactForce", to_str(shapes[static_cast<std::size_t>(x.a)]),
                      to_str(shapes[static_cast<std::size_t>(x.b)]), to_array(x.point), to_array(x.normal),
                      x.gap, to_array(x.force), to_array(x.moment), x.friction,
                      to_str(std::string(to_string(x.branch)))));
  return all;
}

}  // namespace axode::python
