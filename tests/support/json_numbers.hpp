#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

/// Reference values are JSON arrays (of arrays) of decimal strings, with more digits than a double holds.
namespace axode::test {

/// A value of a JSON file; the parser is compiled once. Members and entries
/// that do not exist, and values of another kind, throw std::runtime_error.
class Json {
 public:
  const Json& at(const std::string& key) const;
  const Json& at(std::size_t index) const;
  bool contains(const std::string& key) const;
  /// The names of the members of an object, whose values are the entries in this order.
  const std::vector<std::string>& keys() const { return keys_; }
  /// The entries of an array.
  std::size_t size() const { return entries_.size(); }
  auto begin() const { return entries_.begin(); }
  auto end() const { return entries_.end(); }
  bool is_array() const { return is_array_; }
  operator int() const { return std::stoi(text_); }
  operator std::string() const { return text_; }
  /// The text of a string, or the characters of a number as the file has them.
  const std::string& text() const { return text_; }

 private:
  friend Json read_json(const std::filesystem::path& file);
  template <class Parsed> static Json copy_of(const Parsed& value);

  bool is_array_ = false;
  std::string text_;
  std::vector<std::string> keys_;  ///< the names of the members of an object; entries_ has their values
  std::vector<Json> entries_;
};

Json read_json(const std::filesystem::path& file);
double number(const Json& value);
/// All numbers of an array, which may hold arrays itself, row after row.
std::vector<double> numbers(const Json& array);

}  // namespace axode::test
