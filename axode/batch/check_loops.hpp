#pragma once
#include <span>

#include "axode/batch/portions.hpp"
#include "axode/model/model.hpp"

namespace axode::batch {

/// Checks that the loops of the model are closed at every state (q, v). Throws std::invalid_argument if they
/// are not, or if v does not have nv numbers for each state. The monitor, the caller's function that can end
/// a long call, is called with 0 finished states; if it ends the check, the result is false.
bool check_loops(const Model& model, std::span<const double> q, std::span<const double> v, int threads,
                 const Monitor& monitor);

}  // namespace axode::batch
