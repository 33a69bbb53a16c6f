#pragma once
#include <span>

#include "axode/batch/portions.hpp"
#include "axode/model/model.hpp"

namespace axode::batch {

/// Checks that the loops of the model are closed at every state (q, v). Throws std::invalid_argument if one
/// is open, or if v has a wrong size. Returns false if the monitor, the caller's function that can end a long
/// call, ended the check.
bool check_loops(const Model& model, std::span<const double> q, std::span<const double> v, int threads,
                 const Monitor& monitor);

}  // namespace axode::batch
