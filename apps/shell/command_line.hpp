#pragma once
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// The parts of the command line, from which completion and the manual page are made.
namespace axode::command {

std::vector<const CLI::App*> commands(const CLI::App& app);
/// The arguments of a command that have no dashes.
std::vector<const CLI::Option*> positionals(const CLI::App& command);
/// The names of an option with their dashes; empty for a positional one.
std::vector<std::string> flags(const CLI::Option& option);
bool takes_value(const CLI::Option& option);

}  // namespace axode::command
