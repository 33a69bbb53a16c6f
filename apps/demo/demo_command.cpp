#include <CLI/CLI.hpp>

#include "apps/demo/demo.hpp"
#include "apps/shell/commands.hpp"

namespace axode::command {
namespace {

constexpr const char* demo_footer = R"(Example:
  axode demo

Loads an arm and a humanoid that come with axode, and computes their inverse dynamics in four
representations of twists and wrenches: they must agree to rounding. Takes a few seconds.)";

}  // namespace

void add_demo(CLI::App& app, int& exit_code) {
  CLI::App* demo = app.add_subcommand("demo", "Show what axode does, on an arm and a humanoid");
  demo->footer(demo_footer);
  demo->callback([&exit_code] {
    show_demo();
    exit_code = all_well;
  });
}

}  // namespace axode::command
