#pragma once
#include <optional>
#include <string>
#include <vector>

#include "axode/io.hpp"

namespace CLI {
class App;
}

namespace axode::command {

/// Options for the files of mechanisms, which are the same in all commands.
struct ModelOptions {
  std::vector<std::string> files;
  std::string base;
  bool strict = false;
  std::optional<double> floor = {};  ///< height of a floor that the mechanism is put on, m

  /// The value of --base. Throws UsageError for another word.
  Base held() const;
  Strictness strictness() const { return strict ? Strictness::strict : Strictness::lenient; }
};

enum class Files { one, several };

/// Adds the files, by the name that the help gives them, and the options --base and --strict.
void add_model_options(CLI::App& command, ModelOptions& options, Files files = Files::one,
                       const char* name = "MODEL");

/// Adds the option --floor, for commands in which shapes touch.
void add_floor_option(CLI::App& command, ModelOptions& options);

/// Loads the mechanisms of all files, in the order of the files.
std::vector<Model> load_all(const ModelOptions& options);
/// Loads the mechanism of the only file.
Model load(const ModelOptions& options);

}  // namespace axode::command
