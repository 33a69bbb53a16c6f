#pragma once
#include <string>

#include "axode/view/shown_motion.hpp"

namespace axode::command {

/// Reads a motion of a model from a .csv, .json or .npz file that `axode simulate --output` has written: the
/// times t, the numbers q, v, a and tau at each time, loads and contacts. a, tau, loads and contacts may be
/// missing, and other columns are ignored. Throws InputError if the file does not fit the model.
ShownMotion read_motion(const Model& model, const std::string& file);

}  // namespace axode::command
