#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <memory>
#include <sstream>

#include "apps/commands/assembling.hpp"
#include "apps/files/model_options.hpp"
#include "apps/files/motion_file.hpp"
#include "apps/files/state.hpp"
#include "apps/files/text_file.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/table.hpp"
#include "apps/shell/terminal.hpp"
#include "axode/view.hpp"

namespace axode::command {
namespace {

struct ViewOptions {
  ModelOptions mechanism;
  std::string state, motion, output;
};

constexpr const char* view_footer =
    R"(Writes a page for a browser that shows the mechanism with its meshes, controls for its joints, the joint
screws, and a motion with its twists, wrenches and energies. The page is one file and needs no network.
Without --output it is written to a folder for temporary files and opened.

Meshes are searched beside the file that names them, and package://NAME/PATH in ROS_PACKAGE_PATH, in share
of AMENT_PREFIX_PATH and in the folders around that file. A body without a visible shape is drawn from its
joints and inertia.

STATE is the JSON object of `axode eval`, of which only q is used; the motion is a .csv, .json or .npz of
`axode simulate`.

Example:
  axode simulate four_bar.toml --until 5 --samples 500 --output run.csv
  axode view four_bar.toml --motion run.csv --output four_bar.html)";

/// The HTML page of the viewer without a mechanism, from an installation or from the build tree.
std::string empty_page() {
  if constexpr (std::string_view(AXODE_BUILT_PAGE).empty())
    throw InputError(
        "this build of axode has no viewer; configure it with -DAXODE_VIEWER=ON, which takes npm");
  std::error_code unknown;
  const std::filesystem::path command = std::filesystem::read_symlink("/proc/self/exe", unknown),
                              installed = command.parent_path() / AXODE_INSTALLED_PAGE;
  for (const std::filesystem::path& page : {installed, std::filesystem::path(AXODE_BUILT_PAGE)})
    if (std::filesystem::is_regular_file(page, unknown)) return read_text(page.string());
  throw InputError("the page of the viewer is neither " + installed.lexically_normal().string() + " nor " +
                   AXODE_BUILT_PAGE + "; build the target axode_viewer");
}

/// Makes a new folder for a temporary file, and returns the path of the file `name` in it.
std::string temporary_file(const std::string& name) {
  std::error_code failed;
  const std::filesystem::path temporary = std::filesystem::temp_directory_path(failed);
  if (failed)
    throw InputError("TMPDIR names no folder; set it to one, or say by --output where to write the page");
  std::string folder = (temporary / "axode-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) throw InputError(folder + ": the folder cannot be made");
  return (std::filesystem::path(folder) / name).string();
}

/// Opens a file with the program that the desktop has for files of its type. Returns false if there is none.
bool open(const std::string& file) {
  posix_spawn_file_actions_t silent;
  posix_spawn_file_actions_init(&silent);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&silent, stream, "/dev/null", O_RDWR, 0);
  bool opened = false;
  for (std::string opener : {"xdg-open", "open"}) {
    std::string name = file;
    const std::array<char*, 3> words{opener.data(), name.data(), nullptr};
    opened = opened || posix_spawnp(nullptr, opener.c_str(), &silent, nullptr, words.data(), environ) == 0;
  }
  posix_spawn_file_actions_destroy(&silent);
  return opened;
}

std::string size_of(std::uintmax_t bytes) {
  return bytes < 1'000'000 ? fmt::format("{:.1f} kB", static_cast<double>(bytes) / 1e3)
                           : fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

void run(const ViewOptions& options) {
  const std::string page = empty_page();
  const Model model = load(options.mechanism);
  SceneOptions shown;
  if (!options.motion.empty()) shown.motion = read_motion(model, options.motion);
  std::vector<double> q = first_configuration(model);
  if (!options.motion.empty()) q.assign(shown.motion.q.begin(), shown.motion.q.begin() + model.nq());
  if (!options.state.empty()) q = read_state(model, options.state).q;
  State shown_state = neutral_state(model);
  shown_state.q = q;
  if (const auto open = open_loop(model, shown_state, options.mechanism.strict))
    fmt::print(stderr, "{}\n", in(Ink::warning, "warning: " + *open, stderr));
  std::ostringstream text;
  const SceneContents contents = write_page(page, model, q, text, shown);
  for (const std::string& warning : contents.warnings)
    fmt::print(stderr, "{}\n", in(Ink::warning, warning, stderr));
  const std::string html = std::move(text).str(),
                    file = options.output.empty() ? temporary_file("page.html") : options.output;
  write_text(file, html);
  fmt::print("{}: {}, {} moving bodies, {} meshes\n", file, size_of(html.size()), model.n_bodies(),
             contents.meshes.size());
  Table meshes({"mesh", "size"});
  for (const SceneContents::Mesh& mesh : contents.meshes) meshes.row({mesh.file, size_of(mesh.bytes)});
  if (!contents.meshes.empty()) fmt::print("{}", meshes.text());
  if (options.output.empty() && !open(file))
    throw InputError("there is neither xdg-open nor open; open " + file + " in a browser");
}

}  // namespace

void add_view(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<ViewOptions>();
  CLI::App* view = app.add_subcommand("view", "Show a mechanism and its motion in a browser");
  add_model_options(*view, options->mechanism);
  view->add_option("--state", options->state,
                   "JSON, - for standard input. If left out: the start of the motion, or the initial state "
                   "with loops closed")
      ->type_name("FILE");
  view->add_option("--motion", options->motion, "A .csv, .json or .npz of `axode simulate --output`")
      ->type_name("FILE");
  view->add_option("--output", options->output, "Write the page here and do not open it")->type_name("FILE");
  view->footer(view_footer);
  view->callback([options, &exit_code] {
    run(*options);
    exit_code = all_well;
  });
}

}  // namespace axode::command
