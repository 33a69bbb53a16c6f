#pragma once

namespace axode::command {

/// Shows on standard output what axode does, on an arm and a humanoid. Throws std::runtime_error where there
/// are no robots, and where the representations do not agree.
void show_demo();

}  // namespace axode::command
