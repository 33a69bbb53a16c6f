#include "tests/support/counted_work.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

// Functions of Clang's runtime library, which are there if a program is compiled with -fprofile-instr-generate.
// There is one counter for each region of the code: a function, a branch, the body of a loop.
extern "C" {
[[gnu::weak]] std::uint64_t* first_counter() __asm__("__llvm_profile_begin_counters");
[[gnu::weak]] std::uint64_t* end_of_counters() __asm__("__llvm_profile_end_counters");
}

namespace axode::test {
namespace {

std::vector<std::uint64_t> counters() {
  if (!first_counter) return {};
  return {first_counter(), end_of_counters()};
}

/// How often each region is entered in with(n).
std::vector<std::uint64_t> entries(const std::function<void(int)>& with, int n) {
  const std::vector<std::uint64_t> before = counters();
  with(n);
  std::vector<std::uint64_t> entries = counters();
  std::ranges::transform(entries, before, entries.begin(), std::minus());
  return entries;
}

}  // namespace

void expect_work_in_proportion_to_size(const std::function<void(int)>& with) {
  const int n = 100;
  const std::vector<std::uint64_t> few = entries(with, n), many = entries(with, 4 * n);
  std::uint64_t most = 0;
  for (std::size_t i = 0; i < few.size(); ++i) {
    most = std::max(most, many[i]);
    if (many[i] > 8 * std::max<std::uint64_t>(few[i], 10 * n))
      ADD_FAILURE() << "a region of the code is entered " << few[i] << " times for " << n << " and "
                    << many[i] << " times for " << 4 * n;
  }
  EXPECT_TRUE(few.empty() || most >= 10 * n) << "nothing has been counted";
}

}  // namespace axode::test
