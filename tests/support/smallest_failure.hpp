#pragma once
#include <functional>
#include <string>

namespace axode::test {

/// Repeats a law over a random mechanism, which fails, with 1, 2, ... moving bodies until it fails again: the first
/// bodies of a mechanism do not depend on how many there are. Returns what fails then and the mechanism as a drawing, or a
/// sentence if the law fails with all of its bodies only. Failures of the repetitions are not counted.
std::string smallest_failure(const std::function<void()>& law);

}  // namespace axode::test
