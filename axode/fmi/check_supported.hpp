#pragma once
#include "axode/fmi/variables.hpp"

namespace axode::fmi {

/// The kinds of FMUs: the importing program integrates (model exchange), or the FMU (co-simulation).
enum class Kind { model_exchange, co_simulation };

/// Throws std::invalid_argument if the mechanism has a property that FMUs of the given kind do not support,
/// such as contact of meshes or, in model exchange, all contact.
void check_supported(const Model& model, const Settings& settings, Kind kind);

}  // namespace axode::fmi
