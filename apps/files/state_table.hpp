#pragma once
#include <string>
#include <utility>
#include <vector>

#include "axode/model/model.hpp"

namespace axode::command {

/// A column of a table: its heading, and a number for each velocity.
using OfVelocities = std::pair<std::string, std::vector<double>>;

/// A line about the model, then q and the other numbers of a state in one table, or in two tables if
/// coordinates and velocities have different names. `units` are the units of the columns other than q.
std::string state_tables(const Model& model, const std::vector<double>& q,
                         const std::vector<OfVelocities>& of_velocities, const std::string& units);

}  // namespace axode::command
