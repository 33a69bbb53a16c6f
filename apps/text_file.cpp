#include "text_file.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "commands.hpp"

namespace axode::command {

std::string read_text(const std::string& file) {
  constexpr std::size_t most = std::size_t{256} << 20;  // a device may have no end
  std::string text;
  const auto read = [&](std::istream& stream) {
    for (std::array<char, 65536> block; stream.read(block.data(), block.size()) || stream.gcount() > 0;) {
      text.append(block.data(), static_cast<std::size_t>(stream.gcount()));
      if (text.size() > most) throw InputError(file + ": the file has more than 256 MiB");
    }
    return !stream.bad();
  };
  std::ifstream stream;
  if (file != "-" && !std::filesystem::is_directory(file)) stream.open(file, std::ios::binary);
  if (file == "-" ? !read(std::cin) : !stream.is_open() || !read(stream))
    throw InputError(file + ": the file cannot be read");
  return text;
}

void write_text(const std::string& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) throw InputError(file + ": the file cannot be written");
}

}  // namespace axode::command
