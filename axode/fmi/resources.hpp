#pragma once
#include <string>
#include <string_view>

namespace axode::fmi {

/// File names of the resources of an FMU: the mechanism and the settings, which the binary reads.
inline constexpr const char* drawing_resource = "mechanism.toml";
inline constexpr const char* settings_resource = "settings.toml";

/// The token of an FMU, a hash by which the binary checks that resources and description belong together.
std::string token_of(std::string_view drawing, std::string_view settings);

}  // namespace axode::fmi
