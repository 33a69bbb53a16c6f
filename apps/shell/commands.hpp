#pragma once
#include <stdexcept>
#include <string>
#include <vector>

namespace CLI {
class App;
}

/// The commands of `axode`. Each function adds one command, which sets the exit code when it is run.
namespace axode::command {

enum ExitCode {
  all_well = 0,
  bad_input = 1,    ///< a file is missing, malformed or describes something impossible
  wrong_usage = 2,  ///< the command line itself is wrong
};

/// The error that is thrown if the command line itself is wrong.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The error that is thrown for a wrong input, with one sentence for each fault.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::vector<std::string> sentences)
      : std::runtime_error("bad input"), sentences_(std::move(sentences)) {}
  explicit InputError(std::string sentence) : InputError(std::vector{std::move(sentence)}) {}
  const std::vector<std::string>& sentences() const { return sentences_; }

 private:
  std::vector<std::string> sentences_;
};

void add_info(CLI::App& app, int& exit_code);
void add_check(CLI::App& app, int& exit_code);
void add_convert(CLI::App& app, int& exit_code);
void add_eval(CLI::App& app, int& exit_code);
void add_linearize(CLI::App& app, int& exit_code);
void add_mobility(CLI::App& app, int& exit_code);
void add_simulate(CLI::App& app, int& exit_code);
void add_contacts(CLI::App& app, int& exit_code);
void add_plot(CLI::App& app, int& exit_code);
void add_view(CLI::App& app, int& exit_code);
/// Adds the command `map`. It has no exit code here, because Python replaces this program.
void add_map(CLI::App& app);
void add_codegen(CLI::App& app, int& exit_code);
void add_fmu(CLI::App& app, int& exit_code);
/// Adds the command `study`. `argv` are the words of the command line, and a null pointer.
void add_study(CLI::App& app, char** argv, int& exit_code);
void add_demo(CLI::App& app, int& exit_code);
void add_completion(CLI::App& app, int& exit_code);
void add_manual(CLI::App& app, int& exit_code);

}  // namespace axode::command
