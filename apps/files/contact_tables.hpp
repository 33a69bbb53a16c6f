#pragma once
#include <span>
#include <string>
#include <vector>

#include "apps/commands/chart.hpp"
#include "apps/files/json_text.hpp"
#include "axode/contact/contact_force.hpp"
#include "axode/integration/trajectory.hpp"

/// Writes points of contact and their forces as JSON, as a table and as a chart, for all commands.
namespace axode::command {

/// A JSON list with an object for each point of contact. `shapes` has the names of the shapes;
/// ContactForce::a and b are indices into it.
Json contacts_json(const std::vector<std::string>& shapes, std::span<const ContactForce> contacts);

/// A table with a row for each point of contact: names of the shapes, position, normal, gap, forces and
/// status.
std::string contacts_table(const std::vector<std::string>& shapes, std::span<const ContactForce> contacts);

/// Two panels of a chart with the normal forces and the friction forces over the given times, with a curve
/// for each pair of shapes that presses on each other. Empty if no pair does so at these times.
std::vector<Panel> contact_panels(const Trajectory& motion, const std::vector<double>& times);

}  // namespace axode::command
