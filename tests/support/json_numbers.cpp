#include "tests/support/json_numbers.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace axode::test {

template <class Parsed> Json Json::copy_of(const Parsed& value) {
  Json out;
  out.is_array_ = value.is_array();
  if (value.is_object())
    for (const auto& [key, entry] : value.items()) out.keys_.push_back(key);
  if (value.is_structured())
    for (const Parsed& entry : value) out.entries_.push_back(copy_of(entry));
  else
    out.text_ = value.is_string() ? value.template get<std::string>() : value.dump();
  return out;
}

Json read_json(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  return Json::copy_of(nlohmann::json::parse(stream));
}

const Json& Json::at(const std::string& key) const {
  const auto found = std::ranges::find(keys_, key);
  if (found == keys_.end()) throw std::runtime_error("no member " + key);
  return entries_[static_cast<std::size_t>(found - keys_.begin())];
}
const Json& Json::at(std::size_t index) const {
  if (!is_array_ || index >= entries_.size())
    throw std::runtime_error("no entry " + std::to_string(index) + " of " + std::to_string(entries_.size()));
  return entries_[index];
}
bool Json::contains(const std::string& key) const { return std::ranges::find(keys_, key) != keys_.end(); }

double number(const Json& value) {
  char* end = nullptr;
  const double x = std::strtod(value.text().c_str(), &end);
  if (value.text().empty() || *end != '\0') throw std::runtime_error("not a number: " + value.text());
  return x;
}

std::vector<double> numbers(const Json& array) {
  std::vector<double> all;
  for (const Json& entry : array) {
    if (entry.is_array()) {
      for (const double x : numbers(entry)) all.push_back(x);
    } else {
      all.push_back(number(entry));
    }
  }
  return all;
}

}  // namespace axode::test
