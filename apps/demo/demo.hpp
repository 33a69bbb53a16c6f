#pragma once

namespace axode::command {

/// Prints a demonstration of axode with an arm and a humanoid. Throws std::runtime_error if the files of
/// these robots are missing or if the results in the four representations do not agree.
void show_demo();

}  // namespace axode::command
