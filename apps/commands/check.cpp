#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "apps/files/json_text.hpp"
#include "apps/files/model_options.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/table.hpp"
#include "apps/shell/terminal.hpp"

namespace axode::command {
namespace {

struct CheckOptions {
  ModelOptions mechanisms;
  std::string format = "table";
};

constexpr const char* check_footer = R"(Example:
  axode check arm7.toml humanoid.urdf

Every fault is printed as one line, FILE:LINE: error: ... or FILE:LINE: warning: ... A defect that does
not prevent computations is a warning, for example a mass of 0, an inertia that no density produces,
interchanged limits, or a joint that follows a joint which does not exist. With --strict it is an error,
as for every command. The exit code is 1 if any of the files has an error.)";

std::string counted_or_no(std::size_t n, const std::string& what) {
  return n == 0 ? "no " + what + "s" : counted(n, what);
}

int run(const CheckOptions& options) {
  const Format format = choose("--format", options.format, formats);
  Json files = Json::array();
  std::size_t all_errors = 0;
  const Base base = options.mechanisms.held();
  for (const std::string& file : options.mechanisms.files) {
    const std::vector<Fault> faults = axode::check(file, base, options.mechanisms.strictness());
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
                          fmt::format("{}: {}, {}", file, counted_or_no(errors, "error"),
                                      counted_or_no(faults.size() - errors, "warning"))));
  }
  if (format == Format::json) fmt::print("{}", text({{"files", files}}));
  return all_errors > 0 ? bad_input : all_well;
}

}  // namespace

void add_check(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<CheckOptions>();
  CLI::App* check = app.add_subcommand("check", "List every fault of drawings, URDFs and SDF files");
  add_model_options(*check, options->mechanisms, Files::several);
  check->add_option("--format", options->format, "Output format; default: table")->type_name(words(formats));
  check->footer(check_footer);
  check->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace axode::command
