#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "axode/codegen.hpp"
#include "axode/integration.hpp"
#include "choice.hpp"
#include "command_line.hpp"
#include "commands.hpp"
#include "quantities.hpp"

/// What makes a shell complete the words of `axode`, made from the command line itself.
namespace axode::command {
namespace {

constexpr const char* footer = R"(Example:
  axode completion bash

In ~/.bashrc: source <(axode completion bash). In ~/.zshrc, after compinit: source <(axode completion zsh). For fish:
axode completion fish > ~/.config/fish/completions/axode.fish. An installed axode has these files in their places.)";

enum class Shell { bash, zsh, fish };
constexpr std::array<std::pair<std::string_view, Shell>, 3> shells{
    {{"bash", Shell::bash}, {"zsh", Shell::zsh}, {"fish", Shell::fish}}};

/// What can stand for a value.
struct Offer {
  enum Kind { nothing, files, word, list } kind = nothing;  ///< a list has commas between its words
  std::vector<std::string> words = {};
};

template <class Range, class NameOf> std::vector<std::string> names(const Range& all, NameOf name_of) {
  std::vector<std::string> list;
  for (const auto& one : all) list.emplace_back(name_of(one));
  return list;
}

/// The type of a value is `FILE`, the words that it can be, as in `table|json`, or the name of words that are many.
Offer offer(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  if (type.starts_with("FILE")) return {Offer::files};
  if (type == "METHOD") return {Offer::word, names(methods, [](const auto& method) { return method.first; })};
  if (type == "QUANTITIES")
    return {Offer::list, names(quantities(), [](const Quantity& x) { return x.name; })};
  if (type == "FUNCTIONS") return {Offer::list, names(codegen::recorded_functions, std::identity())};
  if (type.find('|') != std::string::npos) return {Offer::word, CLI::detail::split(type, '|')};
  return {};
}

std::string in_one_line(const std::vector<std::string>& words, const char* separator = " ") {
  return fmt::format("{}", fmt::join(words, separator));
}

/// The text with a backslash before some of its characters.
std::string escaped(const std::string& text, std::string_view characters) {
  std::string out;
  for (const char c : text)
    out += (characters.find(c) == std::string_view::npos ? "" : "\\") + std::string(1, c);
  return out;
}
/// A word of POSIX shells.
std::string in_quotes(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return "'" + out + "'";
}

// ------------------------------------------------------------------------------------------------------- bash

/// What stands where no option asks for a value.
std::string bash_words(const CLI::App& command) {
  bool files = false;
  std::vector<std::string> options, words;
  for (const CLI::App* sub : commands(command)) words.push_back(sub->get_name());
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : flags(*option)) options.push_back(name);
  for (const CLI::Option* option : positionals(command)) {
    const Offer offered = offer(*option);
    files |= offered.kind == Offer::files;
    words.insert(words.end(), offered.words.begin(), offered.words.end());
  }
  return fmt::format("options='{}' words='{}' files={}", in_one_line(options), in_one_line(words),
                     files ? "yes" : "");
}

std::string bash_values(const CLI::App& command) {
  std::string text;
  for (const CLI::Option* option : command.get_options()) {
    if (!takes_value(*option) || !option->nonpositional()) continue;
    const Offer offered = offer(*option);
    std::vector<std::string> patterns;
    for (const std::string& name : flags(*option))
      patterns.push_back(in_quotes(command.get_name() + " " + name));
    const std::string words = in_one_line(offered.words);
    text += fmt::format("    {}) {} ;;\n", in_one_line(patterns, " | "),
                        offered.kind == Offer::files  ? "files=yes"
                        : offered.kind == Offer::list ? "list=" + in_quotes(words)
                                                      : "words=" + in_quotes(words));
  }
  return text;
}

std::string bash(const CLI::App& app) {
  std::string values, words = fmt::format("        '') {} ;;\n", bash_words(app));
  for (const CLI::App* command : commands(app)) {
    values += bash_values(*command);
    words += fmt::format("        {}) {} ;;\n", command->get_name(), bash_words(*command));
  }
  return fmt::format(R"(# Completion of axode for bash.
_axode() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}
  local command= options= words= list= files= head= k
  [[ $before == = ]] && before=${{COMP_WORDS[COMP_CWORD - 2]}}  # --option=value is three words
  [[ $word == = ]] && word=
  for ((k = 1; k < COMP_CWORD; ++k)); do
    [[ ${{COMP_WORDS[k]}} == -* ]] || {{ command=${{COMP_WORDS[k]}}; break; }}
  done
  case "$command $before" in
{}    *)
      case $command in
{}      esac
      [[ $word == -* || -z $words$files ]] && words=$options files=
      ;;
  esac
  COMPREPLY=()
  if [[ -n $files ]]; then
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  elif [[ -n $list ]]; then
    [[ $word == *,* ]] && head=${{word%,*}},
    mapfile -t COMPREPLY < <(compgen -P "$head" -W "$list" -- "${{word##*,}}")
  else
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  fi
}}
complete -F _axode axode
)",
                     values, words);
}

