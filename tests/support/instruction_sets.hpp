#pragma once
#include <gmock/gmock.h>

#include <string>

#include "axode/scalar/instruction_set.hpp"
#include "tests/support/run_program.hpp"

/// Tests of a program that are repeated under each instruction set.
namespace axode::test {

/// The outcome of some tests of this program if AXODE_INSTRUCTION_SET has a value.
inline Outcome run_under(const std::string& set, const std::string& tests) {
  return run({"env", "-u", "GTEST_TOTAL_SHARDS", "-u", "GTEST_SHARD_INDEX", "AXODE_INSTRUCTION_SET=" + set,
              "AXODE_RANDOM_TREES=20", std::filesystem::read_symlink("/proc/self/exe"), "--gtest_brief=1",
              "--gtest_filter=" + tests});
}

/// Expects that tests pass under a set, or skips them if this processor or this library does not have it.
/// This program itself runs them under the set that it has.
inline void expect_pass_under(const std::string& set, const std::string& tests) {
  if (set == instruction_set()) GTEST_SKIP() << set << " is the set of this program";
  const Outcome refused = run_under(set, "InstructionSet.IsTheOneAskedFor");
  if (refused.code != 0) {
    EXPECT_THAT(refused.out, testing::HasSubstr("AXODE_INSTRUCTION_SET is \"" + set + "\"; "));
    GTEST_SKIP() << refused.out;
  }
  const Outcome outcome = run_under(set, tests);
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
}

inline auto every_instruction_set() { return testing::Values("x86-64", "x86-64-v3", "x86-64-v4"); }
inline std::string name_of_set(const testing::TestParamInfo<const char*>& set) {
  return std::string(set.param) == "x86-64" ? "v1" : std::string(set.param).substr(7);
}

/// Programs that use this header have this test, which decides whether they can run under a set.
TEST(InstructionSet, IsTheOneAskedFor) {
  const char* const asked = std::getenv("AXODE_INSTRUCTION_SET");
  EXPECT_NO_THROW(instruction_set());
  if (asked != nullptr) {
    EXPECT_STREQ(instruction_set(), asked);
  }
}

}  // namespace axode::test
