#include <gmock/gmock.h>

#include "axode/batch.hpp"
#include "tests/support/run_program.hpp"

/// The tests of batches pass with each instruction set that the processor has.
namespace axode::test {
namespace {

bool processor_has(const std::string& set) {
  if (set == "AVX-512")
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
  return set == "SSE2" || (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"));
}

/// The outcome of some tests of this program if the library may use instruction sets up to this limit only.
Outcome run_under(const std::string& limit, const std::string& tests) {
  return run({"env", "-u", "GTEST_TOTAL_SHARDS", "-u", "GTEST_SHARD_INDEX", "AXODE_INSTRUCTION_SET=" + limit,
              "AXODE_RANDOM_TREES=20", std::filesystem::read_symlink("/proc/self/exe"), "--gtest_brief=1",
              "--gtest_filter=" + tests});
}

TEST(InstructionSet, IsTheBestOneOrTheOneAskedFor) {
  const char* asked = std::getenv("AXODE_INSTRUCTION_SET");
  const std::string best = processor_has("AVX-512") ? "AVX-512" : processor_has("AVX2") ? "AVX2" : "SSE2";
  EXPECT_EQ(batch::instruction_set(), asked == nullptr ? best : asked);
}

TEST(InstructionSet, OfAnotherNameIsRefused) {
  EXPECT_THAT(run_under("MMX", "InstructionSet.IsTheBestOneOrTheOneAskedFor").out,
              testing::HasSubstr("AXODE_INSTRUCTION_SET is \"MMX\"; it must be SSE2, AVX2 or AVX-512"));
}

class InstructionSets : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(, InstructionSets, testing::Values("SSE2", "AVX2", "AVX-512"),
                         [](const auto& set) { return set.param == "AVX-512" ? "AVX512" : set.param; });

TEST_P(InstructionSets, GiveWhatTheLibraryGivesOneByOne) {
  if (!processor_has(GetParam())) GTEST_SKIP() << "this processor has no " << GetParam();
  const Outcome outcome =
      run_under(GetParam(),
                "InstructionSet.IsTheBestOneOrTheOneAskedFor:ManyStates/*:Rollouts.*:*SingularToRounding.*");
  EXPECT_EQ(outcome.code, 0) << outcome.out;
}

}  // namespace
}  // namespace axode::test
