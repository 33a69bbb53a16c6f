#pragma once
#include <string>
#include <string_view>

namespace axode::fmi {

/// File names of the resources of an FMU: the mechanism and the settings, which the binary reads.
inline constexpr const char* drawing_resource = "mechanism.toml";
inline constexpr const char* settings_resource = "settings.toml";

/// The token of an FMU, a hash of the contents of its resources. The master passes the token of
/// modelDescription.xml to the binary, which compares it with that of the resources that it reads.
std::string token_of(std::string_view drawing, std::string_view settings);

}  // namespace axode::fmi
