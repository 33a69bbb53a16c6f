#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "apps/commands/overview.hpp"
#include "apps/shell/command_line.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/version.hpp"

/// The manual page of `axode`, which consists of the help of the program and of every command.
namespace axode::command {
namespace {

/// The text as roff source that shows it with its line breaks and blanks.
std::string as_it_stands(const std::string& text) {
  const std::pair<const char*, const char*> replacements[] = {
      {"\\", "\\e"},  {"-", "\\-"},   {"'", "\\(aq"},   {"`", "\\(ga"},
      {"^", "\\(ha"}, {"~", "\\(ti"}, {"\n.", "\n\\&."}};
  std::string roff = ".EX\n" + text;
  for (const auto& [from, to] : replacements) roff = CLI::detail::find_and_replace(roff, from, to);
  return roff + (text.ends_with('\n') ? ".EE\n" : "\n.EE\n");
}

std::string page(const CLI::App& app) {
  std::string text = fmt::format(
      ".TH AXODE 1 \"{}\" \"axode {}\" \"User Commands\"\n.SH NAME\naxode \\- {}\n"
      ".SH SYNOPSIS\n.B axode\n.I COMMAND\n.RI [ ARGUMENTS ]\n.SH DESCRIPTION\n{}.SH COMMANDS\n",
      build_date(), AXODE_VERSION, app.get_description(), as_it_stands(overview()));
  for (const CLI::App* command : commands(app))
    text += fmt::format(".SS {}\n{}", command->get_name(), as_it_stands(command->help("axode")));
  return text + ".SH NOTES\n" + as_it_stands(app.get_footer());
}

}  // namespace

void add_manual(CLI::App& app, int& exit_code) {
  CLI::App* manual = app.add_subcommand("manual", "Print the manual page");
  manual->footer("Example:\n  axode manual\n\nRead it by: axode manual | man -l -, or man axode");
  manual->callback([&app, &exit_code] {
    fmt::print("{}", page(app));
    exit_code = all_well;
  });
}

}  // namespace axode::command
