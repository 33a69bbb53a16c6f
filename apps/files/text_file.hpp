#pragma once
#include <string>

namespace axode::command {

/// The bytes of a file, or of standard input if `file` is "-". Throws InputError if it cannot be read.
std::string read_bytes(const std::string& file);

/// The text of a file, or of standard input if `file` is "-", without a byte order mark. Throws InputError if
/// the file cannot be read, is not UTF-8 or has zero bytes.
std::string read_text(const std::string& file);

/// Replaces the contents of a file by the text, or leaves the file as it was and throws InputError.
///
/// The text is written to a new file in the same folder, which is then renamed. Permissions are kept, the
/// target of a symbolic link is replaced, and a failure or a signal leaves no other file. A device, a pipe
/// and an open file of a process (/dev/stdout) are written directly.
void write_text(const std::string& file, const std::string& text);

}  // namespace axode::command
