#pragma once
#include <string>
#include <vector>

#include "apps/files/model_options.hpp"

namespace axode::command {

/// The options of `axode study`.
struct StudyOptions {
  ModelOptions mechanisms;
  std::string csv, plot, format = "table";
  bool counts = false, rounding = false, drift = false;
};

/// Measures the mechanisms, and prints the results or writes them to the files that the options name. In the
/// command `axode`, this function replaces the process by the program axode_study, which is built separately
/// because its kernels take long to compile. `argv` are the words of the command line, and a null pointer.
void run_study(const StudyOptions& options, const std::vector<Model>& models, char** argv);

}  // namespace axode::command
