#pragma once
#include <string>
#include <utility>
#include <vector>

#include "axode/model/model.hpp"

namespace axode::command {

/// A column of a table: its heading, and a number for each velocity.
using OfVelocities = std::pair<std::string, std::vector<double>>;

/// A state as text: a line about the model, and a table of q and of quantities with nv numbers
/// (`of_velocities`, such as v and a), or two tables if coordinates and velocities have different names.
/// `units` are those of the columns other than q.
std::string state_tables(const Model& model, const std::vector<double>& q,
                         const std::vector<OfVelocities>& of_velocities, const std::string& units);

}  // namespace axode::command
