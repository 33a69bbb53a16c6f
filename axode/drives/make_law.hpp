#pragma once
#include <memory>
#include <string_view>

#include "axode/drives/drive_law.hpp"
#include "axode/model/description.hpp"

namespace axode {

/// The value of a parameter of a drive, which is the standard value of its kind if it is not given.
double parameter_of(const DriveDescription& drive, std::string_view name);

/// Makes the law of a drive from its checked description. Parameters that are not given have standard values.
std::shared_ptr<const DriveLaw> make_law(const DriveDescription& drive);

}  // namespace axode
