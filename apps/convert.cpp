#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <sstream>

#include "choice.hpp"
#include "commands.hpp"
#include "terminal.hpp"
#include "text_file.hpp"

namespace axode::command {
namespace {

struct Options {
  std::string in, out, base;
  bool force = false;
};

constexpr const char* footer = R"(Example:
  axode convert humanoid.urdf humanoid.toml

The ending of OUT decides: .toml is a drawing, .urdf or .xml a URDF. What URDF has no words for, such as
helical joints, is an error, and nothing is written.)";

using Writer = void (*)(const Model&, std::ostream&);

Writer writer_for(const std::string& file) {
  static constexpr std::array<std::pair<std::string_view, Writer>, 3> writers{
      {{".toml", write_drawing}, {".urdf", write_urdf}, {".xml", write_urdf}}};
  return choose("OUT: " + file, std::filesystem::path(file).extension().string(), writers);
}

/// A drawing may not have bodies that no matter can make, a URDF may.
std::ptrdiff_t errors_in(const std::string& file) {
  return std::ranges::count_if(check(file),
                               [](const Fault& fault) { return fault.severity == Severity::error; });
}

void run(const Options& options) {
  const Writer write = writer_for(options.out);
  const Base base = base_of(options.base);
  if (!options.force && std::filesystem::exists(options.out))
    throw InputError(options.out + ": the file exists; --force replaces it");
  const Model model = load(options.in, base);
  for (const Fault& fault : model.warnings())
    fmt::print(stderr, "{}\n", in(Ink::warning, to_string(fault), stderr));
  std::ostringstream text;
  write(model, text);
  write_text(options.out, text.str());
  fmt::print("{}: {} moving bodies, nq = {}, nv = {}\n", options.out, model.n_bodies(), model.nq(),
             model.nv());
  if (const std::ptrdiff_t n = errors_in(options.out); n > 0)
    fmt::print(stderr,
               "{0}: it has {1} fault{2} that only a URDF may have; axode check {0} lists what to mend\n",
               options.out, n, n == 1 ? "" : "s");
}

}  // namespace

void add_convert(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<Options>();
  CLI::App* convert = app.add_subcommand("convert", "Write a URDF as a drawing, or a drawing as a URDF");
  convert->add_option("IN", options->in, "A drawing (.toml) or a URDF")->required()->type_name("FILE");
  convert->add_option("OUT", options->out, "The file to write")->required()->type_name("FILE");
  convert->add_option("--base", options->base, "fixed or free; as the file says if left out")
      ->type_name("WORD");
  convert->add_flag("--force", options->force, "Replace OUT where it exists");
  convert->footer(footer);
  convert->callback([options, &exit_code] {
    run(*options);
    exit_code = all_well;
  });
}

}  // namespace axode::command
