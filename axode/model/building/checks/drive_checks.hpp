#pragma once

#include "axode/model/building/checks/value_checks.hpp"

namespace axode {

/// Checks the parameters, initial state, input, and joints or line of a drive, whose numbers may be anything.
void check_drive(const FaultySubject& at, const DriveDescription& drive);

/// Checks the drives whose input is the output of another one, which must be a controller; cycles are errors.
void check_feeding(FaultCollector& faults, const Description& description);

}  // namespace axode
