#pragma once
#include <string>
#include <vector>

#include "axode/fmi/instance.hpp"

namespace axode::fmi {

/// The versions of the FMI standard: 2.0 and 3.0.
enum class Version { fmi2, fmi3 };

/// Makes the text of modelDescription.xml of an FMU of the given kinds. `identifier` is the name of the FMU's
/// binary without the file extension. `token` is the text that the importing program must pass to make an
/// instance.
std::string model_description(const Model& model, const VariableTable& table, Version version,
                              const std::vector<Kind>& kinds, const std::string& identifier,
                              const std::string& token);

}  // namespace axode::fmi
