#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/readme_example.hpp"
#include "tests/apps/run_command.hpp"

/// The output and the code in README.md are what the programs really print and run.
namespace axode::test {
namespace {

using testing::HasSubstr;

std::string readme() { return contents(AXODE_SOURCE_DIR "/README.md"); }

/// All blocks of code in one language.
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
