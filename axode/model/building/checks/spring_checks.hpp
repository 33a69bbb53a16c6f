#pragma once
#include "axode/model/building/checks/value_checks.hpp"

namespace axode {

/// Checks the numbers, which may be anything, the frames and the force law of a spring.
void check_spring(const FaultySubject& at, const SpringDescription& spring);

}  // namespace axode
