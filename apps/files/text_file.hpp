#pragma once
#include <string>

namespace axode::command {

/// The bytes of a file, or of standard input if `file` is "-". Throws InputError if it cannot be read.
std::string read_bytes(const std::string& file);

/// The text of a file, or of standard input if `file` is "-", without a byte order mark. Throws InputError if
/// the file cannot be read, is not UTF-8 or has zero bytes.
std::string read_text(const std::string& file);

/// Replaces the contents of a file by the text. Throws InputError if this fails.
///
/// A regular file is unchanged after a failure, because the text is written to a new file in the same folder,
/// which is then renamed. Permissions are kept. If `file` is a symbolic link, its target is replaced. After a
/// failure or a signal no new file remains. A device, a pipe and an open file of a process (/dev/stdout) are
/// written directly, so that a failure may leave a part of the text in them.
void write_text(const std::string& file, const std::string& text);

}  // namespace axode::command
