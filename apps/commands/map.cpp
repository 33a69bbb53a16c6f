#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "apps/shell/command_line.hpp"
#include "apps/shell/commands.hpp"

/// Options and help of the command `map`, which computes functions of states in Parquet files with Python.
namespace axode::command {
namespace {

constexpr const char* map_footer = R"(Example:
  axode map inverse_dynamics humanoid.urdf states.parquet tau.parquet --base free
  axode map jacobian arm7.toml states/ jacobians/ --set frame=flange --set representation=hybrid

FUNCTION is a function of the Python package that takes N states. STATES has the columns q, v, a and tau
with lists of numbers, or "q A1", "q A2", ... as in the run.csv of `axode simulate`. OUTPUT has a row for
each state, in the same order; the result of inverse_dynamics is named tau, that of forward_dynamics a,
and every other one like its function. An interrupted job continues where it stopped. See
docs/distributed.md.

This command runs `python -m axode map`, which needs pyarrow: pip install pyarrow. It uses the program in
AXODE_PYTHON, or else the first python3 on PATH, which is the one of an active virtual environment; the
command that pip installs uses the Python of its own environment.)";

/// The Python program that the command runs, with the working folder removed from the search path of modules.
constexpr const char* program = R"(
import sys
sys.path[:] = [place for place in sys.path if place]
try:
    from axode.__main__ import main
except ModuleNotFoundError as error:
    sys.exit(f"axode map: {sys.executable} has no package {error.name}; install the Python package of axode there, activate "
             "the environment that has it, or name its python in AXODE_PYTHON")
sys.exit(main())
)";

/// The words of the command line of `map` as they were given, in the order of the options.
std::vector<std::string> words_given(const CLI::App& map) {
  std::vector<std::string> words{"map"};
  for (const CLI::Option* option : map.get_options())
    if (option->count() > 0 && !option->get_positional()) {
      const std::string name = "--" + option->get_lnames().front();
      if (!takes_value(*option)) words.push_back(name);
      if (takes_value(*option))
        for (const std::string& value : option->results()) words.push_back(name + "=" + value);
    }
  words.emplace_back("--");
  for (const CLI::Option* option : positionals(map)) words.push_back(option->results().front());
  return words;
}

/// Replaces this process by Python, which runs the program with these words.
[[noreturn]] void hand_over(std::vector<std::string> words) {
  const char* const named = std::getenv("AXODE_PYTHON");
  std::string python = named != nullptr && *named != '\0' ? named : "python3";
  words.insert(words.begin(), {python, "-c", program});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execvp(python.c_str(), arguments.data());
  throw InputError(
      fmt::format("{} cannot be run: {}; `axode map` needs Python; set AXODE_PYTHON to its program", python,
                  std::strerror(errno)));
}

}  // namespace

void add_map(CLI::App& app) {
  CLI::App* map = app.add_subcommand("map", "Map the states in Parquet files to results in Parquet files");
  const auto add = [map](const char* name, const char* meaning, const char* type) {
    const auto keep = [](const CLI::results_t&) { return true; };
    return map->add_option(name, keep, meaning)->type_name(type);
  };
  const auto add_flag = [map](const char* name, const char* meaning) {
    map->add_flag_function(
        name, [](std::int64_t) {}, meaning);
  };
  add("FUNCTION", "A function of a state, such as inverse_dynamics or poses", "TEXT")->required();
  add("MODEL", "A drawing (.toml), a URDF, SDFormat, MJCF or xacro", "FILE")->required();
  add("STATES", "A Parquet file, or a folder of Parquet files", "FILE")->required();
  add("OUTPUT", "A file if the name ends in .parquet, otherwise a folder", "FILE")->required();
  add("--base", "Joint of the base: fixed, or free; default: that of the file", "fixed|free");
  add_flag("--strict", "Treat warnings as errors");
  add("--set", "An argument of the function; may be given again", "NAME=VALUE")
      ->expected(1, CLI::detail::expected_max_vector_size)
      ->allow_extra_args(false);
  add("--keep",
      "Columns to copy, separated by commas, or all, or none; default: all that are not part of a state",
      "NAMES");
  add_flag("--float", "Write float instead of double");
  add("--faulty", "What to do if a state has no result; default: refuse", "refuse|nan");
  add_flag("--overwrite", "Replace existing results");
  add("--cluster", "Address of a Ray cluster, or local; default: $RAY_ADDRESS or this process", "ADDRESS");
  add("--threads", "Threads of this process; default: one for each core", "N");
  map->footer(map_footer);
  map->callback([map] { hand_over(words_given(*map)); });
}

}  // namespace axode::command
