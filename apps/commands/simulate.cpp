#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include "apps/commands/assembling.hpp"
#include "apps/commands/chart.hpp"
#include "apps/files/json_text.hpp"
#include "apps/files/matrix_file.hpp"
#include "apps/files/model_options.hpp"
#include "apps/files/state.hpp"
#include "apps/files/state_table.hpp"
#include "apps/files/text_file.hpp"
#include "apps/quantities/written_motion.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/progress.hpp"
#include "apps/shell/table.hpp"
#include "apps/shell/terminal.hpp"
#include "axode/dynamics.hpp"
#include "axode/eigen.hpp"
#include "axode/integration.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "axode/model/configuration.hpp"
#include "axode/view/mesh_hull.hpp"

namespace axode::command {
namespace {

struct SimulateOptions {
  ModelOptions mechanism;
  std::string state, target, method, coordinates = "relative", local_coordinates = "exponential",
                                     format = "table";
  std::vector<double> gains;
  double until = 1, relative = 1e-8, absolute = 1e-10, spectral_radius = 0.8;
  std::optional<double> step;
  int samples = 0;
  bool joint_losses = false, kinematic = false, contact = false;
  Assembling assembling;
  std::vector<std::string> outputs;
  std::string plot;
  std::vector<std::string> columns;
};

constexpr const char* simulate_footer =
    R"(Simulates a mechanism from a state at t = 0 under gravity, constant drive forces and loads. The
integration is on the Lie group of configurations: quaternions stay unit quaternions, and no orientation
is singular.

METHOD is dopri5 (adaptive steps), rk4 or euler (fixed steps of --step seconds; of fourth and of first
order, the latter semi-implicit), or generalized_alpha (implicit, of second order, for stiff systems). The
methods on (q, p) conserve the momenta of floating bases to rounding: midpoint, suzuki4 and kahan_li6
(implicit, of second, fourth and sixth order), whose energy errors stay bounded, and rk4_momenta
(explicit).

--coordinates are relative (joint coordinates), absolute (bodies as points of SE(3), every joint a
constraint), absolute_SO3xR3 (bodies as points of SO(3) x R^3) or absolute_by_joint (of SE(3) if a joint on
the ground constrains the body, of SO(3) x R^3 otherwise). In absolute coordinates dopri5, rk4 and euler
project onto the constraints after each step. Further methods for absolute coordinates are rattle,
rattle_suzuki4 and rattle_kahan_li6 (of second, fourth and sixth order; symplectic, or symmetric if there
are rolling contacts), half_explicit (third order), generalized_alpha and generalized_alpha_index3.
Results are always joint coordinates.

--local-coordinates are those of a step: exponential, or cayley, with which methods keep their orders and
those of second order err more where a body turns fast.

--contact, or METHOD contact, takes fixed steps in which collision shapes touch with Coulomb's friction, and
hard stops stop, of 1 ms if --step is left out; METHOD contact_adaptive takes steps as long as --rtol and
--atol allow. METHOD contact_exact, for few contacts, integrates smooth phases as dopri5 does and finds
impacts, stick and slip as roots. The largest certificate of a step says how exactly the laws of contact hold: 1e-12 is rounding. A drawing with [contact] is simulated so unless another METHOD is named.
--floor 0 puts a robot whose file has no ground on a floor; --base free lets its base move.

With --pd a controller drives all joints, except passive joints and free joints on the ground, towards the
q and v of --target by tau = KP (q_target - q) + KD (v_target - v); the difference of rotations is a
rotation vector. It is added to the drive forces of STATE. Springs, dampers and stops of the mechanism
always act, and so do drives, [[drive]], whose states x are written.

STATE is the JSON object of `axode eval` with the keys q, v, tau and loads; keys that are left out are
neutral, at rest or 0. Without STATE the motion begins in the initial state of the drawing, [state]; if it
has none, with all joints at zero and at rest. Prescribed motions of the drawing, [[motion]], are followed
from t = 0 on. The initial state is moved to the nearest one that closes the loops and follows the motions.
With --assemble the same is done to STATE; the joints that --hold names keep their q and v of STATE.

With --kinematic, for mechanisms whose motions use up the mobility, forces and masses do not matter, and q,
v, a and jerk are computed at equal intervals of time (100, or --samples).

Example:
  echo '{"q": {"pin": 2}}' | axode simulate double_pendulum.toml --state - --until 10 --output run.csv --plot run.svg

The ending of FILE says what is written by --output: .json all that is known; .csv a row for each time
with t, q, v, a, tau, the energy and loads, under names; .npz these as arrays: q = numpy.load("run.npz")["q"].
--plot draws q, v, tau, the forces of contacts and the energies over time, and of these what --columns
names. Ctrl-C ends the motion; the part computed so far is written.)";

/// The drive forces of a simulation: the constant ones of the state plus those of the controller.
Drive drive_of(const Model& model, const State& state, const SimulateOptions& options) {
  const Drive constant = [&state](double, std::span<const double>, std::span<const double>,
                                  std::span<double> tau) { std::ranges::copy(state.tau, tau.begin()); };
  if (options.gains.empty()) {
    if (!options.target.empty())
      throw UsageError("--target needs the gains of a controller; give --pd as well");
    return constant;
  }
  const State target = options.target.empty() ? neutral_state(model) : read_state(model, options.target);
  std::vector<double> kp(static_cast<std::size_t>(model.nv()), options.gains[0]),
      kd(kp.size(), options.gains[1]);
  for (int i = 1; i <= model.n_bodies(); ++i)
    if (const Joint& joint = model.joint(i); joint.kind == Subgroup::free && model.body(i).predecessor == 0) {
      std::fill_n(&kp[joint.iv], joint.nv, 0);
      std::fill_n(&kd[joint.iv], joint.nv, 0);
    }
  return ProportionalDerivative(model, {kp, kd}, {model, target.q, target.v}, constant);
}

std::string method_of(const SimulateOptions& options, const Model& model) {
  if (options.contact) return "contact";
  return options.method.empty() ? std::string(usual_method(model)) : options.method;
}

Trajectory motion_of(const Model& model, const State& state, const Drive& drive,
                     const SimulateOptions& options) {
  SimulationOptions acting;
  acting.drive = drive;
  acting.loads = state.loads;
  acting.joint_losses = options.joint_losses;
  const Interruptible interruptible;
  Progress progress(options.until);
  acting.monitor = [&](double t) {
    progress.show(t);
    return !interruptible.interrupted();
  };
  const std::string named = method_of(options, model);
  const Method method = choose("--method", named, methods);
  acting.coordinates = choose("--coordinates", options.coordinates, coordinate_kinds);
  acting.local_coordinates = choose("--local-coordinates", options.local_coordinates, local_coordinate_kinds);
  if (options.step) check_step(*options.step);
  const double step = options.step.value_or(method.usual_step);
  if (!method.adapts && step == 0) throw UsageError("--step is missing; " + named + " takes fixed steps");
  std::optional<ContactShapes> shapes;
  if (method.touches) {
    shapes.emplace(model, hull_of_mesh);
    if (shapes->pairs().empty() && !has_hard_stops(model))
      fmt::print(
          stderr, "{}\n",
          in(Ink::warning, "no collision shapes can touch; --floor puts the mechanism on a floor", stderr));
  }
  return method.simulate({model,
                          state.q,
                          state.v,
                          options.until,
                          step,
                          {.relative = options.relative, .absolute = options.absolute},
                          options.spectral_radius,
                          acting,
                          shapes ? &*shapes : nullptr});
}

/// Throws UsageError for a name in --columns that no curve of any motion of the mechanism has.
void check_columns(const Model& model, const SimulateOptions& options) {
  if (options.columns.empty()) return;
  // A chart of one state that has forces everywhere has all curves.
  const auto zeros = [](int n) { return std::vector<double>(static_cast<std::size_t>(n)); };
  Trajectory motion(model);
  motion.append(0, zeros(model.nq()), zeros(model.nv()), zeros(model.nv()), zeros(model.nv()));
  if (choose("--method", method_of(options, model), methods).touches) {
    const ContactShapes shapes(model, hull_of_mesh);
    std::vector<ContactForce> contacts;
    for (int k = 0; k < shapes.size(); ++k) motion.contact_shapes.push_back(shapes[k].name);
    for (const auto& [a, b] : shapes.pairs())
      contacts.push_back({.a = a, .b = b, .branch = LawBranch::stick});
    motion.set_contacts(contacts);
  }
  const Eigen::VectorXd one = Eigen::VectorXd::Zero(1);
  Chart chart = chart_of(motion, {.t = one,
                                  .energy = one,
                                  .kinetic_energy = one,
                                  .q = Eigen::MatrixXd::Zero(1, model.nq()),
                                  .v = Eigen::MatrixXd::Zero(1, model.nv()),
                                  .tau = Eigen::MatrixXd::Ones(1, model.nv()),
                                  .motion_forces = Eigen::MatrixXd::Zero(1, std::ssize(model.motions()))});
  keep_columns(chart, options.columns);
}

/// Whether no joint moves.
bool rests(const WrittenMotion& rows) {
  constexpr double still = 1e-9;
  return rows.v.size() > 0 && rows.v.cwiseAbs().maxCoeff() <= still;
}

/// Prints the first changes of contacts, and which contacts were closed before their bounces ended.
void print_contact_events(const Trajectory& motion) {
  const std::vector<Trajectory::ContactEvent>& events = motion.contact_events;
  if (events.empty()) return;
  constexpr std::size_t most = 20;
  fmt::print("contacts changed {} times{}\n", events.size(),
             events.size() > most ? fmt::format("; the first {} times:", most) : ":");
  for (const Trajectory::ContactEvent& event : std::span(events).first(std::min(most, events.size())))
    fmt::print("  t = {:.13g} s  {}  {}{}\n", event.t, to_string(event.kind), event.of,
               event.speed != 0 ? " at " + significant(event.speed) : "");
  for (const Trajectory::ContactEvent& event : events)
    if (event.shortened)
      fmt::print("{} stayed closed at t = {} s, because its next bounces would have been below rounding\n",
                 event.of, significant(event.t));
}

void print(const Trajectory& motion, const WrittenMotion& rows) {
  const std::size_t last = motion.size() - 1;
  const auto numbers = [](std::span<const double> x) { return std::vector<double>(x.begin(), x.end()); };
  fmt::print(
      "{}", state_tables(motion.model(), numbers(motion.q(last)), {{"v", numbers(motion.v(last))}}, "per s"));
  const Eigen::Index end = rows.energy.size() - 1;
  const double first = rows.energy[0];
  fmt::print("\nat t = {} s after {} steps and {} evaluations; ", significant(motion.t().back()),
             motion.steps, motion.evaluations);
  fmt::print("energy {} J at the start, {} J at the end, at most {} J off the start\n", significant(first),
             significant(rows.energy[end]), significant((rows.energy.array() - first).abs().maxCoeff(), 2));
  if (motion.uncontrolled > 0)
    fmt::print("{}\n",
               in(Ink::warning, fmt::format("branches of the motion meet on its way: the errors of {} steps "
                                            "there are not controlled by --rtol and --atol",
                                            motion.uncontrolled)));
  if (!motion.certificates.empty())
    fmt::print("largest certificate of contact {}\n", significant(std::ranges::max(motion.certificates), 2));
  print_contact_events(motion);
  if (rows.motion_forces.cols() == 0 && !motion.model().motions().empty())
    fmt::print("{}\n", in(Ink::warning,
                          "the forces of prescribed motions are left out: those of the hard stops, against "
                          "which they may push, are not known"));
  if (rests(rows))
    fmt::print("{}\n", in(Ink::heading,
                          "nothing moves: the mechanism is at rest, in equilibrium; begin elsewhere by "
                          "--state, or by [state] in "
                          "the drawing"));
}

/// Computes a kinematic motion (without dynamics), writes it to files and prints it.
void run_kinematic(const SimulateOptions& options, const Model& model, const State& state,
                   const std::vector<FileFormat>& kinds) {
  constexpr int usual = 100;  // intervals if none are asked for
  const int intervals = options.samples > 0 ? options.samples : usual;
  std::vector<double> times;
  for (int k = 0; k <= intervals; ++k) times.push_back(options.until * k / intervals);
  const KinematicMotion motion = kinematic_motion(model, state.q, times);
  const auto matrix = [&](const std::vector<double>& all) {
    const auto N = static_cast<Eigen::Index>(motion.t.size());
    using RowByRow = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::MatrixXd(Eigen::Map<const RowByRow>(all.data(), N, std::ssize(all) / N));
  };
  const Eigen::VectorXd t = as_eigen(std::span<const double>(motion.t));
  const std::vector<NamedArray> arrays{{"t", t, true},
                                       {"q", matrix(motion.q)},
                                       {"v", matrix(motion.v)},
                                       {"a", matrix(motion.a)},
                                       {"jerk", matrix(motion.jerk)}};
  std::vector<std::string> names;
  Eigen::MatrixXd all(t.size(), 0);
  Json json{{"model", model.name()}, {"complete", motion.complete}, {"stopped", motion.stop_reason}};
  for (const NamedArray& array : arrays) {
    const Eigen::MatrixXd& numbers = array.numbers;
    all.conservativeResize(Eigen::NoChange, all.cols() + numbers.cols());
    all.rightCols(numbers.cols()) = numbers;
    if (array.is_vector) {
      names.push_back(array.name);
      json[array.name] = motion.t;
      continue;
    }
    for (const std::string& of : array.name == "q" ? coordinate_names(model) : velocity_names(model))
      names.push_back(array.name + " " + of);
    for (const auto& row : numbers.rowwise())
      json[array.name].push_back(std::vector<double>(row.begin(), row.end()));
  }
  for (std::size_t k = 0; k < kinds.size(); ++k) switch (kinds[k]) {
      case FileFormat::json: write_text(options.outputs[k], text(json)); break;
      case FileFormat::csv: write_text(options.outputs[k], as_csv(all, names)); break;
      case FileFormat::npz: write_text(options.outputs[k], as_npz(arrays)); break;
    }
  const auto last = [&](std::size_t k) {
    const Eigen::RowVectorXd row = arrays[k].numbers.bottomRows(1);
    return std::vector<double>(row.begin(), row.end());
  };
  fmt::print("{}\nat t = {} s, without dynamics\n",
             state_tables(model, last(1), {{"v", last(2)}, {"a", last(3)}, {"jerk", last(4)}},
                          "per s, per s^2, per s^3"),
             significant(motion.reached));
  if (!motion.complete) throw InputError("the motion ended early, " + motion.stop_reason);
}

void run(const SimulateOptions& options, int& exit_code) {
  const Format format = choose("--format", options.format, formats);
  if (options.samples < 0)
    throw UsageError(fmt::format("--samples is {}; it must not be negative", options.samples));
  std::vector<FileFormat> kinds;
  for (const std::string& file : options.outputs) kinds.push_back(file_format(file));
  const std::optional<ChartFile> plot = chart_file(options.plot);
  const Model model = load(options.mechanism);
  check_columns(model, options);
  State state = options.state.empty() ? starting_state(model) : read_state(model, options.state);
  Assembling assembling = options.assembling;
  const bool starts = model.description().state && !model.loops().empty();
  if (options.state.empty() && (starts || !model.motions().empty())) assembling.wanted = true;
  assemble(model, assembling, state);
  if (options.kinematic) {
    run_kinematic(options, model, state, kinds);
    exit_code = all_well;
    return;
  }
  const Drive drive = drive_of(model, state, options);
  const Trajectory motion = motion_of(model, state, drive, options);
  if (motion.size() == 0) throw InputError(motion.stop_reason);
  const Loads<> loads{state.loads, options.joint_losses};
  const WrittenMotion rows = written_motion(motion, drive, loads, options.samples);
  const auto json = [&] { return json_of(motion, rows, method_of(options, model), options.coordinates); };
  for (std::size_t k = 0; k < kinds.size(); ++k) switch (kinds[k]) {
      case FileFormat::json: write_text(options.outputs[k], text(json())); break;
      case FileFormat::csv: write_text(options.outputs[k], csv_of(model, rows)); break;
      case FileFormat::npz: write_text(options.outputs[k], npz_of(rows)); break;
    }
  if (plot) {
    constexpr int smooth = 500;  // number of intervals; otherwise long steps would be drawn as straight lines
    const bool coarse = options.samples == 0 && rows.t.size() < smooth;
    Chart chart = chart_of(motion, coarse ? written_motion(motion, drive, loads, smooth) : rows);
    keep_columns(chart, options.columns);
    plot->draw(chart);
  }
  if (format == Format::json) {
    fmt::print("{}", text(json()));
  } else {
    print(motion, rows);
  }
  if (!motion.complete) throw InputError("the motion ended early, " + motion.stop_reason);
  exit_code = all_well;
}

}  // namespace

