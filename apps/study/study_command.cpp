#include "apps/study/study_command.hpp"

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/chart.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"

/// Options and help of `axode study`, and the checks of its input.
namespace axode::command {
namespace {

constexpr const char* study_footer = R"(Example:
  axode study double_pendulum.toml --csv study.csv --plot study.svg

Measures every algorithm in every representation and four choices of body frames:
  joint         joint frames: the axis of the joint is the z-axis of the body, at its origin
  user          body frames of the file
  com           frames at the centres of mass, parallel to the joint frames
  construction  frames that coincide with the inertial frame at q = 0
and the fast path, which belongs to no representation. The columns are:
  mul, add, div, sqrt, sin cos   operations on numbers that the code executes, zeros and ones included
  Ad, Ad_R, Ad_r                 twists, wrenches and screws transformed: by a pose, a rotation, a translation
  M Ad, M Ad_R, M Ad_r           inertias transformed by a pose, a rotation, a translation
  ad                             Lie brackets, of twists with twists or wrenches
  ns                             time of one call in one thread, median, nanoseconds

Where the paper has several ways to compute the same, or only some representations have an algorithm, these
are compared in joint frames.
Forward dynamics by contraction of the tree is an algorithm for parallel processors, which is only
counted. The longest path has the operations that wait for each other if there is a processor for each
body; without compressions the algorithm is that of articulated bodies.

All of them are algorithms for trees: a mechanism with loops or couplings is refused. The results do not
depend on the frames; see docs/comparative-study.md. The CSV has a line for each row of the tables. The
plot shows times as bars and total operations as marks, scaled so that the mark of body-fixed twists in
joint frames is at the end of its bar.)";

std::vector<Model> checked_models(const StudyOptions& options) {
  choose("--format", options.format, formats);
  const std::optional<ChartFile> plot = chart_file(options.plot);
  if (options.counts && plot) throw InputError("--plot: the chart shows times, which --counts leaves out");
  std::vector<Model> models = load_all(options.mechanisms);
  for (std::size_t k = 0; k < models.size(); ++k) {
    const std::string& file = options.mechanisms.files[k];
    if (models[k].nv() == 0)
      throw InputError(file + ": the model has no moving body; a study needs at least one");
    if (!models[k].loops().empty())
      throw InputError(
          file +
          ": the mechanism has loops or couplings, and a study compares algorithms for trees; leave its "
          "[[loop]] and [[coupling]] tables out to study the tree, and call axode eval "
          "or axode simulate to count them");
  }
  return models;
}

}  // namespace

void add_study(CLI::App& app, char** argv, int& exit_code) {
  const auto options = std::make_shared<StudyOptions>();
  CLI::App* study = app.add_subcommand("study", "Compare representations and frames: operations and times");
  add_model_options(*study, options->mechanisms, Files::several);
  study->add_option("--csv", options->csv, "Write the numbers to this file")->type_name("FILE");
  add_plot_option(*study, options->plot);
  study->add_flag("--counts", options->counts, "Count only, and leave the times out");
  study->add_flag("--rounding", options->rounding,
                  "Add rounding errors against the distance from the origin and the condition of M");
  study->add_flag(
      "--drift", options->drift,
      "Add how far joints in absolute coordinates open if nothing closes them, by the groups of the bodies");
  study->add_option("--format", options->format, "Output format; default: table")->type_name(words(formats));
  study->footer(study_footer);
  study->callback([options, argv, &exit_code] {
    run_study(*options, checked_models(*options), argv);
    exit_code = all_well;
  });
}

}  // namespace axode::command
