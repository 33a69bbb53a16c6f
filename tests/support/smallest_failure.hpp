#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <string>

namespace axode::test {

/// Finds a smaller example for a law that fails on a random mechanism: repeats the law with 1, 2, ... moving
/// bodies until it fails again. This works because a limit to the number of bodies does not change the first
/// ones. Returns the failure and a drawing of the smaller mechanism, or a sentence if the law fails with all
/// bodies only. Failures of these repetitions do not count as failures of the test.
std::string smallest_failure(const std::function<void()>& law);

/// Calls law(seed) for the seeds 1, 2, ..., `count` until one fails. That one is repeated with fewer bodies,
/// see smallest_failure(). The variable AXODE_RANDOM_TREES overrides `count`.
template <class F> void for_seeds(int count, const F& law) {
  if (const char* chosen = std::getenv("AXODE_RANDOM_TREES")) count = std::max(1, std::atoi(chosen));
  for (int seed = 1; seed <= count && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto repeat = [&] { law(static_cast<std::uint64_t>(seed)); };
    repeat();
    if (testing::Test::HasFailure()) ADD_FAILURE() << smallest_failure(repeat);
  }
}

}  // namespace axode::test
