#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "axode/batch.hpp"

/// Runs the C compiler of this machine, without a shell.
namespace axode::codegen {

struct Compiler {
  std::vector<std::string> command;  ///< path of the compiler, and its first arguments
  std::string version;               ///< the output of --version
};
/// The first of $CC, cc, clang and gcc that can be run. Throws std::runtime_error if none of them can.
Compiler find_compiler();

struct Finished {
  int code;            ///< exit code, or 128 + n if signal n ended the program
  std::string output;  ///< the first kilobytes of standard output and standard error
};
/// Runs a program to its end and returns its exit code and the beginning of its output. The program writes
/// temporary files to `folder` or, if this is empty, to the default folder for temporary files. The monitor,
/// a function of the caller, is called repeatedly; if it returns false, the program and all processes that it
/// has started are killed, and the result is std::nullopt.
std::optional<Finished> run_program(const std::vector<std::string>& command,
                                    const std::filesystem::path& folder, const batch::Monitor& monitor = {});

}  // namespace axode::codegen
