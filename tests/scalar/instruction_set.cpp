#include "axode/model/building/builder.hpp"
#include "tests/support/instruction_sets.hpp"

/// The environment chooses the instruction set when the program starts, so that the tests of a choice run in
/// a program of their own.
namespace axode::test {
namespace {

TEST(InstructionSet, IsTheBestOneOfTheProcessor) {
  if (std::getenv("AXODE_INSTRUCTION_SET") != nullptr) GTEST_SKIP() << "a set is asked for";
  const std::string best = instruction_set();
  for (const std::string set : {"x86-64", "x86-64-v3", "x86-64-v4"})
    if (set > best) {
      EXPECT_THAT(run_under(set, "InstructionSet.IsTheOneAskedFor").out,
                  testing::HasSubstr("AXODE_INSTRUCTION_SET is \"" + set + "\"; "));
    }
}

TEST(InstructionSet, OfAnotherNameIsRefusedByTheFirstModel) {
  const char* const asked = std::getenv("AXODE_INSTRUCTION_SET");
  if (asked != nullptr && asked == std::string("MMX")) {
    ModelBuilder("pendulum").build();  // throws
    return;
  }
  EXPECT_THAT(run_under("MMX", "InstructionSet.OfAnotherNameIsRefusedByTheFirstModel").out,
              testing::HasSubstr("AXODE_INSTRUCTION_SET is \"MMX\"; it must be "));
}

}  // namespace
}  // namespace axode::test
