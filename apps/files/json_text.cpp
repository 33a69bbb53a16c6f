#include "apps/files/json_text.hpp"

#include <algorithm>

namespace axode::command {
namespace {

constexpr std::size_t longest_line = 100;  // largest length of an object on one line; arrays of numbers may
                                           // be longer

std::string on_one_line(const Json& value) {
  if (!value.is_structured()) return value.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string out = value.is_object() ? "{" : "[";
  const char* separator = "";
  for (const auto& [key, entry] : value.items()) {
    out += separator;
    if (value.is_object()) out += on_one_line(key) + ": ";
    out += on_one_line(entry);
    separator = ", ";
  }
  out += value.is_object() ? '}' : ']';
  return out;
}

bool has_object(const Json& value) {
  return value.is_object() || (value.is_array() && std::any_of(value.begin(), value.end(), has_object));
}

void append(const Json& value, std::size_t indent, std::string& out) {
  const bool flat = std::none_of(value.begin(), value.end(), has_object);
  const std::string line = flat || !value.is_structured() ? on_one_line(value) : "";
  if (!line.empty() && (!value.is_object() || (indent > 0 && line.size() <= longest_line))) {
    out += line;
    return;
  }
  const std::string margin(indent + 2, ' ');
  const char* separator = "\n";
  out += value.is_object() ? '{' : '[';
  for (const auto& [key, entry] : value.items()) {
    out += separator;
    out += margin;
    if (value.is_object()) out += on_one_line(key) + ": ";
    append(entry, indent + 2, out);
    separator = ",\n";
  }
  out += '\n';
  out.append(indent, ' ');
  out += value.is_object() ? '}' : ']';
}

}  // namespace

Json to_json(const Vec3<>& a) { return {a.x, a.y, a.z}; }

Json to_json(const Sym3<>& A) { return {A.xx, A.yy, A.zz, A.xy, A.xz, A.yz}; }

Json to_json(const SE3<>& C) {
  const auto& [R, r] = C;
  return {{R.x.x, R.y.x, R.z.x, r.x},
          {R.x.y, R.y.y, R.z.y, r.y},
          {R.x.z, R.y.z, R.z.z, r.z},
          {0.0, 0.0, 0.0, 1.0}};
}

std::string text(const Json& value) {
  std::string out;
  append(value, 0, out);
  return out + "\n";
}

}  // namespace axode::command
