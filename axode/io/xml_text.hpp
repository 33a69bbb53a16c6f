#pragma once
#include <string>
#include <string_view>

#include "axode/lie/vec3.hpp"
#include "axode/model/building/fault.hpp"

/// Functions that convert numbers, vectors and names to texts for attributes of XML.
namespace axode::io::xml {

inline std::string text(double x) { return to_text(x == 0 ? 0.0 : x); }  // -0 becomes 0
inline std::string text(const Vec3<>& a) { return text(a.x) + " " + text(a.y) + " " + text(a.z); }
/// The text with escapes for the characters that an attribute must not contain.
inline std::string text(std::string_view s) {
  std::string out;
  for (const char c : s) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\t': out += "&#9;"; break;
      case '\n': out += "&#10;"; break;
      case '\r': out += "&#13;"; break;
      default: out += c;
    }
  }
  return out;
}

}  // namespace axode::io::xml