void add_simulate(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<SimulateOptions>();
  CLI::App* simulate = app.add_subcommand("simulate", "Compute the motion from a state");
  add_model_options(*simulate, options->mechanism);
  add_floor_option(*simulate, options->mechanism);
  simulate->add_option("--state", options->state, "JSON, - for standard input; default: the initial state")
      ->type_name("FILE");
  simulate->add_option("--until", options->until, "End time, s; default: 1")->type_name("NUMBER");
  simulate
      ->add_option("--method", options->method,
                   "Integration method; default: dopri5, or contact if the drawing has [contact]")
      ->type_name("METHOD");
  simulate
      ->add_option("--coordinates", options->coordinates, "Coordinates of the integration; default: relative")
      ->type_name(words(coordinate_kinds));
  simulate
      ->add_option("--local-coordinates", options->local_coordinates,
                   "Coordinates of a step on the group; default: exponential")
      ->type_name(words(local_coordinate_kinds));
  simulate->add_option("--step", options->step, "Length of a step, s; of the first one with dopri5")
      ->type_name("NUMBER");
  simulate->add_option("--rtol", options->relative, "Relative tolerance; default: 1e-8")->type_name("NUMBER");
  simulate->add_option("--atol", options->absolute, "Absolute tolerance, rad, m; default: 1e-10")
      ->type_name("NUMBER");
  simulate
      ->add_option(
          "--spectral-radius", options->spectral_radius,
          "Part of fast oscillations that generalized_alpha leaves after a step, 0 to 1; default: 0.8")
      ->type_name("NUMBER");
  simulate
      ->add_option("--pd", options->gains, "Gains of a controller, N m/rad and N m s/rad, or N/m and N s/m")
      ->type_name("KP,KD")
      ->delimiter(',')
      ->expected(2);
  simulate->add_option("--target", options->target, "JSON, the target of --pd; default: neutral and at rest")
      ->type_name("FILE");
  simulate
      ->add_option("--samples", options->samples,
                   "Number of equal time intervals to write instead of the steps")
      ->type_name("NUMBER");
  add_assembly_options(*simulate, options->assembling);
  simulate->add_flag("--kinematic", options->kinematic,
                     "Compute the motion without dynamics; needs motions that use up the mobility");
  simulate->add_flag("--joint-losses", options->joint_losses,
                     "Count damping, friction and losses of gears of the joints");
  simulate
      ->add_flag("--contact", options->contact,
                 "Let collision shapes and hard stops act; the same as --method contact")
      ->excludes("--method");
  simulate->add_option("--output", options->outputs, "Write a .json, .csv or .npz; may be given again")
      ->type_name("FILE")
      ->allow_extra_args(false);
  add_plot_option(*simulate, options->plot);
  add_columns_option(*simulate, options->columns);
  simulate->add_option("--format", options->format, "Output format; default: table")
      ->type_name(words(formats));
  simulate->footer(simulate_footer);
  simulate->callback([options, &exit_code] { run(*options, exit_code); });
}

}  // namespace axode::command
