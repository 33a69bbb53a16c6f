#pragma once
#include <span>
#include <string>
#include <vector>

#include "apps/commands/chart.hpp"
#include "apps/files/json_text.hpp"
#include "axode/contact/contact_force.hpp"
#include "axode/integration/trajectory.hpp"

/// Points of contact and their forces as JSON, as a table and as a chart, for all commands.
namespace axode::command {

/// A list with an object for each point. `shapes` has the names of the shapes by their numbers.
Json contacts_json(const std::vector<std::string>& shapes, std::span<const ContactForce> contacts);

/// A table with a row for each point: shapes, place, normal, gap, forces and status.
std::string contacts_table(const std::vector<std::string>& shapes, std::span<const ContactForce> contacts);

/// Panels with the normal forces and friction forces of each pair of shapes that presses in a motion, at
/// given times. Empty if no pair does.
std::vector<Panel> contact_panels(const Trajectory& motion, const std::vector<double>& times);

}  // namespace axode::command
