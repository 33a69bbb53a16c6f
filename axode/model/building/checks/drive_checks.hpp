#pragma once

#include "axode/model/building/checks/value_checks.hpp"

namespace axode {

/// Checks the parameters, the initial state, the input, and the joints or line of a drive. The numbers of the
/// drive may have any value, including infinity and NaN. `at` names the drive and collects its faults.
void check_drive(const FaultySubject& at, const DriveDescription& drive);

/// Checks the drives whose input is the output of another drive: the other drive must exist and be a
/// controller, and no drive may feed itself by way of others.
void check_feeding(FaultCollector& faults, const Description& description);

}  // namespace axode
