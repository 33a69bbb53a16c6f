#pragma once
#include "axode/model/building/checks/value_checks.hpp"

namespace axode {

/// Checks the numbers, frames and force law of a spring. The numbers may have any value, including infinity
/// and NaN. `at` names the spring and collects its faults.
void check_spring(const FaultySubject& at, const SpringDescription& spring);

}  // namespace axode
