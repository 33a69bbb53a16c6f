#include "apps/files/state_table.hpp"

#include <fmt/format.h>

#include "apps/shell/table.hpp"
#include "apps/shell/terminal.hpp"
#include "axode/model/configuration.hpp"

namespace axode::command {

std::string gravity_text(const Model& model) {
  const Vec3<>& g = model.gravity();
  return fmt::format("({}, {}, {}) m/s^2", significant(g.x), significant(g.y), significant(g.z));
}

std::string state_tables(const Model& model, const std::vector<double>& q,
                         const std::vector<OfVelocities>& of_velocities, const std::string& units) {
  const std::string head = in(Ink::heading, fmt::format("{}: nq = {}, nv = {}, gravity {}", model.name(),
                                                        model.nq(), model.nv(), gravity_text(model)));
  const std::vector<std::string> coordinates = coordinate_names(model), velocities = velocity_names(model);
  const bool one_table = coordinates == velocities;
  std::vector<std::string> headings{one_table ? "joint" : "velocity"};
  if (one_table) headings.emplace_back("q");
  for (const auto& [heading, numbers] : of_velocities) headings.push_back(heading);
  Table table(headings);
  for (std::size_t k = 0; k < velocities.size(); ++k) {
    std::vector<Cell> row{velocities[k]};
    if (one_table) row.emplace_back(q[k]);
    for (const auto& [heading, numbers] : of_velocities) row.emplace_back(numbers[k]);
    table.row(std::move(row));
  }
  if (one_table) return fmt::format("{}\n\nstate; rad or m, and {}\n{}", head, units, table.text());
  Table of_coordinates({"coordinate", "q"});
  for (std::size_t k = 0; k < coordinates.size(); ++k) of_coordinates.row({coordinates[k], q[k]});
  return fmt::format(
      "{}\n\nstate, coordinates; rad or m, rotations as quaternions x y z w\n{}"
      "\nstate, velocities in the joints' own axes; rad or m, {}\n{}",
      head, of_coordinates.text(), units, table.text());
}

}  // namespace axode::command
