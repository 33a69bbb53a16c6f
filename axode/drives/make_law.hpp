#pragma once
#include <memory>

#include "axode/drives/drive_law.hpp"
#include "axode/model/description.hpp"

namespace axode {

/// The law of a drive that a description without faults has.
std::shared_ptr<const DriveLaw> make_law(const DriveDescription& drive);

}  // namespace axode
