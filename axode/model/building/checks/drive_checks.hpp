#pragma once

#include "axode/model/building/checks/value_checks.hpp"

namespace axode {

/// Checks the numbers of a drive, which may be any: its parameters, its initial state and its input.
void check_drive(const FaultySubject& at, const DriveDescription& drive);

/// Checks that inputs name drives that may feed others, and that no drive feeds itself.
void check_feeding(FaultCollector& faults, const Description& description);

}  // namespace axode
