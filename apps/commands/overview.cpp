#include "apps/commands/overview.hpp"

#include <fmt/format.h>

#include <string_view>
#include <vector>

#include "apps/shell/terminal.hpp"

namespace axode::command {
namespace {

struct Example {
  std::string_view line, purpose;
};
struct Task {
  std::string_view name;
  std::vector<Example> examples;
};

const std::vector<Task>& tasks() {
  static const std::vector<Task> all{
      {"Look at a mechanism",
       {{"axode info arm7.toml", "its tree, joints, masses and frames"},
        {"axode view humanoid.urdf --output page.html", "a page that shows it, and its motion"},
        {"axode check humanoid.urdf", "every fault of the file"},
        {"axode convert humanoid.urdf humanoid.toml", "a URDF or SDF as a drawing, or as MJCF"}}},
      {"Compute",
       {{"axode eval arm7.toml --want inverse_dynamics,poses", "quantities at a state"},
        {"axode simulate four_bar.toml --until 2 --output run.csv", "the motion from a state"},
        {"axode contacts quadruped.toml", "points of contact, and their forces at rest"},
        {"axode plot run.csv --output run.svg", "a chart of it"},
        {"axode linearize double_pendulum.toml", "small motions: frequencies and modes"},
        {"axode mobility bricard.toml", "what loops can do at a configuration"},
        {"axode map mass_matrix arm7.toml in.parquet out.parquet", "many states, by way of Python"}}},
      {"Go further",
       {{"axode codegen arm7.toml --output arm7.c", "C code of this one mechanism"},
        {"axode fmu four_bar.toml --output four_bar.fmu", "an FMU, which other simulators run"},
        {"axode study arm7.toml", "what each representation costs"}}},
      {"Get to know axode",
       {{"axode demo", "an arm and a humanoid, each in four representations"},
        {"axode manual | man -l -", "all commands and options on one page"},
        {"axode completion bash", "what makes the shell complete commands"}}}};
  return all;
}

}  // namespace

std::string overview() {
  std::size_t width = 0;
  for (const Task& task : tasks())
    for (const Example& example : task.examples) width = std::max(width, example.line.size());
  std::string text;
  for (const Task& task : tasks()) {
    text += in(Ink::heading, task.name) + "\n";
    for (const auto& [line, purpose] : task.examples)
      text += fmt::format("  {:<{}}  {}\n", line, width, purpose);
    text += "\n";
  }
  return text + "axode COMMAND --help says more about a command, axode --help about all.\n";
}

}  // namespace axode::command
