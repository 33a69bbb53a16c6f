#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "axode/integration.hpp"
#include "tests/apps/run_command.hpp"

/// The support for shells: completion, which is tested in the shells themselves, and the manual page.
namespace axode::test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::UnorderedElementsAreArray;

using Words = std::vector<std::string>;

Words lines_of(const std::string& text) {
  std::istringstream in(text);
  Words lines;
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) lines.push_back(line);
  return lines;
}

/// The names of all commands, read from the answer to an unknown command.
Words commands() {
  const std::string error = axode({"no such command"}).err, before = "there are ";
  std::istringstream list(error.substr(error.find(before) + before.size()));
  Words names;
  for (std::string name; list >> name && name.front() != '(';) {
    name.erase(std::min(name.find_first_of(",;"), name.size()));
    names.push_back(name);
  }
  return names;
}
/// The options with two dashes in the help of a command.
Words options(const std::string& command) {
  Words names;
  for (const std::string& line : lines_of(axode({command, "--help"}).out)) {
    const std::string own = line.substr(0, line.find("Example"));
    if (!own.starts_with("  -")) continue;
    const std::size_t start = own.find("--");
    names.push_back(own.substr(start, own.find_first_of(" ,", start) - start));
  }
  return names;
}
Words method_names() {
  Words names;
  for (const auto& [name, method] : methods) names.emplace_back(name);
  return names;
}

/// Generates the completion scripts of the shells and a folder in which the shells look for files.
class Completion : public testing::Test {
 protected:
  Completion() {
    folder_.write("arm.toml", "");
    for (const char* shell : {"bash", "zsh", "fish"}) {
      const Outcome script = axode({"completion", shell});
      EXPECT_EQ(script.code, 0) << script.err;
      folder_.write(shell, script.out);
    }
  }
  Outcome in_shell(Words words) const {
    const std::string path =
        std::filesystem::path(AXODE_COMMAND).parent_path().string() + ":" + getenv("PATH");
    words.insert(words.begin(), {"env", "-C", folder_.path().string(), "PATH=" + path});
    return run(words);
  }

  /// The words with which bash offers to complete the last of these words.
  Words bash(Words words) const {
    words.insert(words.begin(), {"bash", "-c",
                                 "source ./bash; COMP_WORDS=(\"$@\"); COMP_CWORD=$(($# - 1)); _axode; "
                                 "printf '%s\\n' \"${COMPREPLY[@]}\"",
                                 "bash", "axode"});
    const Outcome outcome = in_shell(words);
    EXPECT_EQ(outcome.err, "");
    return lines_of(outcome.out);
  }
  /// The completions that fish offers for a line, without their descriptions.
  Words fish(const std::string& line) const {
    const Outcome outcome =
        in_shell({"fish", "--no-config", "-c", "source ./fish; complete -C \"" + line + "\""});
    EXPECT_EQ(outcome.err, "");
    Words words = lines_of(outcome.out);
    for (std::string& word : words) word.erase(std::min(word.find('\t'), word.size()));
    return words;
  }
  /// The lines to which zsh completes these beginnings.
  Words zsh(const Words& beginnings) const {
    Words words{"timeout", "60", "zsh", "-f", "-c", R"(
zmodload zsh/zpty
zpty shell zsh -f -i
zpty -w shell 'PS1=; autoload -Uz compinit; compinit -u -D; source ./zsh; stty -echo; setopt no_list_ambiguous no_beep;
  show() { print -r -- "<<$BUFFER>>"; BUFFER= }; zle -N show; bindkey "^X" show; print -r -- ready""now'
zpty -r shell text '*readynow*'
for beginning in "$@"; do
  zpty -w -n shell "$beginning"$'\t\030'
  zpty -r shell text '*\<\<*\>\>*'
  print -r -- "${${text##*<<}%%>>*}"
done)", "zsh"};
    words.insert(words.end(), beginnings.begin(), beginnings.end());
    return lines_of(in_shell(words).out);
  }

  TemporaryFolder folder_;
};

TEST_F(Completion, InBashHasEveryCommandAndOption) {
  EXPECT_THAT(bash({""}), UnorderedElementsAreArray(commands()));
  EXPECT_THAT(bash({"ev"}), ElementsAre("eval"));
  EXPECT_THAT(bash({"--v"}), ElementsAre("--version"));
  for (const std::string& command : commands()) {
    const Words known = options(command);
    ASSERT_THAT(known, Contains("--help"));
    EXPECT_THAT(bash({command, "--"}), UnorderedElementsAreArray(known)) << command;
  }
  EXPECT_THAT(bash({"simulate", "arm.toml", "--meth"}), ElementsAre("--method"));
}

