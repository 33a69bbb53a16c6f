#pragma once
#include <cstdio>
#include <string>
#include <string_view>

namespace axode::command {

enum class Ink { heading, faint, good, warning, bad };

/// The text, in the colour for `ink` if the stream is a terminal and the variable NO_COLOR is not set.
std::string in(Ink ink, std::string_view text, std::FILE* stream = stdout);

bool is_terminal(std::FILE* stream);

}  // namespace axode::command
