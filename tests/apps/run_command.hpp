#pragma once
#include <pty.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/run_program.hpp"

/// Runs the command `axode` as a user does: with arguments, and with its output and exit code as the result.
namespace axode::test {

inline Outcome axode(std::vector<std::string> arguments, const std::string& input = "") {
  arguments.insert(arguments.begin(), AXODE_COMMAND);
  return run(arguments, input);
}

/// The output of the command when it writes to a terminal.
inline std::string axode_on_a_terminal(std::vector<std::string> arguments, const std::string& no_color,
                                       const char* term = "xterm") {
  arguments.insert(arguments.begin(), AXODE_COMMAND);
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, nullptr);
  if (child < 0) throw std::runtime_error("no terminal");
  if (child == 0) {
    setenv("TERM", term, 1);
    setenv("NO_COLOR", no_color.c_str(), 1);
    detail::become(arguments);
  }
  std::string text;
  std::array<char, 4096> buffer;
  for (ssize_t n; (n = read(terminal, buffer.data(), buffer.size())) > 0;) text.append(buffer.data(), n);
  close(terminal);
  detail::exit_code_of(child);
  return text;
}

}  // namespace axode::test
