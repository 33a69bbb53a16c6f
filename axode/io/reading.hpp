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
/// is incomplete, and no model can be built from it.
struct Reading {
  Description description;
  std::vector<Fault> faults;
};
/// The readers of the formats: text or tables of a drawing (TOML), URDF, SDF. Messages name the `file`.
Reading read_drawing(std::string_view text, const std::string& file, Strictness strictness);
Reading read_drawing(const toml::Value& drawing, const std::string& file, Strictness strictness);
Reading read_urdf(std::string_view text, const std::string& file, Strictness strictness);
Reading read_sdf(std::string_view text, const std::string& file, Strictness strictness);

/// The name of the first element of an XML text, which need not be well-formed; empty if there is none.
std::string_view root_element(std::string_view text);

/// Corrects defects, with warnings: limits are removed if the lower one is above the upper one, and a coupled
/// joint whose leader does not exist gets a coordinate of its own.
void forgive(Reading& reading);

/// Whether one of the faults is an error, not a warning.
bool has_error(const std::vector<Fault>& faults);

/// The description that a reader has made, with its warnings. Throws ModelError if the reader found an error.
Description accept(Reading reading);

/// Builds a model from the result of a reader. `base` chooses the joint between the base and the ground.
/// Throws ModelError with the faults of the reader and of the description if there is an error; faults that
/// may be consequences of an incomplete reading are left out.
Model build(Reading reading, Base base, Strictness strictness);

/// A fault with its line if a file is not text: it has zero bytes or is not UTF-8; otherwise empty.
std::optional<Fault> not_text(std::string_view text, const std::string& file);

/// Whether a character is one of ASCII's control characters.
bool is_control(char c);

/// Whether a name has no control characters, so that it can be printed in a line of text.
bool printable(std::string_view name);

/// A decimal number that was read from a text. If the text is not a finite double, `broken` is the rule under
/// which the fault is reported: wrong_value, or non_finite_number for an infinity or NaN. `complaint` says
/// what is wrong, as the end of a sentence about the text: `is not a number`.
struct Number {
  double value = 0;
  std::optional<Rule> broken = {};
  const char* complaint = "";
};
Number number(std::string_view text);

/// The text in quotes, with blanks for control characters and cut after 60 bytes.
std::string in_quotes(std::string_view text);

}  // namespace axode::io
