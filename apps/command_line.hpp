#pragma once
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// What the command line consists of, for those who describe it: completion and the manual page.
namespace axode::command {

std::vector<const CLI::App*> commands(const CLI::App& app);
/// The arguments of a command that have no dashes.
std::vector<const CLI::Option*> positionals(const CLI::App& command);
/// The names of an option with their dashes; none of a positional one.
std::vector<std::string> flags(const CLI::Option& option);
bool takes_value(const CLI::Option& option);

}  // namespace axode::command
