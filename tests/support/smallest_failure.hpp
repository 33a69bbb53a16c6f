#pragma once
#include <functional>
#include <string>

namespace axode::test {

/// Finds a smaller example for a law that fails on a random mechanism: repeats the law with 1, 2, ... moving
/// bodies until it fails again. This works because a limit to the number of bodies does not change the first
/// ones. Returns the failure and a drawing of the smaller mechanism, or a sentence if the law fails with all
/// bodies only. Failures of these repetitions do not count as failures of the test.
std::string smallest_failure(const std::function<void()>& law);

}  // namespace axode::test
