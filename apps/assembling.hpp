#pragma once
#include <string>
#include <vector>

#include "state.hpp"

namespace CLI {
class App;
}

namespace axode::command {

/// Whether, and how, the loops of a state are closed before it is used.
struct Assembling {
  bool wanted = false;
  std::vector<std::string> hold;  ///< names of joints that stay where they are
};
/// The options --assemble and --hold.
void add_assembly_options(CLI::App& app, Assembling& assembling);
/// Closes the loops of a state where that is wanted. Throws InputError where they do not close, UsageError
/// for --hold without --assemble and for joints that follow others.
void assemble(const Model& model, const Assembling& assembling, State& state);

}  // namespace axode::command
