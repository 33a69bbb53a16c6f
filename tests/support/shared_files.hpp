#pragma once
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

/// Reference files that lie outside the repository: test vectors and robots of other projects.
namespace axode::test {

/// The folder named by the environment variable, or else the one beside the source tree.
inline std::filesystem::path shared_folder(const char* variable, const char* beside_the_source) {
  if (const char* chosen = std::getenv(variable); chosen != nullptr && *chosen != '\0') return chosen;
  return std::filesystem::path(AXODE_SOURCE_DIR) / ".." / beside_the_source;
}

/// Reference values: `<system>_model.json` with `<system>_state*.json`, and `se3_functions.json`.
inline std::filesystem::path vectors_folder() { return shared_folder("AXODE_VECTORS", "shared/vectors"); }

/// Robot descriptions, `*.urdf`.
inline std::filesystem::path robots_folder() { return shared_folder("AXODE_ROBOTS", "shared/robots"); }

/// Files of a folder whose names end in `ending`, sorted; empty where the folder does not exist.
inline std::vector<std::filesystem::path> files_ending_in(const std::filesystem::path& folder,
                                                          const std::string& ending) {
  std::vector<std::filesystem::path> files;
  if (!std::filesystem::is_directory(folder)) return files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().filename().string().ends_with(ending)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// For GTEST_SKIP() when files are absent: the message says in which folder the files were looked for and how
/// to choose another one.
inline std::string missing(const std::filesystem::path& folder, const char* variable) {
  return "no reference files in " + folder.lexically_normal().string() + "; set " + variable +
         " to their folder";
}

}  // namespace axode::test
