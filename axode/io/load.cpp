#include <algorithm>
#include <cerrno>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "axode/io.hpp"
#include "axode/io/reading.hpp"
#include "axode/model/builder.hpp"

namespace axode {
namespace {

struct Text {
  std::string content;
  std::vector<Fault> faults;
};

Text text_of(const std::filesystem::path& file) {
  Text text;
  const auto fail = [&](const std::string& why) {
    text.faults.push_back(
        {Severity::error, Rule::unreadable_file, "", "the file cannot be read: " + why, {file.string(), 0}});
  };
  std::error_code unknown;
  if (std::filesystem::is_directory(file, unknown)) {
    fail("it is a folder");
    return text;
  }
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream content;
  if (stream) content << stream.rdbuf();
  text.content = std::move(content).str();
  if (!stream || content.bad()) fail(std::generic_category().message(errno != 0 ? errno : EIO));
  return text;
}

bool is_urdf(const std::filesystem::path& file, const std::string& content) {
  const std::string extension = file.extension().string();
  if (extension == ".toml") return false;
  if (extension == ".urdf" || extension == ".xml") return true;
  const std::size_t first = content.find_first_not_of(" \t\r\n\xEF\xBB\xBF");  // past a byte order mark
  return first != std::string::npos && content[first] == '<';
}

struct File {
  io::Reading reading;
  Physics physics = Physics::strict;
};

File read(const std::filesystem::path& file) {
  Text text = text_of(file);
  if (!text.faults.empty()) {
    File unread;
    unread.reading.description.name = file.filename().string();
    unread.reading.faults = std::move(text.faults);
    return unread;
  }
  if (is_urdf(file, text.content)) return {io::read_urdf(text.content, file.string()), Physics::lenient};
  return {io::read_drawing(text.content, file.string()), Physics::strict};
}

/// The faults of the reader, and those of the mechanism.
std::vector<Fault> all_faults(io::Reading reading, Physics physics) {
  std::vector<Fault> faults = std::move(reading.faults);
  const bool in_part = io::has_error(faults);
  if (!in_part || !reading.description.bodies.empty())
    for (Fault& fault : ModelBuilder(std::move(reading.description)).check(physics))
      if (!in_part || (fault.severity == Severity::error && fault.rule != Rule::missing_name))
        faults.push_back(std::move(fault));
  std::stable_sort(faults.begin(), faults.end(),
                   [](const Fault& a, const Fault& b) { return a.source.line < b.source.line; });
  return faults;
}

}  // namespace

Model io::build(Reading reading, Base base, Physics physics) {
  if (has_error(reading.faults)) {
    const std::string name = reading.description.name;
    throw ModelError(name, all_faults(std::move(reading), physics));
  }
  Description description = accept(std::move(reading));
  if (base == Base::free) description = with_free_base(std::move(description));
  if (base == Base::fixed) description = with_fixed_base(std::move(description));
  return ModelBuilder(std::move(description)).build(physics);
}

Model load(const std::filesystem::path& file, Base base) {
  auto [reading, physics] = read(file);
  return io::build(std::move(reading), base, physics);
}

std::vector<Fault> check(const std::filesystem::path& file) {
  auto [reading, physics] = read(file);
  return all_faults(std::move(reading), physics);
}

}  // namespace axode
