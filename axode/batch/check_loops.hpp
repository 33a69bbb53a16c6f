#pragma once
#include <span>

#include "axode/batch/portions.hpp"
#include "axode/model/model.hpp"

namespace axode::batch {

/// Checks that loops are closed at every state. Throws std::invalid_argument if they are not, or if v has
/// another size. Returns false if the monitor, which is called with 0 finished states, has ended the check.
bool check_loops(const Model& model, std::span<const double> q, std::span<const double> v, int threads,
                 const Monitor& monitor);

}  // namespace axode::batch
