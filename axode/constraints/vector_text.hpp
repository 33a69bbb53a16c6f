#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "axode/lie/vec3.hpp"
#include "axode/model/building/fault.hpp"

namespace axode {

/// Text of a number for a message, rounded to four decimals.
inline std::string rounded_text(double x) { return to_text(std::round(1e4 * x) / 1e4 + 0.0); }
/// Text "(x, y, z)" of a vector for a message, each component rounded to four decimals.
inline std::string rounded_text(const Vec3<>& a) {
  std::string out = "(";
  for (const double x : {a.x, a.y, a.z}) {
    if (out.size() > 1) out += ", ";
    out += rounded_text(x);
  }
  return out += ')';
}

/// Entries of a null vector are named in a message if they are larger than this fraction of its largest
/// entry.
inline constexpr double considerable = 0.1;
/// The names, each in quotes, separated by commas and, before the last one, by "and".
inline std::string listed(const std::vector<std::string>& names) {
  std::string all;
  for (std::size_t k = 0; k < names.size(); ++k)
    all += (k == 0 ? "" : k + 1 == names.size() ? " and " : ", ") + ('"' + names[k] + '"');
  return all;
}

}  // namespace axode
