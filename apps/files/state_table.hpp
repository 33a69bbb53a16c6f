#pragma once
#include <string>
#include <utility>
#include <vector>

#include "axode/model/model.hpp"

namespace axode::command {

/// A heading and a number for each velocity.
using OfVelocities = std::pair<std::string, std::vector<double>>;

/// A line about the model, then q and the other numbers of a state. They are in one table, or in two if the
/// numbers of coordinates and velocities differ. `units` are the units of the columns other than q.
std::string state_tables(const Model& model, const std::vector<double>& q,
                         const std::vector<OfVelocities>& of_velocities, const std::string& units);

}  // namespace axode::command
