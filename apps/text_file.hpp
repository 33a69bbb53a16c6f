#pragma once
#include <string>

namespace axode::command {

/// What a file holds, "-" for standard input. Throws InputError where it cannot be read.
std::string read_text(const std::string& file);

/// Replaces what a file holds. Throws InputError where it cannot be written.
void write_text(const std::string& file, const std::string& text);

}  // namespace axode::command
