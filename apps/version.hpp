#pragma once
#include <string>

namespace axode::command {

/// The version in a line, then how this program was built and what it runs on.
std::string version();

}  // namespace axode::command
