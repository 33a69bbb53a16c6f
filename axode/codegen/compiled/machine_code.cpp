#include "axode/codegen/compiled/machine_code.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "axode/codegen/compiled/compiler.hpp"
#include "axode/codegen/compiled/specialised.hpp"

namespace axode {
namespace codegen {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t digits = 32;  // length of a digest; each library in the cache ends with the digest of
                                    // its contents

/// The hash of a text, 128 bits as 32 hexadecimal digits. It is not cryptographic.
std::string digest(std::string_view text) {
  std::uint64_t a = 0xcbf29ce484222325U, b = 0x9e3779b97f4a7c15U ^ text.size();
  for (const char c : text) {
    a = (a ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
    b = (b + static_cast<unsigned char>(c)) * 0xff51afd7ed558ccdU;
    b ^= b >> 29;
  }
  std::array<char, digits + 1> hexadecimal{};
  std::snprintf(hexadecimal.data(), hexadecimal.size(), "%016llx%016llx", static_cast<unsigned long long>(a),
                static_cast<unsigned long long>(b));
  return hexadecimal.data();
}

bool is_key(const std::string& name) {
  return name.size() == digits && name.find_first_not_of("0123456789abcdef") == std::string::npos;
}

std::string contents(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}
void append(const fs::path& file, const std::string& text, std::ios::openmode mode) {
  std::ofstream stream(file, std::ios::binary | mode);
  if (!(stream << text) || !stream.flush()) throw std::runtime_error("cannot write " + file.string());
}

/// A description of the processor, which decides which instructions compiled code may have.
std::string processor() {
  std::ifstream stream("/proc/cpuinfo");
  std::string text;
  for (std::string line; std::getline(stream, line) && !line.empty();)
    if (line.starts_with("model name") || line.starts_with("flags") || line.starts_with("Features"))
      text += line;
  return text;
}

/// The folder of the cache of compiled models; empty if the environment names no folder.
fs::path cache_folder() {
  const char *const base = std::getenv("XDG_CACHE_HOME"), *const home = std::getenv("HOME");
  if (base != nullptr && *base == '/') return fs::path(base) / "axode";
  if (home != nullptr && *home == '/') return fs::path(home) / ".cache" / "axode";
  return {};
}
/// Whether a file or folder belongs to this user, who alone can write to it; only such code is loaded.
bool is_ours(const fs::path& file) {
  struct stat status {};
  return !file.empty() && lstat(file.c_str(), &status) == 0 && !S_ISLNK(status.st_mode) &&
         status.st_uid == geteuid() && (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}
bool is_usable(const fs::path& folder) {
  if (folder.empty()) return false;
  std::error_code failed;
  fs::create_directories(folder.parent_path(), failed);
  if (mkdir(folder.c_str(), S_IRWXU) != 0 && errno != EEXIST) return false;
  return is_ours(folder) && access(folder.c_str(), W_OK | X_OK) == 0;
}

/// A lock in the cache for the source with a given key: the process that holds it compiles this source. The
/// lock is released when the process ends. If the file system has no locks, several processes may compile the
/// same source.
class Lock {
 public:
  Lock(const fs::path& folder, const std::string& key)
      : file_(open((folder / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR)),
        place_(static_cast<off_t>(std::stoull(key.substr(0, 15), nullptr, 16))) {}
  ~Lock() {
    if (file_ >= 0) close(file_);
  }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;
  /// Tries to take the lock. Returns false if another process holds it.
  bool try_it() {
    struct flock range {};
    range.l_type = F_WRLCK;
    range.l_whence = SEEK_SET;
    range.l_start = place_;
    range.l_len = 1;
    is_held_ = file_ >= 0 && fcntl(file_, F_OFD_SETLK, &range) == 0;
    return is_held_ || file_ < 0 || (errno != EAGAIN && errno != EACCES);
  }
  bool is_held() const { return is_held_; }

 private:
  int file_;
  off_t place_;
  bool is_held_ = false;
};

/// A new folder, which the destructor removes.
class WorkFolder {
 public:
  explicit WorkFolder(const fs::path& in, const std::string& name) {
    std::string pattern = in / (name + ".XXXXXX");
    if (mkdtemp(pattern.data()) == nullptr)
      throw std::runtime_error("there is no folder to compile in: " + in.string() + " cannot be written to");
    path_ = pattern;
  }
  ~WorkFolder() {
    std::error_code left;
    fs::remove_all(path_, left);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};
/// The folder for temporary files. Throws std::runtime_error if $TMPDIR is not a folder.
fs::path temporary_folder() {
  std::error_code failed;
  const fs::path folder = fs::temp_directory_path(failed);
  if (!failed) return folder;
  const char* const named = std::getenv("TMPDIR");
  throw std::runtime_error(
      "there is no folder to compile in: the cache cannot be written to, and TMPDIR is \"" +
      std::string(named == nullptr ? "" : named) +
      "\", which is not a folder; set TMPDIR or XDG_CACHE_HOME to a folder that can be written to");
}
/// Moves the abandoned work folders in the cache, which ended processes have left, into `work`, the work
/// folder of this process, which is removed with all that is in it. They are not removed in place, because
/// this could fail while a compiler that outlives its process still creates files there. The name of a work
/// folder begins with the key of the source that is compiled in it, and the compiling process holds the lock
/// of this key. Hence a folder is abandoned if this process holds or can take the lock of its key. `key` and
/// `lock` belong to the source that this process compiles; it may not hold the lock.
void collect_abandoned(const fs::path& cache, const fs::path& work, const std::string& key,
                       const Lock& lock) {
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(cache, failed)) {
    const std::string name = entry.path().stem();
    if (!is_key(name) || !entry.is_directory(failed) || entry.path() == work) continue;
    Lock other(cache, name);
    const bool is_abandoned = name == key ? lock.is_held() : other.try_it() && other.is_held();
    if (is_abandoned) fs::rename(entry.path(), work / entry.path().filename(), failed);
  }
}

using Library = std::shared_ptr<void>;

Library opened(const fs::path& file) {
  void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  return {handle, [](void* library) {
            if (library != nullptr) dlclose(library);
          }};
}
Library opened_from_cache(const fs::path& file) {
  if (!is_ours(file.parent_path()) || !is_ours(file)) return nullptr;
  const std::string all = contents(file);
  const std::string_view text(all);
  if (all.size() <= digits ||
      digest(text.substr(0, text.size() - digits)) != text.substr(text.size() - digits)) {
    std::error_code failed;
    fs::remove(file, failed);
    return nullptr;
  }
  return opened(file);
}

/// The first lines of a compiler's output.
std::string first_lines(const std::string& output) {
  std::istringstream stream(output);
  std::string text;
  int lines = 0;
  for (std::string line; lines < 5 && std::getline(stream, line); ++lines) text += "\n" + line;
  return text;
}

Library compiled(const Compiler& compiler, const std::string& source, const std::vector<std::string>& flags,
                 const fs::path& work, const batch::Monitor& monitor) {
  const fs::path library = work / "model.so";
  append(work / "model.c", source, std::ios::trunc);
  std::vector<std::string> command = compiler.command;
  command.insert(command.end(), {"-x", "c", "-std=gnu99", "-fno-math-errno", "-fno-trapping-math", "-w"});
  command.insert(command.end(), flags.begin(), flags.end());
  command.insert(command.end(), {"-fPIC", "-shared", work / "model.c", "-o", library, "-lm"});
  const std::optional<Finished> finished = run_program(command, work, monitor);
  if (!finished) throw CompilationEnded("the compilation of a specialised model was interrupted");
  if (finished->code != 0)
    throw std::runtime_error("the compiler " + compiler.command[0] +
                             " failed on a specialised model with exit code " +
                             std::to_string(finished->code) + ":" + first_lines(finished->output));
  append(library, digest(contents(library)), std::ios::app);
  const Library loaded = opened(library);
  if (!loaded) throw std::runtime_error(std::string("a specialised model cannot be loaded: ") + dlerror());
  return loaded;
}

}  // namespace

MachineCode::MachineCode(const std::string& source, const std::vector<std::string>& flags,
                         const batch::Monitor& monitor) {
  const Compiler compiler = find_compiler();
  std::string all = compiler.version + '\n' + processor();
  for (const std::vector<std::string>& words : {compiler.command, flags})
    for (const std::string& word : words) all += '\n' + word;
  const std::string key = digest(all + '\n' + source);
  const fs::path folder = cache_folder();
  file_ = folder / (key + ".so");
  library_ = opened_from_cache(file_);
  if (library_) return;
  const auto compile_in = [&](const std::shared_ptr<WorkFolder>& work) {
    library_ = compiled(compiler, source, flags, work->path(), monitor);
    folder_ = work;
  };
  if (!is_usable(folder)) {
    const auto work = std::make_shared<WorkFolder>(temporary_folder(), "axode");
    compile_in(work);
    file_ = work->path() / "model.so";
    return;
  }
  Lock lock(folder, key);
  while (!lock.try_it()) {
    if (monitor && !monitor(0, 1)) throw CompilationEnded("the wait for a specialised model was interrupted");
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  library_ = opened_from_cache(file_);
  if (library_) return;  // another process has compiled it in the meantime
  const auto work = std::make_shared<WorkFolder>(folder, key);
  collect_abandoned(folder, work->path(), key, lock);
  compile_in(work);
  std::error_code failed;
  fs::rename(work->path() / "model.so", file_, failed);
  if (failed)
    file_ = work->path() / "model.so";  // the cache cannot be written: the next process will compile again
  else
    folder_ = nullptr;
}

void* MachineCode::address(const std::string& name) const {
  void* found = dlsym(library_.get(), name.c_str());
  if (found == nullptr)
    throw std::runtime_error("the compiled library " + file_.string() + " has no function " + name +
                             "; remove its folder and specialise the model again");
  return found;
}

}  // namespace codegen

SpecialisedCache specialised_cache() {
  namespace fs = std::filesystem;
  SpecialisedCache cache{codegen::cache_folder()};
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(cache.folder, failed)) {
    if (entry.path().extension() != ".so") continue;
    const std::uintmax_t bytes = entry.file_size(failed);
    if (failed) continue;
    ++cache.models;
    cache.bytes += bytes;
  }
  return cache;
}

void clear_specialised_cache() {
  namespace fs = std::filesystem;
  const fs::path folder = codegen::cache_folder();
  if (!codegen::is_ours(folder)) return;
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, failed)) {
    const std::string key = entry.path().stem();
    if (!codegen::is_key(key)) continue;
    codegen::Lock lock(folder, key);
    if (entry.path().extension() == ".so" || (lock.try_it() && lock.is_held()))
      fs::remove_all(entry.path(), failed);
  }
}

}  // namespace axode
