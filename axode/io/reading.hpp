#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "axode/io.hpp"
#include "axode/io/drawing/toml.hpp"
#include "axode/model/building/builder.hpp"

/// Declarations that all readers share: the result of reading, checks of texts and names, and numbers.
namespace axode::io {

/// The result of a reader: a description and the faults of the file. If a fault is an error, the description
/// is incomplete; it can be checked for further faults, but no model can be built from it.
struct Reading {
  Description description;
  std::vector<Fault> faults;
};
/// The readers of the file formats. They take the text of a drawing (TOML), a parsed drawing, the text of a
/// URDF, or the text of an SDF file. `file` is the name of the file in messages.
Reading read_drawing(std::string_view text, const std::string& file, Strictness strictness);
Reading read_drawing(const toml::Value& drawing, const std::string& file, Strictness strictness);
Reading read_urdf(std::string_view text, const std::string& file, Strictness strictness);
Reading read_sdf(std::string_view text, const std::string& file, Strictness strictness);

/// The name of the first element of an XML text, which need not be well-formed; empty if there is none.
std::string_view root_element(std::string_view text);

/// Corrects defects that a lenient reader accepts, with a warning for each: limits whose lower one is above
/// the upper one are removed, and a coupled joint whose leader does not exist gets a coordinate of its own.
void forgive(Reading& reading);

/// Whether one of the faults is an error, not a warning.
bool has_error(const std::vector<Fault>& faults);

/// Returns the description that a reader has made, with the warnings of the reader in it. Throws ModelError
/// if the reader has found an error.
Description accept(Reading reading);

/// Builds a model from the result of a reader, with the joint between base and ground that `base` chooses.
/// Throws ModelError if there is an error. If the reader has found errors, the exception has the faults of
/// the reader and of the description, sorted by line, but no warnings about the description and no faults
/// about missing names, because they may follow from what could not be read.
Model build(Reading reading, Base base, Strictness strictness);

/// Returns a fault with its line if a file is not text, because it has a byte that is zero or not UTF-8;
/// otherwise the result is empty.
std::optional<Fault> not_text(std::string_view text, const std::string& file);

/// Whether a name has no control characters, so that it can be printed in a line of text.
bool printable(std::string_view name);

/// The result of reading a decimal number, independently of the locale. If the text is no finite number of
/// type double, `broken` is the rule that it violates, and `complaint` is the predicate of a sentence about
/// the text, such as `is not a number`.
struct Number {
  double value = 0;
  std::optional<Rule> broken = {};
  const char* complaint = "";
};
Number number(std::string_view text);

/// Returns the text in quotes for a message, with blanks instead of control characters. A text of more than
/// 60 bytes is cut and ends in `...`.
std::string in_quotes(std::string_view text);

}  // namespace axode::io
