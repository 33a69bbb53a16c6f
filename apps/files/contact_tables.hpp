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

/// A JSON list of contact points. `shapes` has the names to which the indices ContactForce::a and b refer.
Json contacts_json(const std::vector<std::string>& shapes, std::span<const ContactForce> contacts);

/// A table of contact points: names of the shapes, position, normal, gap, forces, and whether they slide.
std::string contacts_table(const std::vector<std::string>& shapes, std::span<const ContactForce> contacts);

/// Two panels of a chart, one for the normal forces and one for the friction forces in contacts at the given
/// times. Each has a curve for each pair of shapes that press on each other. Empty if there is no contact.
std::vector<Panel> contact_panels(const Trajectory& motion, const std::vector<double>& times);

}  // namespace axode::command
