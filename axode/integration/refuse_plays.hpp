#pragma once
#include <stdexcept>
#include <string>
#include <string_view>

#include "axode/model/model.hpp"

namespace axode {

/// Throws std::invalid_argument if a mechanism has a coupling with play, which a function does not count.
inline void refuse_plays(std::string_view function, std::string_view instead, const Model& model) {
  if (model.loops().backlashes.empty()) return;
  throw std::invalid_argument(std::string(function) + " does not count the play of coupling \"" +
                              model.loops().backlashes[0].name + "\"; " + std::string(instead));
}

}  // namespace axode
