#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "command_line.hpp"
#include "commands.hpp"
#include "overview.hpp"

/// The manual page of `axode`, made from the command line itself.
namespace axode::command {
namespace {

constexpr const char* footer = R"(Example:
  axode manual

To read it: axode manual | man -l -. An installed axode has it in its place: man axode.)";

/// Text of roff that is shown as it stands; what is not ASCII is not needed anywhere.
std::string roff(const std::string& text) {
  std::string out;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const bool begins_line = k == 0 || text[k - 1] == '\n';
    if (begins_line && (text[k] == '.' || text[k] == '\'')) out += "\\&";
    switch (text[k]) {
      case '\\': out += "\\e"; break;
      case '-': out += "\\-"; break;
      case '\'': out += "\\(aq"; break;
      case '`': out += "\\(ga"; break;
      case '^': out += "\\(ha"; break;
      case '~': out += "\\(ti"; break;
      default: out += text[k];
    }
  }
  return out;
}

/// Lines that keep their breaks and blanks.
std::string as_it_stands(const std::string& text) {
  std::string out = ".EX\n";
  for (const std::string& line : CLI::detail::split(text, '\n'))
    out += line.empty() ? ".sp\n" : roff(line) + "\n";
  return out + ".EE\n";
}

std::string described(const CLI::Option& option) {
  std::string names;
  for (const std::string& name : flags(option))
    names += (names.empty() ? "" : ", ") + fmt::format("\\fB{}\\fR", roff(name));
  const std::string value = option.get_positional() ? option.get_name(true) : option.get_type_name();
  if (takes_value(option)) names += fmt::format("{}\\fI{}\\fR", names.empty() ? "" : " ", roff(value));
  return fmt::format(".TP\n{}\n{}\n", names, roff(option.get_description()));
}

std::string section(const CLI::App& command) {
  std::string usage = "axode " + command.get_name() + " [OPTIONS]";
  for (const CLI::Option* argument : positionals(command)) usage += " " + argument->get_name(true);
  std::string text = fmt::format(".SS {}\n{}.\n.PP\n\\fB{}\\fR\n", roff(command.get_name()),
                                 roff(command.get_description()), roff(usage));
  for (const CLI::Option* option : command.get_options()) text += described(*option);
  return text + ".PP\n" + as_it_stands(command.get_footer());
}

std::string page(const CLI::App& app) {
  std::string text =
      fmt::format(R"(.TH AXODE 1 "{}" "axode {}" "User Commands"
.SH NAME
axode \- {}
.SH SYNOPSIS
.B axode
.I COMMAND
.RI [ ARGUMENTS ]
.SH DESCRIPTION
{}.SH OPTIONS
)",
                  AXODE_DATE, AXODE_VERSION, roff(app.get_description()), as_it_stands(overview()));
  for (const CLI::Option* option : app.get_options()) text += described(*option);
  text += ".SH COMMANDS\n";
  for (const CLI::App* command : commands(app)) text += section(*command);
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
