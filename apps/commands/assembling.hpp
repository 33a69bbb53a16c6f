#pragma once
#include <string>
#include <vector>

#include "apps/files/state.hpp"

namespace CLI {
class App;
}

namespace axode::command {

/// The state in which a motion starts, as the description of the model says, without forces. A joint with a
/// prescribed motion has the first coordinate and velocity of this motion. Throws InputError if the
/// description has other numbers for it.
State starting_state(const Model& model);

/// Options that say whether and how the loops of a state are closed before the state is used.
struct Assembling {
  bool wanted = false;
  std::vector<std::string> hold;  ///< names of joints that do not move when loops are closed
};
/// Adds the options --assemble and --hold to a command.
void add_assembly_options(CLI::App& app, Assembling& assembling);
/// Closes the loops of a state if the option --assemble is given. Throws InputError if they cannot be closed,
/// and UsageError if --hold is given without --assemble or names a coupled joint.
void assemble(const Model& model, const Assembling& assembling, State& state);

}  // namespace axode::command
