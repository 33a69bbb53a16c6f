#pragma once
#include <string>
#include <utility>
#include <vector>

#include "axode/model/model.hpp"

namespace axode::command {

/// A column of a table: its heading, and a number for each velocity.
using OfVelocities = std::pair<std::string, std::vector<double>>;

/// The text with a line about the model and a table with q and the columns of_velocities, such as v and a, of
/// a state; two tables if coordinates and velocities have different names. `units` are the units of the
/// columns other than q.
std::string state_tables(const Model& model, const std::vector<double>& q,
                         const std::vector<OfVelocities>& of_velocities, const std::string& units);

}  // namespace axode::command
