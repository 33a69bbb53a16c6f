#pragma once
#include <string>
#include <string_view>

namespace axode::fmi {

/// The names of the resources of an FMU, which its binary reads.
inline constexpr const char* drawing_resource = "mechanism.toml";
inline constexpr const char* settings_resource = "settings.toml";

/// The token of an FMU with these resources, by which a master and the binary recognise that they mean the
/// same FMU.
std::string token_of(std::string_view drawing, std::string_view settings);

}  // namespace axode::fmi
