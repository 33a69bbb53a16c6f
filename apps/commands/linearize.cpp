#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "apps/commands/chart.hpp"
#include "apps/commands/modes.hpp"
#include "apps/files/json_text.hpp"
#include "apps/files/matrix_file.hpp"
#include "apps/files/model_options.hpp"
#include "apps/files/state.hpp"
#include "apps/files/state_table.hpp"
#include "apps/files/text_file.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/table.hpp"
#include "apps/shell/terminal.hpp"
#include "axode/constraints.hpp"
#include "axode/constraints/check_loops.hpp"
#include "axode/derivatives.hpp"
#include "axode/dynamics/forward_dynamics.hpp"
#include "axode/dynamics/inverse_dynamics.hpp"
#include "axode/dynamics/springs.hpp"
#include "axode/eigen.hpp"
#include "axode/table/check_counts.hpp"

namespace axode::command {
namespace {

using Eigen::Index;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct LinearizeOptions {
  ModelOptions mechanism;
  std::string state, format = "table";
  bool equilibrium = false, hold = false, joint_losses = false;
  std::vector<std::string> outputs;
  std::string plot;
};

constexpr const char* linearize_footer =
    R"(Small deviations x = (delta, dv) from the motion through the state change as x' = A x + B dtau: the
displacements delta of the joints, angles and lengths in their own axes, and their velocities dv. The
command prints the modes of the system without dtau: natural frequency and damping ratio of a mode that
oscillates, time constant of a mode that decays or grows, and the displacements in each mode, scaled so
that the largest is 1.

STATE is the JSON object of `axode eval` with the keys q, v, tau and loads; keys that are left out are
neutral, at rest or 0. --equilibrium replaces q by a near configuration that is in equilibrium under tau
and the loads, stable or unstable. --hold replaces tau by the drive forces that hold q at rest; in a
mechanism with loops only joints that are not passive have drives. With loops x refers to independent
velocities, whose names are printed.

Example:
  echo '{"q": {"pin": 3}}' |
    axode linearize double_pendulum.toml --state - --equilibrium --output AB.npz --output AB.csv --plot poles.svg

The suffix of FILE chooses what --output writes: .json has all results; .csv has the matrix [A B] with 2nv
rows and 3nv columns (fewer with loops) and their names; .npz has A and B: A = numpy.load("AB.npz")["A"].
--plot draws the poles, which are the eigenvalues of A, and the natural frequencies.)";

constexpr Index most_columns = 8;        ///< largest nv for which A and B are printed
constexpr std::size_t most_entries = 4;  ///< largest number of displacements of a mode that are printed
constexpr double smallest_entry = 0.01;  ///< smallest displacement of a mode that is printed

/// The linearised equations of motion of a model, and the state at which they were computed.
struct Linearized {
  Model model;
  State state;
  bool joint_losses;
  std::vector<std::string>
      velocities;  ///< names of the velocities in A: of all, or of the independent ones with loops
  RowMajor A, B;
  Modes modes;
};

bool is_zero(const std::vector<double>& x) {
  return std::ranges::all_of(x, [](double x_k) { return x_k == 0; });
}

/// The state that the options describe: the state of a file or, without a file, all joints at zero. With
/// --hold, drive forces are added under which this state is at rest; with --equilibrium, the joints are moved
/// to an equilibrium.
State found_state(const Model& model, const LinearizeOptions& options) {
  State state = options.state.empty() ? neutral_state(model) : read_state(model, options.state);
  if (options.equilibrium || options.hold) {
    const char* const option = options.hold ? "--hold" : "--equilibrium";
    if (!is_zero(state.v))
      throw InputError(fmt::format("v is not 0, but {} needs a state at rest: leave v out of STATE", option));
  }
  if (options.hold) {
    if (!is_zero(state.tau)) throw InputError("tau is not 0, but --hold computes it: leave tau out of STATE");
    Workspace<> workspace(model);
    Eigen::VectorXd springs(model.nv());
    spring_forces(model, workspace, state.q, state.v, as_span(springs));
    if (!model.loops().empty()) {
      LoopWorkspace<> loops(model);
      check_driven(inverse_dynamics(model, loops, state.q, state.v, state.v, state.tau, {}, {}, {state.loads},
                                    as_span(springs)),
                   "hold q");
    } else {
      inverse_dynamics(model, workspace, state.q, state.v, state.v, state.tau, {state.loads});
      as_eigen(std::span(state.tau)) -= springs;
    }
  }
  if (options.equilibrium) {
    EquilibriumResult found = equilibrium(model, state.q, state.tau, {state.loads});
    if (found.status != EquilibriumStatus::solved)
      throw InputError(fmt::format(
          "no equilibrium was found from q: {} after {}, with unbalanced forces of {} N m and N (norm); "
          "start from another q",
          to_string(found.status), counted(static_cast<std::size_t>(found.iterations), "step"),
          significant(found.residual, 3)));
    state.q = std::move(found.q);
  }
  return state;
}

Linearized linearized(const LinearizeOptions& options) {
  const Model model = load(options.mechanism);
  if (model.loops().empty())
    catalog::check_counts<"linearize">(model);
  else
    catalog::check_counts<"independent_linearization">(model);
  const Index nv = model.nv();
  Linearized at{model,
                found_state(model, options),
                options.joint_losses,
                velocity_names(model),
                RowMajor(2 * nv, 2 * nv),
                RowMajor(2 * nv, nv),
                {}};
  State& state = at.state;
  const Loads<> loads{state.loads, options.joint_losses};
  Workspace<> workspace(model);
  const auto require = [&](const Solvability& solvability) {
    if (!solvability.ok()) throw InputError(to_string(model, solvability));
  };
  std::vector<double> forces = state.tau;
  add_spring_forces(model, workspace, state.q, state.v, forces);
  if (!model.loops().empty()) {
    const IndependentLinearization linear =
        independent_linearization(model, state.q, state.v, state.tau, {}, loads);
    require(linear.solvability);
    LoopWorkspace<> loops(model);
    require(forward_dynamics<double>(model, loops, state.q, state.v, forces, state.a, {}, loads));
    std::vector<std::string> chosen;
    for (const int c : linear.velocities) chosen.push_back(at.velocities[static_cast<std::size_t>(c)]);
    at.velocities = chosen;
    at.A = linear.A;
    at.B = linear.B;
  } else {
    require(forward_dynamics(model, workspace, state.q, state.v, forces, state.a, loads));
    require(linearize(model, workspace, state.q, state.v, state.tau, {as_span(at.A), as_span(at.B)}, loads));
  }
  if (!at.A.allFinite() || !at.B.allFinite()) require({.not_finite = true});
  at.modes = modes(at.A);
  return at;
}

/// The matrix [A B] of a linear system, with the names of its rows and columns.
struct Named {
  Eigen::MatrixXd matrix;
  std::vector<std::string> rows, columns;
};
Named named(const Linearized& at) {
  Named AB{Eigen::MatrixXd(at.A.rows(), at.A.cols() + at.B.cols()), {}, {}};
  AB.matrix << at.A, at.B;
  for (const char* const what : {"delta ", "dv "})
    for (const std::string& name : at.velocities) AB.columns.push_back(what + name);
  for (const std::string& name : velocity_names(at.model)) AB.columns.push_back("dtau " + name);
  for (const char* const what : {"delta' ", "dv' "})
    for (const std::string& name : at.velocities) AB.rows.push_back(what + name);
  return AB;
}

/// "stable" if every mode decays, "unstable" if some mode grows exponentially, otherwise "marginal".
std::string_view stability(const Modes& modes) {
  const auto each = [&](auto condition) { return std::ranges::all_of(modes.all, condition); };
  if (!each([](const Mode& mode) { return mode.eigenvalue.real() <= 0; })) return "unstable";
  return each([](const Mode& mode) { return mode.eigenvalue.real() < 0; }) ? "stable" : "marginal";
}

template <class Matrix> Json rows(const Matrix& matrix) {
  Json out = Json::array();
  for (Index i = 0; i < matrix.rows(); ++i) {
    out.push_back(Json::array());
    for (Index k = 0; k < matrix.cols(); ++k) out.back().push_back(matrix(i, k));
  }
  return out;
}

Json as_json(const Mode& mode) {
  const auto pair = [](const std::complex<double>& z) { return Json{z.real(), z.imag()}; };
  Json shape = Json::array();
  for (const std::complex<double>& displacement : mode.shape) shape.push_back(pair(displacement));
  Json out{{"eigenvalue", pair(mode.eigenvalue)}, {"rigid", mode.rigid()}};
  if (mode.oscillates()) {
    out["natural_frequency"] = mode.natural_frequency();
    out["damping_ratio"] = mode.damping_ratio();
  } else if (!mode.rigid()) {
    out["time_constant"] = mode.time_constant();
  }
  out["shape"] = shape;
  return out;
}

Json as_json(const Linearized& at) {
  Json all = Json::array();
  for (const Mode& mode : at.modes.all) all.push_back(as_json(mode));
  Json out{{"model", at.model.name()},
           {"nq", at.model.nq()},
           {"nv", at.model.nv()},
           {"velocities", velocity_names(at.model)},
           {"gravity", to_json(at.model.gravity())},
           {"joint_losses", at.joint_losses},
           {"q", at.state.q},
           {"v", at.state.v},
           {"tau", at.state.tau},
           {"a", at.state.a},
           {"A", rows(at.A)},
           {"B", rows(at.B)},
           {"stability", stability(at.modes)},
           {"zero_eigenvalues", at.modes.zeros},
           {"modes", all}};
  if (!at.model.loops().empty()) out["independent"] = at.velocities;
  return out;
}

std::string heading(const char* name, const std::string& about) {
  return "\n" + in(Ink::heading, name) + ": " + about + "\n";
}

/// A table of columns of [A B], one for each heading, beginning with column `first`.
std::string table_of(const Named& AB, const std::vector<std::string>& headings, Index first) {
  std::vector<std::string> all{""};
  all.insert(all.end(), headings.begin(), headings.end());
  Table table(all);
  for (Index i = 0; i < AB.matrix.rows(); ++i) {
    std::vector<Cell> row{AB.rows[static_cast<std::size_t>(i)]};
    for (Index k = 0; k < static_cast<Index>(headings.size()); ++k) row.emplace_back(AB.matrix(i, first + k));
    table.row(std::move(row));
  }
  return table.text();
}

std::string matrix_tables(const Linearized& at) {
  const Index rows = at.A.rows(), k = rows / 2, nv = at.model.nv();
  if (nv > most_columns)
    return fmt::format("\nA is {} x {} and B is {} x {}; --output writes them to a file\n", rows, rows, rows,
                       nv);
  const Named AB = named(at);
  return heading("A, columns of delta", "what displacements do; per s, per s^2") +
         table_of(AB, at.velocities, 0) + heading("A, columns of dv", "what velocities do; 1, per s") +
         table_of(AB, at.velocities, k) + heading("B", "what drive forces do; per kg m^2, kg m, kg") +
         table_of(AB, velocity_names(at.model), rows);
}

/// The largest displacements of a vibration mode as text, with phase angles relative to the largest one.
std::string shape_text(const Mode& mode, const std::vector<std::string>& names) {
  std::vector<std::size_t> order;
  const auto size = [&](std::size_t k) { return std::abs(mode.shape[static_cast<Index>(k)]); };
  for (std::size_t k = 0; k < names.size(); ++k)
    if (size(k) >= smallest_entry) order.push_back(k);
  std::ranges::stable_sort(order, std::ranges::greater(), size);
  std::string text;
  for (std::size_t n = 0; n < order.size(); ++n) {
    if (n == most_entries) return text + ", ...";
    const std::complex<double> z = mode.shape[static_cast<Index>(order[n])];
    const bool in_phase = std::abs(z.imag()) < smallest_entry * std::abs(z);
    text +=
        fmt::format("{}{} {:.2f}", n == 0 ? "" : ", ", names[order[n]], in_phase ? z.real() : std::abs(z));
    if (!in_phase) text += fmt::format(" at {:.0f} deg", std::arg(z) * 180 / std::numbers::pi);
  }
  return text;
}

std::string mode_table(const Linearized& at) {
  Table table({"#", "mode", "Hz", "rad/s", "damping ratio", "time constant", "shape"});
  for (std::size_t k = 0; k < at.modes.all.size(); ++k) {
    const Mode& mode = at.modes.all[k];
    const bool grows = mode.eigenvalue.real() > 0;
    std::vector<Cell> row{std::to_string(k + 1)};
    if (mode.rigid()) {
      row.insert(row.end(), {"rigid", "", "", "", ""});
    } else if (mode.oscillates()) {
      const double frequency = mode.natural_frequency();
      row.insert(row.end(), {grows ? "oscillates, grows" : "oscillates", frequency / (2 * std::numbers::pi),
                             frequency, mode.damping_ratio(), ""});
    } else {
      row.insert(row.end(), {grows ? "grows" : "dies out", "", "", "", mode.time_constant()});
    }
    row.emplace_back(shape_text(mode, at.velocities));
    table.row(std::move(row));
  }
  return table.text();
}

std::string verdict(const Linearized& at) {
  const std::string_view found = stability(at.modes);
  const auto grow = static_cast<std::size_t>(
      std::ranges::count_if(at.modes.all, [](const Mode& mode) { return mode.eigenvalue.real() > 0; }));
  std::string text = found == "stable"     ? "stable: every deviation dies out"
                     : found == "marginal" ? "marginal: no mode grows, and not every one dies out"
                                           : "unstable: " + counted(grow, "mode grows", "modes grow");
  if (at.modes.zeros > 0)
    text += fmt::format("; 0 is an eigenvalue {} times, of rigid modes", at.modes.zeros);
  return text;
}

/// A chart of the poles, which are the eigenvalues of A, and of the natural frequencies of oscillating modes.
Chart chart_of_poles(const Linearized& at) {
  std::array<Curve, 3> poles{
      Curve{.name = "dies out", .color = 0}, {.name = "keeps on", .color = 8}, {.name = "grows", .color = 3}};
  Curve frequencies{.kind = Curve::bars, .color = 0};
  for (std::size_t k = 0; k < at.modes.all.size(); ++k) {
    const Mode& mode = at.modes.all[k];
    const double x = mode.eigenvalue.real(), y = mode.eigenvalue.imag();
    Curve& curve = poles[x < 0 ? 0 : x > 0 ? 2 : 1];
    curve.kind = Curve::points;
    curve.x.push_back(x);
    curve.y.push_back(y);
    if (!mode.oscillates()) continue;
    curve.x.push_back(x);
    curve.y.push_back(-y);
    frequencies.x.push_back(static_cast<double>(k + 1));
    frequencies.y.push_back(mode.natural_frequency() / (2 * std::numbers::pi));
  }
  Chart chart{
      .title = at.model.name() + ": " + std::string(stability(at.modes)), .width = 420, .height = 320};
  chart.panels.push_back({.title = "poles",
                          .x_axis = "real part, 1/s",
                          .y_axis = "imaginary part, rad/s",
                          .curves = {poles.begin(), poles.end()},
                          .axes_through_zero = true});
  if (frequencies.x.empty()) return chart;
  chart.columns = 2;
  chart.panels.push_back(
      {.title = "modes", .x_axis = "mode", .y_axis = "natural frequency, Hz", .curves = {frequencies}});
  return chart;
}

void print(const Linearized& at) {
  const State& state = at.state;
  fmt::print("{}", state_tables(at.model, state.q, {{"v", state.v}, {"tau", state.tau}, {"a", state.a}},
                                "per s, N m or N, per s^2"));
  const double a = as_eigen(std::span<const double>(state.a)).lpNorm<Eigen::Infinity>();
  if (!is_zero(state.v) || a > 1e-6)
    fmt::print("\n{}\n",
               in(Ink::warning,
                  "the state is no equilibrium: A and B are the matrices at this instant of a motion"));
  fmt::print("{}{}{}", matrix_tables(at),
             heading("modes", verdict(at) + "; time constants in s, displacements in rad or m"),
             mode_table(at));
}

void run(const LinearizeOptions& options) {
  const Format format = choose("--format", options.format, formats);
  std::vector<FileFormat> file_formats_asked;
  for (const std::string& file : options.outputs) file_formats_asked.push_back(file_format(file));
  const std::optional<ChartFile> plot = chart_file(options.plot);
  const Linearized at = linearized(options);
  const Named AB = named(at);
  for (std::size_t k = 0; k < options.outputs.size(); ++k) switch (file_formats_asked[k]) {
      case FileFormat::json: write_text(options.outputs[k], text(as_json(at))); break;
      case FileFormat::csv: write_text(options.outputs[k], as_csv(AB.matrix, AB.rows, AB.columns)); break;
      case FileFormat::npz: write_text(options.outputs[k], as_npz({{"A", at.A}, {"B", at.B}})); break;
    }
  if (plot) plot->draw(chart_of_poles(at));
  if (format == Format::json) {
    fmt::print("{}", text(as_json(at)));
  } else {
    print(at);
  }
}

}  // namespace

void add_linearize(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<LinearizeOptions>();
  CLI::App* linearize =
      app.add_subcommand("linearize", "Find the linear system about a state, its frequencies and modes");
  add_model_options(*linearize, options->mechanism);
  linearize->add_option("--state", options->state, "JSON, - for standard input; default: neutral and at rest")
      ->type_name("FILE");
  CLI::Option* equilibrium = linearize->add_flag(
      "--equilibrium", options->equilibrium, "Linearise at the equilibrium under tau that is found from q");
  linearize->add_flag("--hold", options->hold, "Use the drive forces that hold q at rest instead of tau")
      ->excludes(equilibrium);
  linearize->add_flag("--joint-losses", options->joint_losses, "Count damping of the joints");
  linearize->add_option("--output", options->outputs, "Write a .json, .csv or .npz; may be given again")
      ->type_name("FILE")
      ->allow_extra_args(false);
  add_plot_option(*linearize, options->plot);
  linearize->add_option("--format", options->format, "Output format; default: table")
      ->type_name(words(formats));
  linearize->footer(linearize_footer);
  linearize->callback([options, &exit_code] {
    run(*options);
    exit_code = all_well;
  });
}

}  // namespace axode::command
