#pragma once
#include <cmath>
#include <string>

#include "axode/lie/vec3.hpp"
#include "axode/model/building/fault.hpp"

namespace axode {

/// A number for a message, rounded to four decimals.
inline std::string rounded_text(double x) { return to_text(std::round(1e4 * x) / 1e4 + 0.0); }
/// A vector for a message, each component rounded to four decimals.
inline std::string rounded_text(const Vec3<>& a) {
  std::string out = "(";
  for (const double x : {a.x, a.y, a.z}) {
    if (out.size() > 1) out += ", ";
    out += rounded_text(x);
  }
  return out += ')';
}

}  // namespace axode
