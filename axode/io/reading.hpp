#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "axode/io.hpp"
#include "axode/io/drawing/toml.hpp"
#include "axode/model/building/builder.hpp"

/// Parts that all readers share: checks of texts and names, numbers, and the result of reading.
namespace axode::io {

/// The result of a reader. If there are errors, the description is incomplete: it can be searched for further
/// faults, but no model can be built from it.
struct Reading {
  Description description;
  std::vector<Fault> faults;
};
/// The readers of the text of a drawing, of a parsed drawing, of a URDF and of an SDF file. `file` is the
/// name of the file in messages.
Reading read_drawing(std::string_view text, const std::string& file, Strictness strictness);
Reading read_drawing(const toml::Value& drawing, const std::string& file, Strictness strictness);
Reading read_urdf(std::string_view text, const std::string& file, Strictness strictness);
Reading read_sdf(std::string_view text, const std::string& file, Strictness strictness);

/// The name of the first element of an XML text, which need not be well-formed; empty if there is none.
std::string_view root_element(std::string_view text);

/// Corrects the defects that a lenient reader accepts, with a warning for each: crossed limits are removed,
/// and a joint that follows one which does not exist moves on its own.
void forgive(Reading& reading);

/// Whether one of the faults is an error, not a warning.
bool has_error(const std::vector<Fault>& faults);

/// The description, with the faults of the reader as its warnings. Throws ModelError if one of them is an
/// error.
Description accept(Reading reading);

/// Builds the mechanism that was read. Throws ModelError with the faults of the reader and of the mechanism,
/// sorted by line. If the reader has found errors, warnings about the mechanism and faults about missing
/// names are left out, because they may be consequences of what could not be read.
Model build(Reading reading, Base base, Strictness strictness);

/// The fault of a file that is not text because a byte is zero or not UTF-8, with its line; empty if it is
/// text.
std::optional<Fault> not_text(std::string_view text, const std::string& file);

/// Whether a name has no control characters, so that it can be printed in a line of text.
bool printable(std::string_view name);

/// A decimal number, read independently of the locale. If it is wrong, `broken` is the rule that it violates
/// and `complaint` the predicate of a sentence about the text, such as `is not a number`.
struct Number {
  double value = 0;
  std::optional<Rule> broken = {};
  const char* complaint = "";
};
Number number(std::string_view text);

/// `"text"`: the text in quotes, with blanks instead of control characters, and cut if it is longer than 60
/// bytes.
std::string in_quotes(std::string_view text);

}  // namespace axode::io
