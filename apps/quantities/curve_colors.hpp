#pragma once
#include <array>
#include <string>
#include <string_view>

/// Colours of curves, which are those of the viewer (viewer/src/palette.ts).
namespace axode::command {

/// The first eight have the hues of the colours of bodies in the viewer, in their order.
inline constexpr std::array<std::string_view, 10> curve_palette{"#3b82c4", "#d9a21b", "#2f9e58", "#d05a3a",
                                                                "#7d63c9", "#1795a3", "#d66fb0", "#8a9a22",
                                                                "#5f6b76", "#8c5a2f"};

/// The colour of the curves of body i > 0: the same for two bodies only if their numbers are equal modulo 40.
std::string color_of_body(int body);

}  // namespace axode::command
