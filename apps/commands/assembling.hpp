#pragma once
#include <string>
#include <vector>

#include "apps/files/state.hpp"

namespace CLI {
class App;
}

namespace axode::command {

/// The state in which a motion starts, as the description says, without forces. Joints that follow a motion
/// have its first coordinate and velocity. Throws InputError if the description says others.
State starting_state(const Model& model);

/// Options that decide whether and how the loops of a state are closed before it is used.
struct Assembling {
  bool wanted = false;
  std::vector<std::string> hold;  ///< names of joints that stay where they are
};
/// The options --assemble and --hold.
void add_assembly_options(CLI::App& app, Assembling& assembling);
/// Closes the loops of a state if --assemble is given. Throws InputError if they cannot be closed, UsageError
/// for --hold without --assemble and for joints that follow others.
void assemble(const Model& model, const Assembling& assembling, State& state);

}  // namespace axode::command
