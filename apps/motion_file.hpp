#pragma once
#include <string>

#include "axode/view/shown_motion.hpp"

namespace axode::command {

/// The motion of a model in a .csv, .json or .npz that `axode simulate --output` has written; what it has
/// besides t, q, v, a and tau is passed over, and the latter two may be missing. Throws InputError that says
/// what does not fit the model.
ShownMotion read_motion(const Model& model, const std::string& file);

}  // namespace axode::command
