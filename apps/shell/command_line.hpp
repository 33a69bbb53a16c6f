#pragma once
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// The structure of the command line, from which shell completion and the manual page are made.
namespace axode::command {

std::vector<const CLI::App*> commands(const CLI::App& app);
/// The positional arguments of a command, which have no dashes.
std::vector<const CLI::Option*> positionals(const CLI::App& command);
/// The names of an option with their dashes; empty for a positional argument.
std::vector<std::string> flags(const CLI::Option& option);
bool takes_value(const CLI::Option& option);

}  // namespace axode::command
