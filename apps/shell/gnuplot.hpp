#pragma once
#include <optional>
#include <string>

namespace axode::command {

/// The result of a run of gnuplot: its exit status, its output, which is the picture, and its messages.
struct GnuplotOutcome {
  int status;
  std::string out, err;
};

/// Runs gnuplot with the script on its standard input, and returns its output; empty if gnuplot is not
/// installed. Throws InputError if no temporary file can be written.
std::optional<GnuplotOutcome> gnuplot(const std::string& script);

}  // namespace axode::command
