#pragma once
#include <string>

namespace axode::command {

/// An overview of the tasks of `axode`, each with an example and a few words.
std::string overview();

}  // namespace axode::command
