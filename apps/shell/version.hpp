#pragma once
#include <string>

namespace axode::command {

/// The text that --version prints: a line with the version, then details of the build and the processor.
std::string version();
/// The date of the build, YYYY-MM-DD.
const char* build_date();

}  // namespace axode::command
