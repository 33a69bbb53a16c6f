#pragma once
#include <memory>

#include "axode/drives/drive_law.hpp"
#include "axode/model/description.hpp"

namespace axode {

/// Makes the law of a drive from its description, which must have been checked. Parameters that are not given
/// have the standard values of the kind of drive.
std::shared_ptr<const DriveLaw> make_law(const DriveDescription& drive);

}  // namespace axode
