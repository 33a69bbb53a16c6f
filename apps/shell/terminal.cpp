#include "apps/shell/terminal.hpp"

#include <unistd.h>

#include <cstdlib>

namespace axode::command {
namespace {

const char* code(Ink ink) {
  switch (ink) {
    case Ink::heading: return "\033[1m";
    case Ink::faint: return "\033[2m";
    case Ink::good: return "\033[32m";
    case Ink::warning: return "\033[33m";
    case Ink::bad: return "\033[31m";
  }
  return "";
}

bool says(const char* variable, std::string_view value) {
  const char* text = std::getenv(variable);
  return text != nullptr && text == value;
}

bool colours_refused() {
  const char* no_color = std::getenv("NO_COLOR");
  return (no_color != nullptr && *no_color != '\0') || says("TERM", "dumb");
}

}  // namespace

bool is_terminal(std::FILE* stream) { return isatty(fileno(stream)) == 1; }

std::string in(Ink ink, std::string_view text, std::FILE* stream) {
  if (!is_terminal(stream) || colours_refused()) return std::string(text);
  return code(ink) + std::string(text) + "\033[0m";
}

}  // namespace axode::command
