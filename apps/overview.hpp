#pragma once
#include <string>

namespace axode::command {

/// What one can do with the command, by task: an example and a few words each.
std::string overview();

}  // namespace axode::command
