#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/readme_example.hpp"
#include "tests/apps/run_command.hpp"

/// The first page shows what really happens.
namespace axode::test {
namespace {

using testing::HasSubstr;

std::string readme() { return contents(AXODE_SOURCE_DIR "/README.md"); }

/// The blocks of code in one language.
std::vector<std::string> blocks(const std::string& language) {
  std::vector<std::string> found;
  std::istringstream lines(readme());
  std::string line;
  while (std::getline(lines, line)) {
    if (line != "```" + language) continue;
    found.emplace_back();
    while (std::getline(lines, line) && line != "```") found.back() += line + "\n";
  }
  return found;
}

TEST(Readme, EveryCommandAnswersAsShown) {
  const TemporaryFolder folder;
  for (const auto& robot : std::filesystem::directory_iterator(AXODE_SOURCE_DIR "/examples/robots"))
    std::filesystem::copy(robot.path(), folder.path());
  ASSERT_EQ(blocks("toml").size(), 1U);
  folder.write("drill.toml", blocks("toml")[0]);
  int commands = 0;
  for (const std::string& block : blocks("console")) {
    std::istringstream lines(block);
    std::string line, script, shown;
    while (std::getline(lines, line)) {
      if (line.starts_with("$ ")) {
        script += line.substr(2) + "\n";
        ++commands;
      } else {
        shown += line + "\n";
      }
    }
    const Outcome outcome =
        run({"sh", "-c", "cd \"$0\" && axode() { \"" AXODE_COMMAND "\" \"$@\"; } && " + script,
             folder.path().string()});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, shown);
  }
  EXPECT_EQ(commands, 3);
}

TEST(Readme, TheProgramCompilesAndPrintsWhatIsShown) {
  const std::string program = contents(AXODE_SOURCE_DIR "/tests/apps/readme_example.hpp");
  ASSERT_EQ(blocks("cpp").size(), 1U);
  EXPECT_EQ("#pragma once\n" + blocks("cpp")[0], program);
  testing::internal::CaptureStdout();
  print_drive_torques(robot("arm7.toml").c_str());
  EXPECT_THAT(readme(), HasSubstr("```\n" + testing::internal::GetCapturedStdout() + "```\n"));
}

}  // namespace
}  // namespace axode::test
