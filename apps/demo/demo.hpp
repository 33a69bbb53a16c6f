#pragma once

namespace axode::command {

/// Prints a demonstration of axode with an arm and a humanoid. Throws std::runtime_error if the robots are
/// missing or the representations do not agree.
void show_demo();

}  // namespace axode::command
