#pragma once
#include <functional>

/// Work that is counted and not timed, so that it is the same on every machine.
namespace axode::test {

/// Calls with(100) and with(400) and expects that the work of with(n) is in proportion to n: no region of the
/// program is entered more than eight times as often in the second call. With work in proportion to n log n
/// the factor is some 5, and to n² it is 16. Regions that are entered less than 10 n times are compared as if
/// they were entered as often, because other things, such as the number of digits of names, decide how often
/// they are entered. The compiler counts in the presets asan and coverage; in others nothing is compared.
/// This finds the region that is entered too often:
///   LLVM_PROFILE_FILE=a.profraw PROGRAM --gtest_filter=TEST
///   llvm-profdata-14 merge a.profraw -o a.profdata
///   llvm-profdata-14 show --all-functions --counts a.profdata
void expect_work_in_proportion_to_size(const std::function<void(int)>& with);

}  // namespace axode::test
