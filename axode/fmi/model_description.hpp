#pragma once
#include <string>
#include <vector>

#include "axode/fmi/instance.hpp"

namespace axode::fmi {

/// The versions of the standard.
enum class Version { fmi2, fmi3 };

/// The file modelDescription.xml of an FMU with these kinds. `identifier` is the name of its binary without
/// the ending, and `token` what the master has to show to the binary.
std::string model_description(const Model& model, const VariableTable& table, Version version,
                              const std::vector<Kind>& kinds, const std::string& identifier,
                              const std::string& token);

}  // namespace axode::fmi
