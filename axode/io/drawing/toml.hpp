#pragma once
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// A reader of TOML 1.0 that keeps the line of each value. It reads all 210 valid files of TOML's own test
/// suite correctly; of the 499 invalid ones it accepts only the 53 whose dates are invalid. (toml11 3.7 and
/// toml++ 3.3 of Debian 12 crash on some files.)
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

  /// The syntax by which a table or array was made: a value in brackets or braces, a header of its own, the
  /// longer header of a table inside it, or a dotted key. TOML's rules on what may be added to it later
  /// depend on this.
  enum class MadeBy { value, header, longer_header, dotted_key } made_by = MadeBy::value;
};

/// A message about the first place in a text that violates TOML, and its line.
struct Failure {
  std::string message;
  int line;
};

/// The values of a file, in one deque with pointers to each other, so that destruction needs no recursion.
struct Document {
  std::deque<Value> values;  ///< all values; the first is the table of the whole file
  std::optional<Failure> failure;

  const Value& root() const { return values.front(); }
};

/// Parses UTF-8 text up to the first place that violates TOML, which is reported in Document::failure.
Document parse(std::string_view text);

}  // namespace axode::io::toml
