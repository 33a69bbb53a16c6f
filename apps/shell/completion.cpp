#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "apps/quantities/quantities.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/command_line.hpp"
#include "apps/shell/commands.hpp"
#include "axode/codegen.hpp"
#include "axode/integration.hpp"

/// Completion in a shell, which calls the program for each word of a command line that is to be completed.
namespace axode::command {
namespace {

constexpr const char* completion_footer = R"(Example:
  axode completion bash

In ~/.bashrc: source <(axode completion bash). In ~/.zshrc, after compinit: source <(axode completion zsh).
For fish: axode completion fish > ~/.config/fish/completions/axode.fish. `cmake --install` installs them.
The scripts call axode with the WORDS of a command line, and axode prints the completions of the last word.)";

/// Scripts that complete command lines of axode in shells. Each line that axode prints for them is a word, a
/// tab and a description; the word `:files` stands for names of files.
constexpr const char* bash = R"sh(# Completion of axode for bash.
_axode() {
  mapfile -t COMPREPLY < <(
    "${COMP_WORDS[0]}" completion bash -- "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null | cut -f 1)
  if [[ ${COMPREPLY[0]} == :files ]]; then
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -- "${COMP_WORDS[COMP_CWORD]#=}")
  fi
}
complete -F _axode axode
)sh";
constexpr const char* zsh = R"sh(#compdef axode
# Completion of axode for zsh. A blank takes the characters = and , at the end of a word away.
_axode() {
  local line word suffix
  local -a shown
  for line in ${(f)"$($words[1] completion zsh -- "${(@)words[2,CURRENT]}" 2>/dev/null)"}; do
    word=${line%%$'\t'*} suffix=' ' shown=("${line/$'\t'/  -- }")
    [[ $word == :files ]] && { _files; return }
    [[ $word == *[=,] ]] && suffix=$word[-1] word=$word[1,-2]
    compadd -q -S $suffix -l -d shown -- $word
  done
}
if [[ $funcstack[1] == _axode ]]; then _axode "$@"; else compdef _axode axode; fi
)sh";
constexpr const char* fish = R"sh(# Completion of axode for fish.
function __axode
  set -l words (commandline -opc)
  set -l word (commandline -ct)
  set -l found ($words[1] completion fish -- $words[2..] "$word" 2>/dev/null)
  if test "$found[1]" = :files
    __fish_complete_path $word
  else
    printf '%s\n' $found
  end
end
complete -c axode -f -a '(__axode)'
)sh";

constexpr std::array<std::pair<std::string_view, const char*>, 3> shells{
    {{"bash", bash}, {"zsh", zsh}, {"fish", fish}}};

/// The possible completions of a word: names of files, which the shell lists, or words with descriptions.
struct Offer {
  bool files = false;
  bool list = false;  ///< whether commas separate several words
  std::vector<std::pair<std::string, std::string>> words = {};
};

/// Adds the values that an option of a command can have to the completions `offer`. The help of the option
/// says which they are: files (`FILE`), a few words (`table|json`), or a list of words that has a name, such
/// as METHOD.
void add_values(Offer& offer, const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto add = [&](const auto& all, const auto& name_of) {
    for (const auto& one : all) offer.words.emplace_back(name_of(one), "");
  };
  offer.files |= type.starts_with("FILE");
  offer.list |= type == "QUANTITIES" || type == "FUNCTIONS";
  if (type == "METHOD") add(methods, [](const auto& method) { return method.first; });
  if (type == "QUANTITIES") add(quantities(), [](const Quantity& x) { return x.name; });
  if (type == "FUNCTIONS") add(codegen::recorded_functions, std::identity());
  if (type.find('|') != std::string::npos) add(CLI::detail::split(type, '|'), std::identity());
}

/// Adds the words that can complete a command line: the options of the command if the word to be completed
/// begins like an option, otherwise its commands and the values of its positional arguments. If there are
/// none of these, the options are added.
void add_words(Offer& offer, const CLI::App& command, bool is_option, bool with_equals) {
  if (!is_option) {
    for (const CLI::App* sub : commands(command))
      offer.words.emplace_back(sub->get_name(), sub->get_description());
    for (const CLI::Option* option : positionals(command)) add_values(offer, *option);
    if (offer.files || !offer.words.empty()) return;
  }
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : flags(*option)) {
      const bool before_value = with_equals && takes_value(*option) && name.starts_with("--");
      offer.words.emplace_back(name + (before_value ? "=" : ""), option->get_description());
    }
}

/// The completions of the last of `words`, which are the words after `axode`, one in a line.
std::string completions(const CLI::App& app, std::vector<std::string> words, std::string_view shell) {
  std::string word = words.back(), head;  // `head` is the part of the word that is already complete
  words.pop_back();
  if (word == "=") word.clear();  // bash divides --option=value into three words
  std::erase(words, "=");
  if (const std::size_t end = word.find('='); word.starts_with("--") && end != std::string::npos) {
    words.push_back(word.substr(0, end));
    head = word.substr(0, end + 1);
  }
  const auto name = std::ranges::find_if(words, [](const std::string& x) { return !x.starts_with('-'); });
  const CLI::App* command = &app;
  for (const CLI::App* sub : commands(app))
    if (name != words.end() && sub->get_name() == *name) command = sub;
  const CLI::Option* asked = words.empty() ? nullptr : command->get_option_no_throw(words.back());
  Offer offer;
  if (asked != nullptr && asked->nonpositional() && takes_value(*asked))
    add_values(offer, *asked);
  else
    add_words(offer, *command, word.starts_with('-'), shell == "zsh");
  if (offer.files) return ":files\n";
  if (offer.list) head = word.substr(0, std::max(head.size(), word.rfind(',') + 1));
  std::string lines;
  for (const auto& [end, description] : offer.words)
    if (const std::string all = head + end; all.starts_with(word))
      lines += fmt::format("{}{}\t{}\n", all, offer.list && shell == "zsh" ? "," : "", description);
  return lines;
}

}  // namespace

void add_completion(CLI::App& app, int& exit_code) {
  const auto shell = std::make_shared<std::string>();
  const auto line = std::make_shared<std::vector<std::string>>();
  CLI::App* completion =
      app.add_subcommand("completion", "Print the script by which a shell completes commands and options");
  completion->add_option("SHELL", *shell, "The shell")->required()->type_name(words(shells));
  completion->add_option("WORDS", *line, "Words after axode; the last one is completed");
  completion->footer(completion_footer);
  completion->callback([&app, shell, line, &exit_code] {
    const char* const script = choose("SHELL", *shell, shells);
    fmt::print("{}", line->empty() ? script : completions(app, *line, *shell));
    exit_code = all_well;
  });
}

}  // namespace axode::command
