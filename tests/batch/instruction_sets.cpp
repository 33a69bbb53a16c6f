#include "tests/support/instruction_sets.hpp"

/// The tests of batches pass with each instruction set that the processor has.
namespace axode::test {
namespace {

class InstructionSets : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(, InstructionSets, every_instruction_set(), name_of_set);

TEST_P(InstructionSets, GiveWhatTheLibraryGivesOneByOne) {
  expect_pass_under(GetParam(), "ManyStates/*:Rollouts.*:*SingularToRounding.*");
}

}  // namespace
}  // namespace axode::test
