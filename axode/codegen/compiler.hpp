#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "axode/batch.hpp"

/// The C compiler of this machine, run without a shell.
namespace axode::codegen {

struct Compiler {
  std::vector<std::string> command;  ///< a program and its first arguments
  std::string version;               ///< what it says of itself
};
/// The first of $CC, cc, clang and gcc that is there. Throws std::runtime_error where none is.
Compiler find_compiler();

struct Finished {
  int code;            ///< 128 and more where a signal ended it
  std::string output;  ///< its first kilobytes, of both kinds
};
/// Runs a program to its end. Its temporary files go into that folder, or where they usually go if it is
/// empty. Where the monitor says so, it is killed with all that it has started, and the result is nothing.
std::optional<Finished> run_program(const std::vector<std::string>& command,
                                    const std::filesystem::path& folder, const batch::Monitor& monitor = {});

}  // namespace axode::codegen
