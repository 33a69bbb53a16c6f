#pragma once
#include <optional>
#include <string>
#include <vector>

#include "axode/io.hpp"

namespace CLI {
class App;
}

namespace axode::command {

/// The options of a command that name the files of mechanisms and say how the files are read.
struct ModelOptions {
  std::vector<std::string> files;
  std::string base;
  bool strict = false;
  std::optional<double> floor = {};  ///< height of a floor that the mechanism is put on, m

  /// The value of the option --base. Throws UsageError if the word is none of its values.
  Base held() const;
  Strictness strictness() const { return strict ? Strictness::strict : Strictness::lenient; }
};

enum class Files { one, several };

/// Adds to a command the options --base and --strict and the files, which its help calls `name`.
void add_model_options(CLI::App& command, ModelOptions& options, Files files = Files::one,
                       const char* name = "MODEL");

/// Adds the option --floor to a command in which shapes may touch.
void add_floor_option(CLI::App& command, ModelOptions& options);

/// Loads the mechanisms of all files, in the order of the files.
std::vector<Model> load_all(const ModelOptions& options);
/// Loads the mechanism of the file, for a command that takes one file.
Model load(const ModelOptions& options);

}  // namespace axode::command
