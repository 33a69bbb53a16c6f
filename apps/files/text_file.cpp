#include "apps/files/text_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <string_view>

#include "apps/shell/commands.hpp"
#include "axode/io/reading.hpp"

namespace axode::command {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& file, const std::string& why) {
  throw InputError(file + ": the file cannot be written: " + why);
}
/// A file as messages name it.
std::string named(const std::string& file) { return file == "-" ? "standard input" : file; }
std::string reason(int error) { return std::strerror(error); }

fs::path folder_of(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : "."; }

/// The file that is to be replaced to write to `file`: the one to which symbolic links lead, which need not
/// exist. Empty if the file must be written directly, because it is a device or a pipe, or a link in /proc to
/// an open file of a process.
std::optional<fs::path> replaceable(fs::path file) {
  constexpr int most_links = 40;  // the limit of Linux
  std::error_code failed;
  const fs::file_status status = fs::status(file, failed);
  if (fs::exists(status) && !fs::is_regular_file(status)) return std::nullopt;
  for (int links = 0; links < most_links && fs::is_symlink(file, failed); ++links) {
    const fs::path folder = fs::canonical(folder_of(file), failed);
    if (folder.string().starts_with("/proc/")) return std::nullopt;
    file = folder / fs::read_symlink(file, failed);
  }
  return file;
}

/// Blocks signals while the object exists: those that would end the program before a file is complete, and
/// SIGXFSZ, the signal of a file that exceeds its size limit, which is reported as an error instead.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigemptyset(&ending_);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
      struct sigaction action {};
      if (sigaction(signal, nullptr, &action) == 0 && action.sa_handler != SIG_IGN)
        sigaddset(&ending_, signal);
    }
    sigset_t blocked = ending_;
    sigaddset(&blocked, SIGXFSZ);
    pthread_sigmask(SIG_BLOCK, &blocked, &before_);
  }
  ~BlockedSignals() {
    sigset_t too_large;
    sigemptyset(&too_large);
    sigaddset(&too_large, SIGXFSZ);
    const timespec at_once{};
    sigtimedwait(&too_large, nullptr, &at_once);
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;
  /// Whether a blocked signal has come that will end the program.
  bool end_is_pending() const {
    sigset_t pending, both;
    sigpending(&pending);
    sigandset(&both, &pending, &ending_);
    return sigisemptyset(&both) == 0;
  }

 private:
  sigset_t ending_{}, before_{};
};

/// Writes the text to an open file, until ended() is true. Returns 0 or the error number of the system.
template <class Ended> int write_all(int descriptor, std::string_view text, const Ended& ended) {
  constexpr std::size_t block = std::size_t{1} << 20;
  while (!text.empty()) {
    if (ended()) return EINTR;
    const ssize_t n = write(descriptor, text.data(), std::min(text.size(), block));
    if (n < 0 && errno != EINTR) return errno;
    if (n > 0) text.remove_prefix(static_cast<std::size_t>(n));
  }
  return 0;
}

void write_directly(const std::string& file, std::string_view text) {
  const int descriptor = open(file.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC);
  if (descriptor < 0) refuse(file, reason(errno));
  int error = write_all(descriptor, text, [] { return false; });
  if (close(descriptor) != 0 && error == 0) error = errno;
  if (error != 0) refuse(file, reason(error));
}

/// Gives an open file the owner, group and permissions of the file `of`, as far as the user may do so.
void take_permissions(int descriptor, const struct stat& of) {
  [[maybe_unused]] const int owner = fchown(descriptor, of.st_uid, static_cast<gid_t>(-1)),
                             group = fchown(descriptor, static_cast<uid_t>(-1), of.st_gid),
                             mode = fchmod(descriptor, of.st_mode & 07777);
}

void write_beside(const std::string& named, const fs::path& file, std::string_view text) {
  struct stat before {};
  const bool exists = stat(file.c_str(), &before) == 0;
  if (exists && access(file.c_str(), W_OK) != 0) refuse(named, reason(errno));
  const BlockedSignals signals;
  std::string temporary = folder_of(file) / ".axode-XXXXXX";
  const int descriptor = mkostemp(temporary.data(), O_CLOEXEC);
  if (descriptor < 0)
    refuse(named, "no file can be made in " + folder_of(file).string() + ": " + reason(errno));
  if (exists) {
    take_permissions(descriptor, before);
  } else {
    const mode_t mask = umask(0);
    umask(mask);
    [[maybe_unused]] const int mode = fchmod(descriptor, 0666 & ~mask);
  }
  int error = write_all(descriptor, text, [&signals] { return signals.end_is_pending(); });
  if (error == 0 && fsync(descriptor) != 0 && errno != EINVAL) error = errno;
  if (close(descriptor) != 0 && error == 0) error = errno;
  if (error == 0 && rename(temporary.c_str(), file.c_str()) != 0) error = errno;
  if (error == 0) return;
  unlink(temporary.c_str());
  refuse(named, reason(error));
}

}  // namespace

std::string read_bytes(const std::string& file) {
  constexpr std::size_t most = std::size_t{256} << 20;  // a device may have no end
  std::string text;
  const auto fail = [&](const std::string& why) {
    throw InputError(named(file) + ": the file cannot be read: " + why);
  };
  const auto read = [&](std::istream& stream) {
    for (std::array<char, 65536> block; stream.read(block.data(), block.size()) || stream.gcount() > 0;) {
      text.append(block.data(), static_cast<std::size_t>(stream.gcount()));
      if (text.size() > most) fail("it has more than 256 MiB");
    }
    return !stream.bad();
  };
  std::error_code unknown;
  if (file != "-" && fs::is_directory(file, unknown)) fail("it is a folder");
  errno = 0;
  std::ifstream stream;
  if (file != "-") stream.open(file, std::ios::binary);
  if (file == "-" ? !read(std::cin) : !stream.is_open() || !read(stream)) fail(reason(errno));
  return text;
}

std::string read_text(const std::string& file) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  std::string text = read_bytes(file);
  if (const std::optional<Fault> fault = io::not_text(text, file))
    throw InputError(named(file) + ":" + std::to_string(fault->source.line) + ": " + fault->message);
  if (text.starts_with(byte_order_mark)) text.erase(0, byte_order_mark.size());
  return text;
}

void write_text(const std::string& file, const std::string& text) {
  if (const std::optional<fs::path> there = replaceable(file)) {
    write_beside(file, *there, text);
  } else {
    write_directly(file, text);
  }
}

}  // namespace axode::command
