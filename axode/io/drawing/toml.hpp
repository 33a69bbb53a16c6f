#pragma once
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// A reader of TOML 1.0 that keeps the line of each value. It is written here because neither library of
/// Debian 12 is sufficient. Of TOML's own test suite for 1.0 (210 valid and 499 invalid files), toml11 3.7
/// refuses two valid files and accepts two invalid ones; it crashes on one file of the suite and on deep
/// nesting. toml++ 3.3 crashes on malformed files and on some valid ones. This reader reads all 210 valid
/// files correctly; of the invalid files it accepts only the 53 whose dates are invalid.
namespace axode::io::toml {

struct Value;

struct Date {};  ///< a date or a time of day; no key of a drawing has such a value
using Array = std::vector<Value*>;
struct Entry {
  int line;  ///< line of the key
  Value* value;
};
using Table = std::map<std::string, Entry, std::less<>>;

struct Value {
  std::variant<Table, Array, std::string, double, bool, Date> content;
  int line = 1;

  const Table* table() const { return std::get_if<Table>(&content); }
  const Array* array() const { return std::get_if<Array>(&content); }
  const std::string* text() const { return std::get_if<std::string>(&content); }
  const double* number() const { return std::get_if<double>(&content); }
  const bool* flag() const { return std::get_if<bool>(&content); }

  /// The syntax that made a table or array: a value in brackets or braces, its own header, the longer header
  /// of a table in it, or a dotted key. The syntax decides what may be added to the table or array later.
  enum class MadeBy { value, header, longer_header, dotted_key } made_by = MadeBy::value;
};

/// A message about the first place in a text that violates TOML, and its line.
struct Failure {
  std::string message;
  int line;
};

/// The values of a file. All values are stored in one deque and refer to each other by pointers, so that
/// destroying a deeply nested value needs no recursion.
struct Document {
  std::deque<Value> values;  ///< all values; the first is the table of the whole file
  std::optional<Failure> failure;

  const Value& root() const { return values.front(); }
};

/// Parses UTF-8 text. It stops at the first place that violates TOML and sets Document::failure; `values`
/// then has what was read before.
Document parse(std::string_view text);

}  // namespace axode::io::toml
