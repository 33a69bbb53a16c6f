#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/apps/run_command.hpp"

/// Every mistake is answered by one sentence on standard error that names the thing, the value and the rule.
namespace axode::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

/// A row of tests/data/mistakes.json: the arguments after `axode`, where {FILE} stands for a robot of the
/// project, the standard input, and the expected standard error. If the row ends in "...", only the beginning
/// of standard error is given.
struct Mistake {
  std::string name;
  int code;
  std::vector<std::string> arguments;
  std::string input, says;
};

void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.name; }

std::vector<Mistake> mistakes() {
  std::string text = contents(AXODE_SOURCE_DIR "/tests/data/mistakes.json");
  for (const char* file : {"arm7.toml", "double_pendulum.toml", "four_bar.toml", "governor.toml",
                           "humanoid.urdf", "machine.toml"}) {
    const std::string word = std::string("{") + file + "}";
    for (std::size_t at; (at = text.find(word)) != std::string::npos;)
      text.replace(at, word.size(), robot(file));
  }
  std::vector<Mistake> all;
  for (const nlohmann::json& row : nlohmann::json::parse(text))
    all.push_back({row[0], row[1], row[2], row[3], row[4]});
  return all;
}

class CommandLine : public testing::TestWithParam<Mistake> {};
INSTANTIATE_TEST_SUITE_P(Mistakes, CommandLine, testing::ValuesIn(mistakes()),
                         [](const auto& p) { return p.param.name; });

TEST_P(CommandLine, IsRefusedInASentenceForEachFault) {
  const Mistake& mistake = GetParam();
  const Outcome outcome = axode(mistake.arguments, mistake.input);
  EXPECT_EQ(outcome.code, mistake.code);
  EXPECT_EQ(outcome.out, "");
  if (mistake.says.ends_with("..."))
    EXPECT_THAT(outcome.err, StartsWith(mistake.says.substr(0, mistake.says.size() - 3)));
  else
    EXPECT_EQ(outcome.err, mistake.says);
}

TEST(Errors, AStateThatIsNestedDeeplyIsRefused) {
  const std::size_t depth = 100'000;
  std::string lists = std::string(depth, '[') + std::string(depth, ']'), objects;
  for (std::size_t k = 0; k < depth; ++k) objects += "{\"q\":";
  objects += '1' + std::string(depth, '}');
  for (const std::string& state : {lists, objects, "{\"q\": " + lists + '}'}) {
    const Outcome outcome = axode({"eval", robot("arm7.toml"), "--state", "-"}, state);
    EXPECT_EQ(outcome.code, 1);
    EXPECT_EQ(outcome.err, "axode eval: standard input: it is nested deeper than 16 levels\n");
  }
}

TEST(Errors, AModelWithFaultsIsAnsweredByALineForEach) {
  const TemporaryFolder folder;
  const std::string file = folder.write("bad.toml", R"(format = "axode drawing 1"
[[body]]
name = "a"
on = "b"
joint = { kind = "revolute", axis = [0, 0, 0], point = [0, 0, 0] }
)");
  const Outcome outcome = axode({"eval", file});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.out, "");
  std::istringstream lines(outcome.err);
  std::string line;
  int n = 0;
  for (; std::getline(lines, line); ++n) EXPECT_THAT(line, StartsWith(file + ":"));
  EXPECT_EQ(n, 2) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("\"b\", which is not described"));
  EXPECT_THAT(outcome.err, HasSubstr("an axis is (0, 0, 0)"));
}

TEST(Errors, ABaseThatCannotBeSetFreeIsSaid) {
  const TemporaryFolder folder;
  const std::string file = folder.write("two.toml", R"(format = "axode drawing 1"
name = "two"
[[body]]
name = "a"
joint = { kind = "revolute", axis = "z", point = [0, 0, 0] }
mass = 1
com = [0, 0, 0]
inertia = [1, 1, 1]
)");
  const Outcome outcome = axode({"eval", file, "--base", "free"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err,
              HasSubstr("0 bodies are fixed to the ground; a free base needs exactly one to set free"));
}

TEST(Errors, OutputThatCannotBeWrittenIsAnError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this machine has no /dev/full";
  for (const std::string words : {"info \"$1\"", "--version"}) {
    const Outcome outcome =
        run({"sh", "-c", "\"$0\" " + words + " > /dev/full", AXODE_COMMAND, robot("arm7.toml")});
    EXPECT_EQ(outcome.code, 1) << words;
    EXPECT_THAT(outcome.err, StartsWith("axode"));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

}  // namespace
}  // namespace axode::test
