#include "tests/support/instruction_sets.hpp"

/// The laws in double hold for the code of each instruction set.
namespace axode::test {
namespace {

class InstructionSets : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(, InstructionSets, every_instruction_set(), name_of_set);

TEST_P(InstructionSets, ObeyTheLaws) { expect_pass_under(GetParam(), "*-InstructionSets*:*float*"); }

}  // namespace
}  // namespace axode::test
