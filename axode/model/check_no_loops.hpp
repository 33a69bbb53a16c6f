#pragma once
#include <stdexcept>
#include <string>
#include <string_view>

#include "axode/model/model.hpp"

namespace axode {

/// Throws std::invalid_argument where a model has loops, which a function that says how mechanisms move does not count; which others do.
inline void check_no_loops(const Model& model, const std::string& function,
                           std::string_view others = "forward_dynamics, inverse_dynamics and simulate do") {
  if (!model.loops().empty())
    throw std::invalid_argument(function + " does not count loops, and model \"" + model.name() + "\" has " +
                                std::to_string(model.loops().all.size()) + "; " + std::string(others));
}

}  // namespace axode
