#pragma once
#include <string>

#include "axode/model/model.hpp"

namespace axode::command {

/// The tree with a line for each body: body <- joint, kind, indices of its coordinates and velocities.
std::string draw_tree(const Model& model);

/// The tree with a line for each unbranched run of bodies.
std::string draw_limbs(const Model& model);

/// `q[3]`, or `q[3:7]` (without 7), or an empty text if count is 0.
std::string slice(char symbol, int first, int count);

/// `= -0.5 q(knee) + 0.1`, for a coupled joint.
std::string coupling(const Model& model, const Joint& joint);

}  // namespace axode::command
