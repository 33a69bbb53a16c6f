#pragma once
#include <string>
#include <utility>
#include <vector>

namespace axode::command {

enum class Compression { stored, deflated };

/// Makes a zip archive from files (name, contents) and returns its bytes, which are the same in every run.
/// Throws std::runtime_error if there is not enough memory.
std::string as_zip(const std::vector<std::pair<std::string, std::string>>& files, Compression compression);

}  // namespace axode::command
