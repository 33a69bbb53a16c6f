#pragma once
#include <string>

#include "axode/view/shown_motion.hpp"

namespace axode::command {

/// Reads the motion of a model from a .csv, .json or .npz that `axode simulate --output` has written: t, q,
/// v, a and tau. a and tau may be missing, and other columns are ignored. Throws InputError with all that
/// does not fit the model.
ShownMotion read_motion(const Model& model, const std::string& file);

}  // namespace axode::command
