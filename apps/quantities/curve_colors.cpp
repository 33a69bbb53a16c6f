#include "apps/quantities/curve_colors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace axode::command {
namespace {

using Color = std::array<double, 3>;  ///< red, green and blue, or hue, saturation and lightness, 0 to 1

/// Bodies of the viewer have eight colours, and five shades of each: changes of hue and of lightness.
constexpr int bodies = 8;
constexpr std::array<std::array<double, 2>, 5> shades{
    {{0, 0}, {0.03, -0.11}, {-0.04, 0.09}, {0.06, -0.17}, {-0.06, -0.05}}};

double linear(double x) { return x < 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4); }
double gamma_encoded(double x) { return x < 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 0.41666) - 0.055; }

/// Hue, saturation and lightness of linear components; these and the rounded exponent above are those of three.js.
Color hsl(const Color& rgb) {
  const auto [low, high] = std::ranges::minmax(rgb);
  const double lightness = (low + high) / 2, delta = high - low;
  if (delta == 0) return {0, 0, lightness};
  const auto largest = static_cast<std::size_t>(std::ranges::max_element(rgb) - rgb.begin());
  const double hue =
      2.0 * static_cast<double>(largest) + (rgb[(largest + 1) % 3] - rgb[(largest + 2) % 3]) / delta;
  return {std::fmod(hue + 6, 6) / 6, delta / (lightness <= 0.5 ? high + low : 2 - high - low), lightness};
}

Color rgb(const Color& hsl) {
  const auto [hue, saturation, lightness] = hsl;
  const double high =
      lightness <= 0.5 ? lightness * (1 + saturation) : lightness + saturation - lightness * saturation;
  const double low = 2 * lightness - high;
  const auto component = [&](double at) {
    const double sixth = 6 * (at - std::floor(at));
    if (sixth < 1) return low + (high - low) * sixth;
    if (sixth < 3) return high;
    return sixth < 4 ? low + (high - low) * (4 - sixth) : low;
  };
  return {component(hue + 1.0 / 3), component(hue), component(hue - 1.0 / 3)};
}

}  // namespace

std::string color_of_body(int body) {
  const std::string_view base = curve_palette[static_cast<std::size_t>((body - 1) % bodies)];
  const auto [hue, lightness] = shades[static_cast<std::size_t>((body - 1) / bodies) % shades.size()];
  if (hue == 0) return std::string(base);
  Color color;
  for (std::size_t c = 0; c < 3; ++c)
    color[c] = linear(std::stoi(std::string(base.substr(1 + 2 * c, 2)), nullptr, 16) / 255.0);
  Color changed = hsl(color);
  changed[0] += hue - std::floor(changed[0] + hue);
  changed[2] = std::clamp(changed[2] + lightness, 0.0, 1.0);
  color = rgb(changed);
  std::string text = "#";
  for (const double c : color)
    text +=
        fmt::format("{:02x}", static_cast<int>(std::lround(255 * std::clamp(gamma_encoded(c), 0.0, 1.0))));
  return text;
}

}  // namespace axode::command
