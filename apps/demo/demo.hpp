#pragma once

namespace axode::command {

/// Prints a demonstration of axode with an arm and a humanoid. Throws std::runtime_error if their files are
/// missing or if the results in different representations of twists do not agree.
void show_demo();

}  // namespace axode::command
