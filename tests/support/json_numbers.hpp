#pragma once
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

/// Reference values are JSON arrays (of arrays) of decimal strings, with more digits than a double holds.
namespace axode::test {

inline nlohmann::json read_json(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  return nlohmann::json::parse(stream);
}

inline double number(const nlohmann::json& value) {
  return value.is_string() ? std::strtod(value.get_ref<const std::string&>().c_str(), nullptr)
                           : value.get<double>();
}

/// All numbers of an array, rows one after the other.
inline std::vector<double> numbers(const nlohmann::json& array) {
  std::vector<double> all;
  for (const nlohmann::json& entry : array) {
    if (entry.is_array()) {
      for (const double x : numbers(entry)) all.push_back(x);
    } else {
      all.push_back(number(entry));
    }
  }
  return all;
}

}  // namespace axode::test
