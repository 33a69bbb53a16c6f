#pragma once
#include <string>

#include "axode/model/model.hpp"

namespace axode::command {

/// The tree as text, a line for each body: body <- joint, kind, indices of coordinates and velocities.
std::string draw_tree(const Model& model);

/// Draws the tree of a model as text with a line for each chain of bodies without branches.
std::string draw_limbs(const Model& model);

/// The `count` indices from `first` on as text, `q[3]` or `q[3:7]` for 3 to 6; empty if count is 0.
std::string slice(char symbol, int first, int count);

/// The coupling of a joint as text: `= -0.5 q(knee) + 0.1`.
std::string coupling(const Model& model, const Joint& joint);

}  // namespace axode::command
