#pragma once
#include <optional>
#include <string_view>

namespace axode::io {

/// What no TOML holds, and what toml++ 3.3 does not survive: it is looked for before the text is parsed.
struct Stray {
  const char* what;
  int line;
};

/// The first character beyond ASCII outside texts and comments, header without a key, or line with so many dots that
/// its keys would nest too deep (a.a.a...). Stops without a finding where a text does not end: the parser says so.
std::optional<Stray> find_stray(std::string_view text);

}  // namespace axode::io
