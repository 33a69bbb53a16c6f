#pragma once
#include <cstdio>
#include <string>
#include <string_view>

namespace axode::command {

enum class Ink { heading, faint, good, warning, bad };

/// The text in a colour, where the stream is a terminal and the environment does not say NO_COLOR.
std::string in(Ink ink, std::string_view text, std::FILE* stream = stdout);

bool is_terminal(std::FILE* stream);

}  // namespace axode::command
