#include "axode/codegen/compiled/compiler.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <map>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <system_error>

namespace axode::codegen {
namespace {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

bool can_be_run(const std::filesystem::path& file) {
  std::error_code none;
  return std::filesystem::is_regular_file(file, none) && access(file.c_str(), X_OK) == 0;
}
/// The path of a program on the PATH, or an empty text if there is none that can be run.
std::string found_on_path(const std::string& program) {
  if (program.find('/') != std::string::npos) return can_be_run(program) ? program : "";
  std::istringstream folders(environment("PATH"));
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path file = std::filesystem::path(folder) / program;
    if (!folder.empty() && can_be_run(file)) return file;
  }
  return "";
}

/// A file descriptor, which is closed by the destructor.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }

 private:
  int number_;
};

void check(int error, const std::string& what) {
  if (error != 0) throw std::system_error(error, std::generic_category(), what);
}

/// Starts a program in a process group of its own. Its output goes to the descriptor `output`, and its
/// temporary files into `folder` unless that is empty.
pid_t spawned(const std::vector<std::string>& command, const std::filesystem::path& folder, int output) {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    const bool replaced = text.starts_with("LC_ALL=") || (text.starts_with("TMPDIR=") && !folder.empty());
    if (!replaced) variables.emplace_back(text);
  }
  if (!folder.empty()) variables.push_back("TMPDIR=" + folder.string());
  variables.emplace_back("LC_ALL=C");
  const auto pointers = [](const std::vector<std::string>& texts) {
    std::vector<char*> all;
    for (const std::string& text : texts) all.push_back(const_cast<char*>(text.c_str()));
    all.push_back(nullptr);
    return all;
  };
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  check(posix_spawn_file_actions_init(&actions), command[0]);
  check(posix_spawnattr_init(&attributes), command[0]);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output, STDERR_FILENO);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  pid_t process = 0;
  const int error = posix_spawn(&process, command[0].c_str(), &actions, &attributes, pointers(command).data(),
                                pointers(variables).data());
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  check(error, command[0] + " cannot be run");
  return process;
}

/// The exit code of a process, or 128 + n if signal n ended it; empty while it runs. It is 0 if the code is
/// not available, because SIGCHLD is ignored.
std::optional<int> exit_code(pid_t process, int options) {
  int status = 0;
  pid_t ended = 0;
  do ended = waitpid(process, &status, options);
  while (ended < 0 && errno == EINTR);
  if (ended == 0) return std::nullopt;
  if (ended < 0) return 0;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

std::optional<Finished> run_program(const std::vector<std::string>& command,
                                    const std::filesystem::path& folder, const batch::Monitor& monitor) {
  constexpr std::size_t longest_output = 4000;
  std::array<int, 2> ends{};
  check(pipe2(ends.data(), O_CLOEXEC) == 0 ? 0 : errno, command[0]);
  Descriptor reader(ends[0]), writer(ends[1]);
  const pid_t process = spawned(command, folder, writer.number());
  writer.close();
  std::string output;
  std::optional<int> code;
  // A program may end while its children still hold the pipe open. What it wrote before its end is in the
  // pipe then, and one more look at the pipe, without waiting, reads it.
  for (bool open = true, ended = false; open && !ended;) {
    ended = code.has_value();
    pollfd wait{reader.number(), POLLIN, 0};
    const int ready = poll(&wait, 1, ended ? 0 : 20);
    if (!ended && monitor && !monitor(0, 1)) {
      kill(-process, SIGKILL);
      exit_code(process, 0);
      return std::nullopt;
    }
    if (ready == 0 && !ended) code = exit_code(process, WNOHANG);
    if (ready <= 0) continue;
    std::array<char, longest_output> text;
    const ssize_t n = read(reader.number(), text.data(), text.size());
    open = n > 0 || (n < 0 && errno == EINTR);
    if (n > 0 && output.size() < longest_output) output.append(text.data(), static_cast<std::size_t>(n));
  }
  if (!code) code = exit_code(process, 0);
  return Finished{*code, output};
}

Compiler find_compiler() {
  const std::string chosen = environment("CC");
  for (const std::string& candidate : {chosen, std::string("cc"), std::string("clang"), std::string("gcc")}) {
    std::istringstream words(candidate);
    Compiler compiler;
    for (std::string word; words >> word;) compiler.command.push_back(word);
    if (compiler.command.empty()) continue;
    compiler.command[0] = found_on_path(compiler.command[0]);
    if (compiler.command[0].empty()) continue;
    static std::mutex mutex;
    static std::map<std::vector<std::string>, std::string> versions;
    const std::lock_guard lock(mutex);
    std::string& version = versions[compiler.command];
    if (version.empty()) {
      std::vector<std::string> question = compiler.command;
      question.emplace_back("--version");
      version = run_program(question, {})->output;
    }
    compiler.version = version;
    return compiler;
  }
  throw std::runtime_error(
      "there is no C compiler to specialise a model with: " +
      (chosen.empty() ? std::string() : "$CC is \"" + chosen + "\", which cannot be run, and ") +
      "neither cc nor clang nor gcc is on the PATH");
}

}  // namespace axode::codegen
