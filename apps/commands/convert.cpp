#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <sstream>
#include <vector>

#include "apps/files/model_options.hpp"
#include "apps/files/text_file.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/terminal.hpp"

namespace axode::command {
namespace {

struct ConvertOptions {
  ModelOptions in;
  std::string out;
  bool force = false;
};

constexpr const char* convert_footer = R"(Example:
  axode convert humanoid.urdf humanoid.toml

The suffix of OUT chooses the format: .toml is a drawing, .urdf a URDF, .xml MJCF. Properties that the
format cannot describe, such as springs in a URDF, are left out with a warning; with --strict they are an
error, and nothing is written. A joint of a kind that the format does not have, such as a helical joint,
is always an error. IN is a drawing, a URDF or SDFormat (.sdf, .world); MJCF is read by the Python
package: axode.load.)";

/// A function that writes a model in a file format and returns a warning for each thing that is lost.
using Writer = std::vector<Fault> (*)(const Model&, std::ostream&, Strictness);

std::vector<Fault> write_all(const Model& model, std::ostream& out, Strictness) {
  write_drawing(model, out);
  return {};
}

Writer writer_for(const std::string& file) {
  static constexpr std::array<std::pair<std::string_view, Writer>, 3> writers{
      {{".toml", write_all}, {".urdf", write_urdf}, {".xml", write_mjcf}}};
  return choose("OUT: " + file, std::filesystem::path(file).extension().string(), writers);
}

void run(const ConvertOptions& options) {
  const Writer write = writer_for(options.out);
  if (!options.force && std::filesystem::exists(options.out))
    throw InputError(options.out + ": the file exists; --force replaces it");
  const Model model = load(options.in);
  const auto warn = [](std::span<const Fault> faults) {
    for (const Fault& fault : faults) fmt::print(stderr, "{}\n", in(Ink::warning, to_string(fault), stderr));
  };
  warn(model.warnings());
  std::ostringstream text;
  warn(write(model, text, options.in.strictness()));
  write_text(options.out, text.str());
  fmt::print("{}: {} moving bodies, nq = {}, nv = {}\n", options.out, model.n_bodies(), model.nq(),
             model.nv());
}

}  // namespace

void add_convert(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<ConvertOptions>();
  CLI::App* convert =
      app.add_subcommand("convert", "Write a mechanism in another format: drawing, URDF, MJCF");
  add_model_options(*convert, options->in, Files::one, "IN");
  convert->add_option("OUT", options->out, "The file to write")->required()->type_name("FILE");
  convert->add_flag("--force", options->force, "Replace OUT if it exists");
  convert->footer(convert_footer);
  convert->callback([options, &exit_code] {
    run(*options);
    exit_code = all_well;
  });
}

}  // namespace axode::command
