#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "axode/io.hpp"
#include "axode/io/toml.hpp"
#include "axode/model/builder.hpp"

/// What all readers have in common: the text, its numbers, and what comes of reading it.
namespace axode::io {

/// What a reader has understood. Where there are errors the description is what could be saved: enough to
/// look for further faults, not to build from.
struct Reading {
  Description description;
  std::vector<Fault> faults;
};
Reading read_drawing(std::string_view text, const std::string& file, Strictness strictness);
Reading read_drawing(const toml::Value& drawing, const std::string& file, Strictness strictness);
Reading read_urdf(std::string_view text, const std::string& file, Strictness strictness);
Reading read_sdf(std::string_view text, const std::string& file, Strictness strictness);

/// The name of the first element of an XML text, which need not be well-formed; empty where there is none.
std::string_view root_element(std::string_view text);

/// Mends what can be mended, with a warning for each: limits the wrong way round are none, and a joint that
/// follows one that does not exist moves on its own.
void forgive(Reading& reading);

bool has_error(const std::vector<Fault>& faults);

/// The description with its doubts as warnings. Throws ModelError where there is an error.
Description accept(Reading reading);

/// The mechanism that was read. Throws ModelError with the faults of the reader and those of the mechanism; of
/// one that was understood in part, only errors that do not follow from what is missing. By line.
Model build(Reading reading, Base base, Strictness strictness);

/// Why a file is no text at all: a byte that is zero or not UTF-8, and its line.
std::optional<Fault> not_text(std::string_view text, const std::string& file);

/// Whether a name can stand in a line of text: no control characters.
bool printable(std::string_view name);

/// A decimal number, whatever the locale, or what is wrong with it: the rule and the rest of a sentence that
/// begins with what was read, such as `is not a number`.
struct Number {
  double value = 0;
  std::optional<Rule> broken = {};
  const char* complaint = "";
};
Number number(std::string_view text);

/// `"text"`, cut short where it is long.
std::string in_quotes(std::string_view text);

}  // namespace axode::io
