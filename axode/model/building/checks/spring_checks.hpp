#pragma once
#include "axode/model/building/checks/value_checks.hpp"

namespace axode {

/// Checks the values of a spring, which may be any numbers.
void check_spring(const FaultySubject& at, const SpringDescription& spring);

}  // namespace axode
