#pragma once
#include <span>

#include "axode/batch/portions.hpp"
#include "axode/model/model.hpp"

namespace axode::batch {

/// Checks that every state (q, v) closes the loops of the model: that the loops are closed at q, and that the
/// velocities v keep them closed. Prescribed motions, if the caller counts them, must be followed at time 0.
/// Throws std::invalid_argument if v has a wrong size, and with the index of the state if a loop is open at q
/// or opened by v, or a motion is not followed. Returns false if the monitor, the caller's function that
/// can end a long call, ended the check.
bool check_loops(const Model& model, std::span<const double> q, std::span<const double> v, int threads,
                 const Monitor& monitor);

}  // namespace axode::batch
