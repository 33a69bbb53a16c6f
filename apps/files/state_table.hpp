#pragma once
#include <string>
#include <utility>
#include <vector>

#include "axode/model/model.hpp"

namespace axode::command {

/// A column of a table: its heading, and a number for each velocity.
using OfVelocities = std::pair<std::string, std::vector<double>>;

/// The gravity of a model as text, such as `(0, 0, -9.81) m/s^2`.
std::string gravity_text(const Model& model);

/// A state as text: a line about the model, then a table with a column for q and a column for each quantity
/// in `of_velocities`, such as v and a, which has nv numbers. If coordinates and velocities have different
/// names, q has a table of its own. `units` are the units of the quantities in `of_velocities`.
std::string state_tables(const Model& model, const std::vector<double>& q,
                         const std::vector<OfVelocities>& of_velocities, const std::string& units);

}  // namespace axode::command
