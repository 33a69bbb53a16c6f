#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "apps/commands/overview.hpp"
#include "apps/shell/command_line.hpp"
#include "apps/shell/commands.hpp"

/// The manual page of `axode`: the help of the program and of every command.
namespace axode::command {
namespace {

constexpr const char* footer = R"(Example:
  axode manual

To read it: axode manual | man -l -. After `cmake --install`: man axode.)";

/// Lines of roff that are shown with their breaks and blanks.
std::string as_it_stands(const std::string& text) {
  constexpr std::string_view special = "\\-'`^~";
  constexpr std::array names{"\\e", "\\-", "\\(aq", "\\(ga", "\\(ha", "\\(ti"};
  std::string out = ".EX\n";
  for (const std::string& line : CLI::detail::split(text, '\n')) {
    if (line.starts_with('.')) out += "\\&";
    for (const char c : line) {
      const std::size_t k = special.find(c);
      out += k == std::string_view::npos ? std::string(1, c) : names[k];
    }
    out += line.empty() ? ".sp\n" : "\n";
  }
  return out + ".EE\n";
}

std::string page(const CLI::App& app) {
  std::string text =
      fmt::format(".TH AXODE 1 \"{}\" \"axode {}\" \"User Commands\"\n.SH NAME\naxode \\- {}\n", AXODE_DATE,
                  AXODE_VERSION, app.get_description());
  text +=
      ".SH SYNOPSIS\n.B axode\n.I COMMAND\n.RI [ ARGUMENTS ]\n.SH DESCRIPTION\n" + as_it_stands(overview());
  text += ".SH COMMANDS\n";
  for (const CLI::App* command : commands(app))
    text += ".SS " + command->get_name() + '\n' + as_it_stands(command->help("axode"));
  return text + ".SH NOTES\n" + as_it_stands(app.get_footer());
}

}  // namespace

void add_manual(CLI::App& app, int& exit_code) {
  CLI::App* manual = app.add_subcommand("manual", "Print the manual page");
  manual->footer(footer);
  manual->callback([&app, &exit_code] {
    fmt::print("{}", page(app));
    exit_code = all_well;
  });
}

}  // namespace axode::command
