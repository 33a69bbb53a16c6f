#pragma once
#include <memory>

#include "axode/drives/drive_law.hpp"
#include "axode/model/description.hpp"

namespace axode {

/// Makes the law of a drive from its checked description. Parameters that are not given have standard values.
std::shared_ptr<const DriveLaw> make_law(const DriveDescription& drive);

}  // namespace axode
