#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "apps/shell/commands.hpp"
#include "apps/study/study_command.hpp"

namespace axode::command {

void run_study(const StudyOptions&, const std::vector<Model>&, char** argv) {
  std::error_code unknown;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  const std::string study = program.parent_path() / "axode_study";
  execv(study.c_str(), argv);
  throw InputError(fmt::format(
      "{} cannot be run: {}; `make build` in the source tree of axode builds it beside the command", study,
      std::strerror(errno)));
}

}  // namespace axode::command