TEST_F(Completion, InBashHasTheWordsThatOptionsTake) {
  EXPECT_EQ(methods.size(), 16);
  EXPECT_THAT(bash({"simulate", "--method", ""}), UnorderedElementsAreArray(method_names()));
  EXPECT_THAT(bash({"simulate", "--method", "=", "kah"}), ElementsAre("kahan_li6"));
  EXPECT_THAT(bash({"simulate", "--method", "="}), UnorderedElementsAreArray(method_names()));
  EXPECT_THAT(bash({"eval", "--representation", ""}), ElementsAre("body", "spatial", "hybrid", "mixed"));
  EXPECT_THAT(bash({"eval", "--want", "poses,elastic_e"}), ElementsAre("poses,elastic_energy"));
  EXPECT_THAT(bash({"codegen", "--functions", "jac"}), ElementsAre("jacobian"));
  EXPECT_THAT(bash({"codegen", "--abi", "cu"}), ElementsAre("cuda"));
  EXPECT_THAT(bash({"completion", ""}), ElementsAre("bash", "zsh", "fish"));
  EXPECT_THAT(bash({"info", "ar"}), ElementsAre("arm.toml"));
  EXPECT_THAT(bash({"eval", "--state", "ar"}), ElementsAre("arm.toml"));
  EXPECT_THAT(bash({"simulate", "--until", ""}), ElementsAre());
}

TEST_F(Completion, InFishHasTheSame) {
  EXPECT_THAT(fish("axode "), UnorderedElementsAreArray(commands()));
  EXPECT_THAT(fish("axode ev"), ElementsAre("eval"));
  EXPECT_THAT(fish("axode simulate --meth"), ElementsAre("--method"));
  EXPECT_THAT(fish("axode simulate --method "), UnorderedElementsAreArray(method_names()));
  EXPECT_THAT(fish("axode simulate --method=kah"), ElementsAre("--method=kahan_li6"));
  EXPECT_THAT(fish("axode eval --want poses,elastic_e"), ElementsAre("poses,elastic_energy"));
  EXPECT_THAT(fish("axode completion "), ElementsAre("bash", "fish", "zsh"));
  EXPECT_THAT(fish("axode info ar"), ElementsAre("arm.toml"));
}

TEST_F(Completion, InZshHasTheSame) {
  EXPECT_THAT(
      zsh({"axode ev", "axode simulate --meth", "axode simulate --method kah", "axode simulate --method=kah",
           "axode eval --want poses,elastic_e", "axode completion z", "axode info ar"}),
      ElementsAre("axode eval ", "axode simulate --method=", "axode simulate --method kahan_li6 ",
                  "axode simulate --method=kahan_li6 ", "axode eval --want poses,elastic_energy,",
                  "axode completion zsh ", "axode info arm.toml "));
}

// ------------------------------------------------------------------------------------------- the manual page

TEST(Manual, HasEveryCommandAndOption) {
  const std::string page = axode({"manual"}).out;
  for (const std::string& command : commands()) {
    EXPECT_THAT(page, HasSubstr("\n.SS " + command + "\n"));
    for (std::string option : options(command)) {
      for (std::size_t k = 0; (k = option.find('-', k)) != std::string::npos; k += 2)
        option.insert(k, 1, '\\');
      EXPECT_THAT(page, HasSubstr(option)) << command;
    }
  }
}

TEST(Manual, IsWithoutFaultsForTheProgramsThatShowIt) {
  const TemporaryFolder folder;
  const std::string page = folder.write("axode.1", axode({"manual"}).out);
  const Outcome lint = run({"mandoc", "-T", "lint", "-W", "warning", page});
  EXPECT_EQ(lint.out + lint.err, "");
  const Outcome shown = run({"mandoc", "-T", "ascii", page});
  EXPECT_THAT(shown.out, HasSubstr("axode linearize double_pendulum.toml --state - --equilibrium"));
  EXPECT_THAT(shown.out, HasSubstr("echo '{\"q\": {\"pin\": 2}}' | axode simulate"));
}

}  // namespace
}  // namespace axode::test