// -------------------------------------------------------------------------------------------------------- zsh

/// A description inside of [...] or behind a colon.
std::string zsh_text(const std::string& text) { return escaped(text, "\\[]:"); }

std::string zsh_value(const CLI::Option& option) {
  const Offer offered = offer(option);
  const std::string name = zsh_text(option.get_positional() ? option.get_name(true) : option.get_type_name());
  switch (offered.kind) {
    case Offer::files: return name + ":_files";
    case Offer::word: return fmt::format("{}:({})", name, in_one_line(offered.words));
    case Offer::list: return fmt::format("{}:_values -s , {} {}", name, name, in_one_line(offered.words));
    case Offer::nothing: break;
  }
  return name + ": ";
}

/// Options and arguments as _arguments takes them, a line each.
std::string zsh_arguments(const CLI::App& command, const std::string& indent) {
  std::string text;
  const auto add = [&](const std::string& spec) {
    text += fmt::format(" \\\n{}{}", indent, in_quotes(spec));
  };
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional()) continue;
    for (const std::string& name : flags(*option)) {
      const char* const again = several(*option) ? "*" : "";
      const std::string described =
          fmt::format("{}[{}]", takes_value(*option) && name.starts_with("--") ? "=" : "",
                      zsh_text(option->get_description()));
      add(again + name + described + (takes_value(*option) ? ":" + zsh_value(*option) : ""));
    }
  }
  int place = 0;
  for (const CLI::Option* option : positionals(command))
    add((several(*option) ? "*" : std::to_string(++place)) + ":" + zsh_value(*option));
  return text;
}

std::string zsh(const CLI::App& app) {
  std::string described, arguments;
  for (const CLI::App* command : commands(app)) {
    described += fmt::format("        {}\n", in_quotes(escaped(command->get_name(), ":") + ":" +
                                                       escaped(command->get_description(), "\\:")));
    arguments += fmt::format("        {}) _arguments{} ;;\n", command->get_name(),
                             zsh_arguments(*command, "          "));
  }
  return fmt::format(R"(#compdef axode
# Completion of axode for zsh.
_axode() {{
  local curcontext=$curcontext state line
  local -a commands
  _arguments -C{} \
    '1:command:->command' '*::argument:->argument'
  case $state in
    command)
      commands=(
{}      )
      _describe command commands
      ;;
    argument)
      case $words[1] in
{}      esac
      ;;
  esac
}}
if [[ $funcstack[1] == _axode ]]; then
  _axode "$@"
else
  compdef _axode axode
fi
)",
                     zsh_arguments(app, "    "), described, arguments);
}

// ------------------------------------------------------------------------------------------------------- fish

std::string fish_quoted(const std::string& text) { return "'" + escaped(text, "\\'") + "'"; }

/// What `complete` offers for a value or an argument: -F files, -f nothing but words.
std::string fish_offer(const CLI::Option& option) {
  const Offer offered = offer(option);
  switch (offered.kind) {
    case Offer::files: return " -F";
    case Offer::word: return " -f -a " + fish_quoted(in_one_line(offered.words));
    case Offer::list: return " -f -a " + fish_quoted("(__fish_append , " + in_one_line(offered.words) + ")");
    case Offer::nothing: break;
  }
  return " -f";
}

std::string fish_lines(const CLI::App& command, const std::string& condition) {
  std::string text;
  for (const CLI::Option* option : command.get_options()) {
    text += "complete -c axode -n " + fish_quoted(condition);
    for (const std::string& name : option->get_snames()) text += " -s " + name;
    for (const std::string& name : option->get_lnames()) text += " -l " + name;
    if (option->nonpositional()) text += " -d " + fish_quoted(option->get_description());
    if (takes_value(*option)) text += (option->nonpositional() ? " -r" : "") + fish_offer(*option);
    text += "\n";
  }
  return text;
}

std::string fish(const CLI::App& app) {
  std::string text =
      "# Completion of axode for fish.\ncomplete -c axode -f\n" + fish_lines(app, "__fish_use_subcommand");
  for (const CLI::App* command : commands(app)) {
    text += fmt::format("complete -c axode -n __fish_use_subcommand -a {} -d {}\n", command->get_name(),
                        fish_quoted(command->get_description()));
    text += fish_lines(*command, "__fish_seen_subcommand_from " + command->get_name());
  }
  return text;
}

}  // namespace

void add_completion(CLI::App& app, int& exit_code) {
  const auto shell = std::make_shared<std::string>();
  CLI::App* completion =
      app.add_subcommand("completion", "Print what makes a shell complete commands and options");
  completion->add_option("SHELL", *shell, "The shell")->required()->type_name(words(shells));
  completion->footer(footer);
  completion->callback([&app, shell, &exit_code] {
    switch (choose("SHELL", *shell, shells)) {
      case Shell::bash: fmt::print("{}", bash(app)); break;
      case Shell::zsh: fmt::print("{}", zsh(app)); break;
      case Shell::fish: fmt::print("{}", fish(app)); break;
    }
    exit_code = all_well;
  });
}

}  // namespace axode::command
