#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "apps/commands/overview.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/terminal.hpp"
#include "apps/shell/version.hpp"
#include "axode/model/building/fault.hpp"
#include "axode/model/building/nearest_name.hpp"

namespace axode::command {
namespace {

constexpr const char* footer = R"(Examples:
  axode demo
  axode info arm7.toml
  axode eval arm7.toml --want inverse_dynamics,poses

Exit codes:
  0  all is well
  1  a file is missing, malformed or describes something impossible
  2  the command line is wrong

Errors go to standard error, one sentence each. Colours are for terminals; NO_COLOR turns them off.
`axode COMMAND --help` says more about a command.)";

/// The command that the command line names, or the program itself if it names none.
const CLI::App& chosen(const CLI::App& app) {
  const auto commands = app.get_subcommands();
  return commands.empty() ? app : *commands.front();
}

std::string full_name(const CLI::App& app) {
  const CLI::App& command = chosen(app);
  return &command == &app ? app.get_name() : app.get_name() + " " + command.get_name();
}

/// The message of an error about the value of an option. CLI11 says only "Could not convert: --until = abc".
std::string refused_value(const CLI::ParseError& error) {
  const std::string what = error.what(), between = " = ";
  const std::size_t name = what.find("--"), value = what.find(between);
  if (error.get_name() != "ConversionError" || name == std::string::npos || value < name) return what;
  const std::string word = what.substr(value + between.size());
  double number = 0;
  const bool is_number = CLI::detail::lexical_cast(word, number);
  return fmt::format("{}: \"{}\" is {}", what.substr(name, value - name), word,
                     is_number ? "not a whole number in digits, at most 2147483647" : "not a number");
}

/// A sentence that explains the error in the command line.
std::string complaint(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = chosen(app);
  const std::vector<std::string> extras = app.remaining(true);
  const bool is_option = !extras.empty() && extras.front().starts_with('-');
  if (&command == &app && !is_option) {
    std::string list;
    std::vector<std::string> names;
    for (const CLI::App* sub : app.get_subcommands({})) names.push_back(sub->get_name());
    for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
    const auto same = [](const std::string& name) { return name; };
    if (extras.empty()) return "a command is missing; there are " + list;
    return "there is no command \"" + extras.front() + "\"; there are " + list +
           did_you_mean(extras.front(), names, same);
  }
  if (extras.empty()) return refused_value(error);
  const auto long_name = [](const CLI::Option* option) {
    return option->get_lnames().empty() ? "" : "--" + option->get_lnames().front();
  };
  return "\"" + extras.front() + "\" was not expected" +
         did_you_mean(extras.front(), command.get_options(), long_name);
}

/// Throws UsageError if a word of the command line is empty ("").
void refuse_empty_words(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options())
    for (const std::string& word : option->results())
      if (word.empty()) throw UsageError(option->get_name() + " is empty");
}

void report(const std::string& where, const std::string& sentence) {
  fmt::print(stderr, "{}: {}\n", in(Ink::bad, where, stderr), sentence);
}

int run(int argc, char** argv) {
  CLI::App app("Dynamics of multibody systems, trees and closed loops, in the language of screws", "axode");
  app.set_version_flag("--version", version, "Print the version and how it was built");
  app.footer(footer);
  app.require_subcommand(1);
  int exit_code = all_well;
  add_info(app, exit_code);
  add_check(app, exit_code);
  add_convert(app, exit_code);
  add_eval(app, exit_code);
  add_linearize(app, exit_code);
  add_mobility(app, exit_code);
  add_simulate(app, exit_code);
  add_contacts(app, exit_code);
  add_plot(app, exit_code);
  add_view(app, exit_code);
  add_map(app);
  add_codegen(app, exit_code);
  add_fmu(app, exit_code);
  add_study(app, argv, exit_code);
  add_demo(app, exit_code);
  for (CLI::App* command : app.get_subcommands({}))
    command->parse_complete_callback([command] { refuse_empty_words(*command); });
  add_completion(app, exit_code);
  add_manual(app, exit_code);
  try {
    if (argc == 1) {
      fmt::print("{}", overview());
      return all_well;
    }
    app.parse(argc, argv);
    return exit_code;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help and --version end in this way
    report(full_name(app), complaint(app, error) + fmt::format(" (see {} --help)", full_name(app)));
    return wrong_usage;
  } catch (const UsageError& error) {
    report(full_name(app), error.what() + fmt::format(" (see {} --help)", full_name(app)));
    return wrong_usage;
  } catch (const InputError& error) {
    for (const std::string& sentence : error.sentences()) report(full_name(app), sentence);
  } catch (const ModelError& error) {
    for (const Fault& fault : error.faults())
      if (fault.severity == Severity::error)
        fmt::print(stderr, "{}\n", in(Ink::bad, to_string(fault), stderr));
  } catch (const std::bad_alloc&) {
    report(full_name(app), "there is not enough memory; ask for fewer steps, samples or states");
  } catch (const std::exception& error) {
    report(full_name(app), error.what());
  }
  return bad_input;
}

}  // namespace
}  // namespace axode::command

int main(int argc, char** argv) {
  const int exit_code = axode::command::run(argc, argv);
  const bool written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (written || exit_code != axode::command::all_well) return exit_code;
  std::fputs("axode: standard output cannot be written\n", stderr);
  return axode::command::bad_input;
}
