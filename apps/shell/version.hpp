#pragma once
#include <string>

namespace axode::command {

/// The text that --version prints: a line with the version, then details of the build and the processor.
std::string version();

}  // namespace axode::command
