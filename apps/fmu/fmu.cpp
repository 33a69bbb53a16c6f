#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <memory>

#include "apps/files/model_options.hpp"
#include "apps/files/text_file.hpp"
#include "apps/fmu/zip_archive.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"
#include "axode/fmi.hpp"

namespace axode::command {
namespace {

struct Options {
  ModelOptions mechanism;
  std::string out, version = "3.0", kind = "both";
  bool joint_losses = false;
  std::vector<std::string> frames, loads;
};

constexpr std::array<std::pair<std::string_view, fmi::Version>, 2> versions{
    {{"3.0", fmi::Version::fmi3}, {"2.0", fmi::Version::fmi2}}};

using Kinds = std::vector<fmi::Kind>;
enum class KindWord { both, model_exchange, co_simulation };
constexpr std::array<std::pair<std::string_view, KindWord>, 3> kinds{
    {{"both", KindWord::both},
     {"model-exchange", KindWord::model_exchange},
     {"co-simulation", KindWord::co_simulation}}};

constexpr const char* fmu_footer = R"(Example:
  axode fmu four_bar.toml --output four_bar.fmu --frame coupler

An FMU is a file that other simulators run. It contains the mechanism as a drawing, and a binary for this
platform with the parts of axode that simulate it. Loops stay closed, and springs, motions and drives act as
in `axode simulate`. In model exchange the other simulator integrates; in co-simulation the FMU does, with
dopri5, or as `axode simulate --contact` if the drawing has [contact] or hard stops. In model exchange dry
friction, play and hard stops are events; contact is refused.

Variables are in SI units. States and outputs are the coordinates q.JOINT and the velocities v.JOINT, with
the rates der(q.JOINT) and der(v.JOINT). Inputs are the drive forces tau.JOINT and, for every --load, the
wrench load.FRAME.moment and load.FRAME.force about the origin of the frame, in inertial axes; all are 0 at
the start. For every --frame, the entries of frame.FRAME.rotation and frame.FRAME.position are outputs.
Parameters, which can be changed before the start, are gravity, masses, centres of mass and inertias of
bodies, points of joints, and constants of springs, for example body.BODY.mass. Directional derivatives are
exact.)";

/// The shared library in every FMU (functional mock-up unit, a model as a file for other programs).
std::string binary() {
  if constexpr (std::string_view(AXODE_BUILT_FMU).empty())
    throw InputError(
        "this build of axode has no binary for FMUs; configure it with -DBUILD_SHARED_LIBS=OFF on Linux");
  std::error_code unknown;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", unknown),
                              installed = program.parent_path() / AXODE_INSTALLED_FMU;
  for (const std::filesystem::path& file : {installed, std::filesystem::path(AXODE_BUILT_FMU)})
    if (std::filesystem::is_regular_file(file, unknown)) return read_bytes(file.string());
  throw InputError("the binary for FMUs is neither " + installed.lexically_normal().string() + " nor " +
                   AXODE_BUILT_FMU + "; build the target axode_fmu");
}

Kinds wanted(KindWord word) {
  switch (word) {
    case KindWord::model_exchange: return {fmi::Kind::model_exchange};
    case KindWord::co_simulation: return {fmi::Kind::co_simulation};
    default: return {fmi::Kind::model_exchange, fmi::Kind::co_simulation};
  }
}

void run(const Options& options) {
  const fmi::Version version = choose("--fmi", options.version, versions);
  const KindWord kind = choose("--kind", options.kind, kinds);
  const Model model = load(options.mechanism);
  const fmi::Settings settings{options.joint_losses, options.frames, options.loads};
  std::vector<std::pair<std::string, std::string>> files;
  for (fmi::FmuFile& file : fmi::fmu_files(model, {version, wanted(kind), settings}, binary()))
    files.emplace_back(std::move(file.name), std::move(file.contents));
  write_text(options.out, as_zip(files, Compression::deflated));
  using fmi::Role;
  const fmi::VariableTable table(model, settings);
  fmt::print("{}: FMI {}; states: {}, inputs: {}\n", options.out, options.version,
             table.count(Role::coordinate) + table.count(Role::velocity) + table.count(Role::drive_state),
             table.count(Role::force) + table.count(Role::load));
}

}  // namespace

void add_fmu(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<Options>();
  CLI::App* fmu = app.add_subcommand("fmu", "Write a mechanism as an FMU, which other simulators run");
  add_model_options(*fmu, options->mechanism);
  fmu->add_option("--output", options->out, "The file to write, .fmu")->required()->type_name("FILE");
  fmu->add_option("--fmi", options->version, "Version of FMI; default: 3.0")->type_name(words(versions));
  fmu->add_option("--kind", options->kind, "Kinds of FMU; in co-simulation axode integrates; default: both")
      ->type_name(words(kinds));
  fmu->add_option("--frame", options->frames, "A frame whose pose is an output; may be given again")
      ->type_name("FRAME")
      ->allow_extra_args(false);
  fmu->add_option("--load", options->loads, "A frame with a wrench as input; may be given again")
      ->type_name("FRAME")
      ->allow_extra_args(false);
  fmu->add_flag("--joint-losses", options->joint_losses,
                "Count damping, friction and losses of gears of the joints");
  fmu->footer(fmu_footer);
  fmu->callback([options, &exit_code] {
    run(*options);
    exit_code = all_well;
  });
}

}  // namespace axode::command
