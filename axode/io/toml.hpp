#pragma once
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// TOML 1.0, read into values that know their lines. Written here because neither library of Debian 12 would do: of
/// TOML's own test suite for 1.0 (210 valid and 499 invalid files) toml11 3.7 refuses two valid files, accepts two
/// invalid ones and crashes on one, and on deep nesting; toml++ 3.3 does not survive malformed files, nor some valid
/// ones. This one reads all 210 as they are meant, and accepts of the others only the 53 whose dates are none.
namespace axode::io::toml {

struct Value;

struct Date {};  ///< a date or a time of day; nothing in a drawing is one
using Array = std::vector<Value*>;
struct Entry {
  int line;  ///< of the key
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

  /// What made a table or array, which decides what may be added to it later on.
  enum class MadeBy { value, header, longer_header, dotted_key } made_by = MadeBy::value;
};

struct Failure {
  std::string message;
  int line;
};

/// The values of a file. They are held side by side, so that no depth of nesting costs stack.
struct Document {
  std::deque<Value> values;  ///< the first is the table that the file is
  std::optional<Failure> failure;

  const Value& root() const { return values.front(); }
};

/// Reads UTF-8 text; stops at the first thing that is not TOML.
Document parse(std::string_view text);

}  // namespace axode::io::toml
