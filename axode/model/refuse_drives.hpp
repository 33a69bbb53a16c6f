#pragma once
#include <stdexcept>
#include <string>
#include <string_view>

#include "axode/model/model.hpp"

namespace axode {

/// Throws std::invalid_argument if a mechanism has drives with states, which a function does not carry along.
inline void refuse_drives(std::string_view function, const Model& model) {
  if (model.drives().empty()) return;
  throw std::invalid_argument(std::string(function) + " does not carry the states of drives, and model \"" +
                              model.name() + "\" has " + std::to_string(model.drives().size()) +
                              "; use simulate, or remove the drives and give their forces as tau");
}

}  // namespace axode
