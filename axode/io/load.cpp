#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "axode/io.hpp"
#include "axode/io/reading.hpp"
#include "axode/model/building/builder.hpp"

namespace axode {
namespace {

struct Text {
  std::string content;
  std::vector<Fault> faults;
};

/// The contents of a file or, if it cannot be read, a fault with the reason.
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
  constexpr std::size_t most = std::size_t{256} << 20;  // needed because the data of a device may never end
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  const bool opened = stream.good();
  for (std::array<char, 65536> block;
       opened && (stream.read(block.data(), block.size()) || stream.gcount() > 0);) {
    text.content.append(block.data(), static_cast<std::size_t>(stream.gcount()));
    if (text.content.size() > most) {
      fail("it has more than 256 MiB");
      return text;
    }
  }
  if (!opened || stream.bad()) fail(std::generic_category().message(errno != 0 ? errno : EIO));
  return text;
}

using Reader = io::Reading (*)(std::string_view text, const std::string& file, Strictness strictness);

io::Reading read_drawing(std::string_view text, const std::string& file, Strictness strictness) {
  return io::read_drawing(text, file, strictness);
}

/// A reader for MJCF, which only returns a fault that says how to load the file by MuJoCo.
io::Reading refuse_mjcf(std::string_view text, const std::string& file, Strictness) {
  const auto line =
      1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.find("<mujoco")), '\n');
  io::Reading unread;
  unread.faults.push_back(
      {Severity::error,
       Rule::syntax,
       "",
       "the file is MJCF, which is read by MuJoCo itself: load it in Python with axode.load, "
       "and write axode.drawing of it",
       {file, static_cast<int>(line)}});
  return unread;
}

/// Chooses the reader of a file by the ending of its name or, if the ending is not known, by the root element
/// if the content is XML. All other texts are read as drawings, the library's text format (TOML) for
/// mechanisms.
Reader reader_for(const std::filesystem::path& file, std::string_view content) {
  const std::string extension = file.extension().string();
  if (extension == ".toml") return read_drawing;
  if (extension == ".urdf") return io::read_urdf;
  if (extension == ".sdf" || extension == ".world") return io::read_sdf;
  const std::string_view root = io::root_element(content);
  if (root == "sdf") return io::read_sdf;
  if (root == "mujoco") return refuse_mjcf;
  const std::size_t first = content.find_first_not_of(" \t\r\n\xEF\xBB\xBF");  // skips a byte order mark
  const bool is_xml = extension == ".xml" || (first != std::string_view::npos && content[first] == '<');
  return is_xml ? io::read_urdf : read_drawing;
}

io::Reading read(const std::filesystem::path& file, Strictness strictness) {
  Text text = text_of(file);
  if (!text.faults.empty()) {
    io::Reading unread;
    unread.description.name = file.filename().string();
    unread.faults = std::move(text.faults);
    return unread;
  }
  return reader_for(file, text.content)(text.content, file.string(), strictness);
}

/// Returns the description with the joint between base and ground that `base` chooses.
Description held(Description description, Base base) {
  if (base == Base::free) return with_free_base(std::move(description));
  if (base == Base::fixed) return with_fixed_base(std::move(description));
  return description;
}

/// The faults that the reader of a file found, and those of the description of the mechanism that it read
/// from the file, sorted by line. If the reader found an error, the description is incomplete. Then warnings
/// about the description and errors about missing names are left out, because they may be consequences of
/// this error.
std::vector<Fault> all_faults(io::Reading reading, Base base, Strictness strictness) {
  std::vector<Fault> faults = std::move(reading.faults);
  const bool in_part = io::has_error(faults);
  if (!in_part) {
    try {
      reading.description = held(reading.description, base);
    } catch (const ModelError& error) {
      faults.insert(faults.end(), error.faults().begin(), error.faults().end());
    }
  }
  if (!in_part || !reading.description.bodies.empty())
    for (Fault& fault : ModelBuilder(std::move(reading.description)).check(strictness))
      if (!in_part || (fault.severity == Severity::error && fault.rule != Rule::missing_name))
        faults.push_back(std::move(fault));
  std::stable_sort(faults.begin(), faults.end(),
                   [](const Fault& a, const Fault& b) { return a.source.line < b.source.line; });
  return faults;
}

}  // namespace

Model io::build(Reading reading, Base base, Strictness strictness) {
  if (has_error(reading.faults)) {
    const std::string name = reading.description.name;
    throw ModelError(name, all_faults(std::move(reading), base, strictness));
  }
  return ModelBuilder(held(accept(std::move(reading)), base)).build(strictness);
}

Model load(const std::filesystem::path& file, Base base, Strictness strictness) {
  return io::build(read(file, strictness), base, strictness);
}

std::vector<Fault> check(const std::filesystem::path& file, Base base, Strictness strictness) {
  return all_faults(read(file, strictness), base, strictness);
}

}  // namespace axode
