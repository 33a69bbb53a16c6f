#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "choice.hpp"
#include "commands.hpp"
#include "json_text.hpp"
#include "terminal.hpp"

namespace axode::command {
namespace {

struct Options {
  std::vector<std::string> files;
  std::string format = "table";
};

constexpr const char* footer = R"(Example:
  axode check arm7.toml humanoid.urdf

Every fault is one line, FILE:LINE: error: ... or FILE:LINE: warning: ... A body that no matter can make
(a mass of 0, an inertia that no density produces) is an error here, even where a URDF with it can be
loaded. The exit code is 1 where there is an error in any of the files.)";

/// The faults of a file; bodies that no matter can make are errors whatever the format of the file.
std::vector<Fault> judged(const std::string& file) {
  std::vector<Fault> faults = check(file);
  for (Fault& fault : faults)
    if (fault.rule == Rule::mass_not_positive || fault.rule == Rule::inertia_not_realisable)
      fault.severity = Severity::error;
  return faults;
}

std::string counted(std::size_t n, const char* what) {
  return fmt::format("{} {}{}", n == 0 ? "no" : std::to_string(n), what, n == 1 ? "" : "s");
}

int run(const Options& options) {
  const Format format = choose("--format", options.format, formats);
  Json files = Json::array();
  std::size_t all_errors = 0;
  for (const std::string& file : options.files) {
    const std::vector<Fault> faults = judged(file);
    const auto errors = static_cast<std::size_t>(std::count_if(
        faults.begin(), faults.end(), [](const Fault& f) { return f.severity == Severity::error; }));
    all_errors += errors;
    if (format == Format::json) {
      Json list = Json::array();
      for (const Fault& fault : faults)
        list.push_back({{"severity", fault.severity == Severity::error ? "error" : "warning"},
                        {"rule", to_string(fault.rule)},
                        {"element", fault.element},
                        {"message", fault.message},
                        {"line", fault.source.line}});
      files.push_back(
          {{"file", file}, {"errors", errors}, {"warnings", faults.size() - errors}, {"faults", list}});
      continue;
    }
    for (const Fault& fault : faults)
      fmt::print("{}\n", in(fault.severity == Severity::error ? Ink::bad : Ink::warning, to_string(fault)));
    fmt::print("{}\n", in(errors > 0 ? Ink::bad : Ink::good,
                          fmt::format("{}: {}, {}", file, counted(errors, "error"),
                                      counted(faults.size() - errors, "warning"))));
  }
  if (format == Format::json) fmt::print("{}", text({{"files", files}}));
  return all_errors > 0 ? bad_input : all_well;
}

}  // namespace

void add_check(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<Options>();
  CLI::App* check = app.add_subcommand("check", "List every fault of drawings and URDFs");
  check->add_option("MODEL", options->files, "Drawings (.toml) and URDFs")->required()->type_name("FILES");
  check->add_option("--format", options->format, "table (if left out) or json")->type_name("WORD");
  check->footer(footer);
  check->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace axode::command
