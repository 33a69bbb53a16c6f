#include "apps/shell/gnuplot.hpp"

#include <spawn.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <memory>

#include "apps/shell/commands.hpp"

extern char** environ;

namespace axode::command {
namespace {

class TemporaryFile {
 public:
  TemporaryFile() : file_(std::tmpfile(), std::fclose) {
    if (!file_) throw InputError("gnuplot: no temporary file can be created");
  }
  int descriptor() const { return fileno(file_.get()); }
  void write(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size() || std::fflush(file_.get()) != 0)
      throw InputError("gnuplot: a temporary file cannot be written");
    std::rewind(file_.get());
  }
  std::string text() {
    std::rewind(file_.get());
    std::string all;
    std::array<char, 65536> block;
    for (std::size_t n; (n = std::fread(block.data(), 1, block.size(), file_.get())) > 0;)
      all.append(block.data(), n);
    return all;
  }

 private:
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

}  // namespace

std::optional<GnuplotOutcome> gnuplot(const std::string& script) {
  TemporaryFile in, out, err;
  in.write(script);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, in.descriptor(), 0);
  posix_spawn_file_actions_adddup2(&files, out.descriptor(), 1);
  posix_spawn_file_actions_adddup2(&files, err.descriptor(), 2);
  std::array<std::string, 3> words{"gnuplot", "--default-settings", "-"};
  std::array<char*, 4> argv{words[0].data(), words[1].data(), words[2].data(), nullptr};
  pid_t child = 0;
  const int failure = posix_spawnp(&child, argv[0], &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  int status = 0;
  if (failure != 0 || waitpid(child, &status, 0) != child) return std::nullopt;
  return GnuplotOutcome{status, out.text(), err.text()};
}

}  // namespace axode::command
