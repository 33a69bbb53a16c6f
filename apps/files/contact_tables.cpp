#include "apps/files/contact_tables.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "apps/shell/table.hpp"

namespace axode::command {
namespace {

const std::string& name(const std::vector<std::string>& shapes, int k) {
  return shapes[static_cast<std::size_t>(k)];
}

/// The number, or 0 if it is so small that it is a rounding error.
double rounded(double x) {
  constexpr double rounding = 1e-12;
  return std::abs(x) < rounding ? 0 : x;
}

}  // namespace

Json contacts_json(const std::vector<std::string>& shapes, std::span<const ContactForce> contacts) {
  Json list = Json::array();
  for (const ContactForce& contact : contacts)
    list.push_back({{"a", name(shapes, contact.a)},
                    {"b", name(shapes, contact.b)},
                    {"point", to_json(contact.point)},
                    {"normal", to_json(contact.normal)},
                    {"gap", contact.gap},
                    {"force", to_json(contact.force)},
                    {"moment", to_json(contact.moment)},
                    {"friction", contact.friction},
                    {"status", to_string(contact.branch)}});
  return list;
}

std::string contacts_table(const std::vector<std::string>& shapes, std::span<const ContactForce> contacts) {
  Table table({"a", "b", "x", "y", "z", "n x", "n y", "n z", "gap", "normal", "friction", "status"});
  for (const ContactForce& contact : contacts) {
    const auto& [a, b] = std::pair(name(shapes, contact.a), name(shapes, contact.b));
    const Vec3<>&x = contact.point, &n = contact.normal;
    table.row({a, b, rounded(x.x), rounded(x.y), rounded(x.z), rounded(n.x), rounded(n.y), rounded(n.z),
               significant(rounded(contact.gap), 3), rounded(contact.normal_force()),
               rounded(norm(contact.friction_force())), std::string(to_string(contact.branch))});
  }
  return table.text();
}

std::vector<Panel> contact_panels(const Trajectory& motion, const std::vector<double>& times) {
  struct Curves {
    std::vector<double> normal, friction;
  };
  std::map<std::pair<int, int>, Curves> pairs;
  for (std::size_t k = 0; k < times.size(); ++k) {
    std::map<std::pair<int, int>, std::pair<double, Vec3<>>> now;
    for (const ContactForce& contact : motion.contacts_at(times[k])) {
      if (contact.branch == LawBranch::open) continue;
      auto& [normal, friction] = now[{contact.a, contact.b}];
      normal += contact.normal_force();
      friction += contact.friction_force();
    }
    for (const auto& [pair, forces] : now) {
      Curves& curves = pairs[pair];
      curves.normal.resize(times.size());
      curves.friction.resize(times.size());
      curves.normal[k] = forces.first;
      curves.friction[k] = norm(forces.second);
    }
  }
  if (pairs.empty()) return {};
  Panel normal{.y_axis = "normal force, N", .name = "normal force"},
      friction{.y_axis = "friction force, N", .name = "friction force"};
  for (const auto& [pair, curves] : pairs) {
    const std::string a = name(motion.contact_shapes, pair.first);
    const std::string b = name(motion.contact_shapes, pair.second);
    const std::string both = a + " and " + b;
    normal.curves.push_back({.name = both, .x = times, .y = curves.normal, .of = {a, b}});
    friction.curves.push_back({.name = both, .x = times, .y = curves.friction, .of = {a, b}});
  }
  return {normal, friction};
}

}  // namespace axode::command
