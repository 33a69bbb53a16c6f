#pragma once
#include <optional>
#include <string>
#include <vector>

#include "apps/files/state.hpp"

namespace CLI {
class App;
}

namespace axode::command {

/// The initial coordinates and velocities that the model's description gives. Joints with a prescribed motion
/// have the position and velocity with which this motion begins. Throws InputError if the description
/// contradicts a prescribed motion.
State starting_state(const Model& model);

/// Options that say whether and how the loops of a state are closed before the state is used.
struct Assembling {
  bool wanted = false;
  std::vector<std::string> hold;  ///< names of joints that do not move when loops are closed
};
/// Adds the options --assemble and --hold to a command.
void add_assembly_options(CLI::App& app, Assembling& assembling);
/// If --assemble is given, moves the joints of a state until the loops close; joints that --hold names do not
/// move. Throws InputError if the loops cannot be closed, and UsageError if --hold is given without
/// --assemble or names a coupled joint.
void assemble(const Model& model, const Assembling& assembling, State& state);
/// Returns a sentence on a loop that is open at a state, or that its velocities open; nothing if the loops
/// are closed. Throws the sentence as an InputError if warnings are errors.
std::optional<std::string> open_loop(const Model& model, const State& state, bool strict);

}  // namespace axode::command
