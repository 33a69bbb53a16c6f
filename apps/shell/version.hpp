#pragma once
#include <string>

namespace axode::command {

/// A line with the version, then details of the build and the processor.
std::string version();

}  // namespace axode::command
