#include "text_file.hpp"

#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

#include "commands.hpp"

namespace axode::command {

std::string read_text(const std::string& file) {
  std::ostringstream text;
  if (file == "-") {
    text << std::cin.rdbuf();
  } else if (const std::ifstream stream(file, std::ios::binary);
             std::filesystem::is_directory(file) || !stream || (text << stream.rdbuf(), text.bad())) {
    throw InputError(file + ": the file cannot be read");
  }
  return text.str();
}

void write_text(const std::string& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) throw InputError(file + ": the file cannot be written");
}

}  // namespace axode::command
