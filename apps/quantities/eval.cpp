#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/commands/assembling.hpp"
#include "apps/commands/chart.hpp"
#include "apps/files/matrix_file.hpp"
#include "apps/files/model_options.hpp"
#include "apps/files/state_table.hpp"
#include "apps/files/text_file.hpp"
#include "apps/quantities/components.hpp"
#include "apps/quantities/quantities.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/table.hpp"
#include "apps/shell/terminal.hpp"
#include "axode/eigen.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/model/building/nearest_name.hpp"

namespace axode::command {
namespace {

struct Options {
  ModelOptions mechanism;
  std::string state, want = "inverse_dynamics", representation = "body", gravity, plot, output,
                     format = "table";
  std::vector<std::string> frames, columns, stiffness, inertia;
  std::string relative_to = "ground";
  int order = 1;
  std::string coriolis = "christoffel", at = "body";
  bool joint_losses = false;
  Assembling assembling;
};

constexpr const char* footer = R"(Quantities for --want (several are separated by commas):
{quantities}

A state is a JSON object with the keys q, v, a, jerk, snap, tau, p, dq, dv, da, dtau, w, loads and
targets; each key may be left out:
  q, v, a, jerk, snap, tau, p; a direction dq, dv, da, dtau; weights w, 1 if absent:
            arrays in the model's order (`axode info MODEL` shows it), or objects keyed by joint
            name; a joint that is not named is neutral or at rest
  loads     applied wrenches, a list of {"frame": NAME, "representation": "body", "wrench": [moment, force]}
  targets   poses for inverse_kinematics, a list of {"frame": NAME, "pose": [four rows of four numbers]}
Units are m, kg, s, rad. Rotations are quaternions x y z w. Twists, accelerations and wrenches have their
angular part first, in the representation that --representation names.

Example:
  echo '{"q": {"A4": 0.5}, "loads": [{"frame": "flange", "wrench": [0, 0, 0, 0, 0, -20]}]}' |
    axode eval arm7.toml --state - --want inverse_dynamics,poses --format json
  echo '{"q": {"A2": 0.5}}' | axode simulate arm7.toml --state - --output run.csv
  axode eval arm7.toml --state run.csv --want poses --frame flange --plot flange.svg

A .csv with a row for each state, as `axode simulate --output` writes it, is a sweep: its columns are t
and, each with a name of `axode info` behind it, q, v, a, jerk, snap and tau. The table has the smallest
and the largest of each number, --plot draws them over t (or those that --columns names), --output writes
them as a .csv with a row for each state, and the JSON has a list of values for each quantity.

How motors before springs must move, so that the joints follow a motion (series_elastic drives of the
drawing have a stiffness and an inertia too; loops take the motion of their platform):
  axode eval arm7.toml --state motion.csv --want elastic_feed_forward --stiffness 5000,A7=1000 \
    --inertia 0.5 --output motors.csv

The JSON is {"model", "nq", "nv", "joints": [...], "results": {name: value}} with arrays in the order
of "joints", poses, twists and accelerations keyed by frame, joint_wrenches keyed by joint. Jacobians are
keyed by frame: six rows of nv entries; their partial derivatives are lists of them, outermost first.)";

/// Functions of a state that `axode eval` does not offer, each with the advice that the error message gives.
constexpr std::pair<std::string_view, std::string_view> elsewhere[]{
    {"assemble", "ask for \"assembly\", or close the loops of the state by --assemble"},
    {"closure_derivatives",
     "it needs motions of the joints of the loops, which --state cannot give; call it in Python or C++"},
    {"contacts", "use axode contacts"},
    {"contact_rollout_derivatives",
     "it needs drive forces of several steps, which --state cannot give; call it in Python or C++"},
    {"contact_rollout_jvp",
     "it needs drive forces of several steps, which --state cannot give; call it in Python or C++"},
    {"contact_rollout_vjp",
     "it needs drive forces of several steps, which --state cannot give; call it in Python or C++"},
    {"equilibrium_with_drives",
     "it needs states of drives, which --state cannot give; call it in Python or C++"},
    {"forward_dynamics_rates",
     "it needs time derivatives of drive forces, which --state cannot give; call it in Python or C++"},
    {"independent_linearization", "use axode linearize"},
    {"inverse_kinematics_rates",
     "it needs the twists and poses of a place, which --state cannot give; call it in Python or C++"},
    {"jacobian_columns", "ask for \"jacobian\", whose columns off the path of the frame are 0"},
    {"jacobian_derivative_along", "ask for \"jacobian_partials\", its derivatives along all directions"},
    {"jacobian_derivatives", "ask for \"jacobian_derivative\" with --order"},
    {"linearize", "use axode linearize"},
    {"linearize_with_drives",
     "it needs states of drives, which --state cannot give; call it in Python or C++"},
    {"local_mobility", "use axode mobility"},
    {"loop_hessian_product",
     "it needs multipliers of the loops, which --state cannot give; call it in Python or C++"},
    {"motion_vjp", "ask for \"motion_derivatives\", the matrices whose product with weights it is"},
    {"pair_distances", "ask for \"distances\", which has those of all pairs"},
    {"rollout", "use axode simulate"},
    {"rollout_derivatives",
     "it needs drive forces of several steps, which --state cannot give; call it in Python or C++"},
    {"rollout_derivatives_with_drives",
     "it needs drive forces of several steps, which --state cannot give; call it in Python or C++"},
    {"rollout_jvp",
     "it needs drive forces of several steps, which --state cannot give; call it in Python or C++"},
    {"rollout_vjp",
     "it needs drive forces of several steps, which --state cannot give; call it in Python or C++"},
    {"second_order_inverse_dynamics", "ask for \"inverse_dynamics_rates\", the same numbers"},
    {"simulate", "use axode simulate"},
    {"spring_coordinate",
     "it needs the name of a spring, which --state cannot give; call it in Python or C++"},
    {"twist_derivatives", "ask for \"twist_derivative\" with --order"},
    {"view", "use axode view"}};

std::vector<Quantity> wanted(const std::string& list) {
  std::vector<Quantity> chosen;
  for (const std::string& name : CLI::detail::split(list, ',')) {
    const auto& all = quantities();
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const Quantity& q) { return q.name == name; });
    for (const auto& [function, remedy] : elsewhere)
      if (name == function) throw UsageError(fmt::format("--want: {} is not a quantity: {}", name, remedy));
    if (found == all.end())
      throw UsageError("--want: there is no quantity \"" + name + '"' +
                       suggestion(name, all, [](const Quantity& q) { return q.name; }));
    chosen.push_back(*found);
  }
  return chosen;
}

std::optional<Vec3<>> gravity_of(const std::string& text) {
  if (text.empty()) return std::nullopt;
  const UsageError wrong("--gravity: \"" + text +
                         "\" is not three finite numbers in m/s^2, such as 0,0,-9.81");
  const std::vector<std::string> words = CLI::detail::split(text, ',');
  std::array<double, 3> g{};
  if (words.size() != g.size()) throw wrong;
  for (std::size_t k = 0; k < g.size(); ++k) {
    const char* end = words[k].data() + words[k].size();
    const auto [stop, failure] = std::from_chars(words[k].data(), end, g[k]);
    if (failure != std::errc{} || stop != end || !std::isfinite(g[k])) throw wrong;
  }
  return Vec3<>{g[0], g[1], g[2]};
}

void require_finite(const Json& value, const std::string& where) {
  if (value.is_number_float() && !std::isfinite(value.get<double>()))
    throw InputError(where + " is not finite; the numbers of the state or the model are too large");
  if (value.is_structured())
    for (const auto& [key, entry] : value.items())
      require_finite(entry, value.is_object() ? where + " of \"" + key + "\"" : where);
}

Json joint_layout(const Model& model) {
  Json layout = Json::object();
  for (const Joint& joint : model.joints())
    if (!joint.leader)
      layout[joint.name] = {{"kind", to_string(joint.kind)},
                            {"iq", joint.iq},
                            {"nq", joint.nq},
                            {"iv", joint.iv},
                            {"nv", joint.nv}};
  return layout;
}

Json as_json(const Question& ask, const std::string& representation, const Json& results, const Json& labels,
             const std::optional<std::string>& open) {
  Json joints = Json::array(), coupled = Json::array(), warnings = Json::array();
  for (const Joint& joint : ask.model.joints()) (joint.leader ? coupled : joints).push_back(joint.name);
  for (const Fault& fault : ask.model.warnings()) warnings.push_back(to_string(fault));
  if (open) warnings.push_back(*open);
  Json out{{"model", ask.model.name()}, {"nq", ask.model.nq()}, {"nv", ask.model.nv()}, {"joints", joints}};
  if (!coupled.empty()) out["coupled_joints"] = coupled;
  out["layout"] = joint_layout(ask.model);
  out["representation"] = representation;
  out["gravity"] = to_json(ask.model.gravity());
  out["joint_losses"] = ask.joint_losses;
  out["results"] = results;
  out["labels"] = labels;
  if (!warnings.empty()) out["warnings"] = warnings;
  return out;
}

void print_warnings(const Question& ask, const Options& options, const std::optional<std::string>& open) {
  if (open) fmt::print("\n{}\n", in(Ink::warning, "warning: " + *open));
  const auto warnings = ask.model.warnings();
  if (warnings.empty()) return;
  const std::string text = counted(warnings.size(), "warning") + " about the model: axode check " +
                           options.mechanism.files.front();
  fmt::print("\n{}\n", in(Ink::warning, text));
}

Answer finite_answer(const Quantity& quantity, const Question& ask) {
  Answer answer = quantity.answer(ask);
  require_finite(answer.value, std::string(quantity.name));
  return answer;
}

/// The sentence on the purpose of a quantity, with the details and units of an answer in brackets.
std::string label_of(const Quantity& quantity, const Answer& answer) {
  const auto& [value, table, units, details] = answer;
  if (details.empty() && units.empty()) return std::string(quantity.purpose);
  return fmt::format("{} ({}{}{}).", quantity.purpose.substr(0, quantity.purpose.size() - 1), details,
                     details.empty() || units.empty() ? "" : "; ", units);
}
std::string heading(const Quantity& quantity, const std::string& label) {
  return "\n" + in(Ink::heading, quantity.name) + ": " + label + "\n";
}

/// Prints the chosen quantities at one state.
void run(const Options& options, Format format, const std::vector<Quantity>& chosen, Question& ask) {
  ask.state = options.state.empty() ? neutral_state(ask.model) : read_state(ask.model, options.state);
  assemble(ask.model, options.assembling, ask.state);
  const std::optional<std::string> open = open_loop(ask.model, ask.state, options.mechanism.strict);
  Json results = Json::object(), labels = Json::object();
  std::string tables;
  for (const Quantity& quantity : chosen) {
    const Answer answer = finite_answer(quantity, ask);
    const std::string name(quantity.name);
    results[name] = answer.value;
    const std::string label = label_of(quantity, answer);
    labels[name] = label;
    tables += heading(quantity, label) + answer.table.text();
  }
  if (format == Format::json) {
    fmt::print("{}", text(as_json(ask, options.representation, results, labels, open)));
    return;
  }
  fmt::print("{}{}",
             state_tables(ask.model, ask.state.q, {{"v", ask.state.v}, {"a", ask.state.a}}, "per s, per s^2"),
             tables);
  print_warnings(ask, options, open);
}

/// A table with the extremes of each number of a quantity over many states, and the states that have them.
std::string extremes(const std::vector<Curve>& curves, const Sweep& sweep) {
  const std::string at = sweep.timed ? "at t" : "at state";
  Table table({"", "smallest", at, "largest", at});
  for (const Curve& curve : curves) {
    const auto low = std::ranges::min_element(curve.y), high = std::ranges::max_element(curve.y);
    table.row({curve.name, *low, curve.x[static_cast<std::size_t>(low - curve.y.begin())], *high,
               curve.x[static_cast<std::size_t>(high - curve.y.begin())]});
  }
  return table.text();
}

/// The numbers of quantities over many states as CSV, with a row for each state.
std::string csv_of(const Sweep& sweep, const std::vector<Quantity>& chosen,
                   const std::vector<std::vector<Curve>>& curves_of_all) {
  std::vector<std::string> names{sweep.timed ? "t" : "state"};
  std::vector<const std::vector<double>*> columns{&sweep.t};
  for (std::size_t k = 0; k < chosen.size(); ++k)
    for (const Curve& curve : curves_of_all[k]) {
      names.push_back((chosen.size() > 1 ? std::string(chosen[k].name) + " " : "") + curve.name);
      columns.push_back(&curve.y);
    }
  Eigen::MatrixXd all(std::ssize(sweep.t), std::ssize(columns));
  for (std::size_t c = 0; c < columns.size(); ++c)
    all.col(static_cast<Eigen::Index>(c)) = as_eigen(std::span(*columns[c]));
  return as_csv(all, names);
}

/// Adds the numbers of an answer as points at t to the curves of its quantity, one curve for each number.
void add_points(const Answer& answer, double t, std::vector<Curve>& curves) {
  const auto numbers = answer.table.numbers();
  curves.resize(numbers.size());
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    curves[k].name = numbers[k].first;
    curves[k].x.push_back(t);
    curves[k].y.push_back(numbers[k].second);
  }
}

/// Calls f(), which computes a state of a sweep. `place` names this state, and begins the sentences of errors.
template <class F> void at_state(const std::string& place, const F& f) {
  try {
    f();
  } catch (const InputError& error) {
    std::vector<std::string> sentences = error.sentences();
    for (std::string& sentence : sentences) sentence.insert(0, place);
    throw InputError(std::move(sentences));
  } catch (const UnknownName&) {  // in an option, which is the same at every state
    throw;
  } catch (const std::invalid_argument& error) {
    throw InputError(place + error.what());
  }
}

/// Prints the chosen quantities at each state of a sequence of states, and draws their chart.
void run_sweep(const Options& options, Format format, const std::vector<Quantity>& chosen, Question& ask,
               const std::optional<ChartFile>& plot) {
  if (!options.output.empty() && file_format(options.output) != FileFormat::csv)
    throw UsageError("--output: " + options.output + ": the numbers of a sweep are written as .csv");
  const Sweep sweep = read_sweep(ask.model, options.state);
  Json results = Json::object(), labels = Json::object();
  std::vector<std::vector<Curve>> curves_of_all(chosen.size());
  std::vector<std::string> units(chosen.size());
  std::optional<std::string> open;  // at the first state with an open loop
  for (std::size_t i = 0; i < sweep.states.size(); ++i) {
    ask.state = sweep.states[i];
    const std::string place = fmt::format("state {}: ", i);
    at_state(place, [&] {
      assemble(ask.model, options.assembling, ask.state);
      if (!open && (open = open_loop(ask.model, ask.state, options.mechanism.strict))) open->insert(0, place);
      for (std::size_t k = 0; k < chosen.size(); ++k) {
        const Answer answer = finite_answer(chosen[k], ask);
        const std::string name(chosen[k].name);
        results[name].push_back(answer.value);
        labels[name] = label_of(chosen[k], answer);
        units[k] = answer.units;
        add_points(answer, sweep.t[i], curves_of_all[k]);
      }
    });
  }
  Chart chart{.title = ask.model.name()};
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const std::size_t semicolon = units[k].rfind("; ");
    if (semicolon != std::string::npos) units[k].erase(0, semicolon + 2);
    std::ranges::move(panels_by_unit(ask.model, std::string(chosen[k].name), units[k], curves_of_all[k]),
                      std::back_inserter(chart.panels));
  }
  if (plot) {
    keep_columns(chart, options.columns);
    chart.panels.back().x_axis = sweep.timed ? "t, s" : "state";
    plot->draw(chart);
  }
  if (!options.output.empty()) write_text(options.output, csv_of(sweep, chosen, curves_of_all));
  if (format == Format::json) {
    Json out = as_json(ask, options.representation, results, labels, open);
    out["t"] = sweep.t;
    fmt::print("{}", text(out));
    return;
  }
  fmt::print("{}: {} states, {} from {} to {}\n", in(Ink::heading, ask.model.name()), sweep.states.size(),
             sweep.timed ? "t" : "numbered", significant(sweep.t.front()), significant(sweep.t.back()));
  for (std::size_t k = 0; k < chosen.size(); ++k)
    fmt::print("{}{}", heading(chosen[k], labels[std::string(chosen[k].name)]),
               extremes(curves_of_all[k], sweep));
  print_warnings(ask, options, open);
}

void run(const Options& options) {
  const std::vector<Quantity> chosen = wanted(options.want);
  const Format format = choose("--format", options.format, formats);
  const Representation representation = choose("--representation", options.representation, representations);
  const std::optional<Vec3<>> gravity = gravity_of(options.gravity);
  const bool sweeps = std::filesystem::path(options.state).extension() == ".csv";
  if (!options.plot.empty() && !sweeps)
    throw UsageError("--plot draws a sweep; give its states by --state FILE.csv");
  if (!options.output.empty() && !sweeps)
    throw UsageError("--output writes a sweep; give its states by --state FILE.csv");
  static constexpr std::string_view elastic = "elastic_feed_forward";
  if (std::ranges::none_of(chosen, [](const Quantity& quantity) { return quantity.name == elastic; }))
    for (const auto& [option, words] :
         {std::pair("--stiffness", &options.stiffness), std::pair("--inertia", &options.inertia)})
      if (!words->empty())
        throw UsageError(fmt::format("{} {} is used by {} alone; add {} to --want", option, words->front(),
                                     elastic, elastic));
  const std::optional<ChartFile> plot = chart_file(options.plot);
  Question ask{load(options.mechanism), {}, representation, options.joint_losses};
  if (gravity) ask.model = ModelBuilder(ask.model).gravity(*gravity).build();
  for (const std::string& name : options.frames) ask.frames.push_back(ask.model.frame_index(name));
  ask.relative_to = ask.model.frame_index(options.relative_to);
  ask.order = options.order;
  ask.stiffness = options.stiffness;
  ask.inertia = options.inertia;
  ask.coriolis = choose("--coriolis", options.coriolis, coriolis_forms);
  ask.at = choose("--at", options.at, wrench_points);
  if (sweeps) {
    run_sweep(options, format, chosen, ask, plot);
  } else {
    run(options, format, chosen, ask);
  }
}

}  // namespace

void add_eval(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<Options>();
  CLI::App* eval = app.add_subcommand("eval", "Compute quantities at a state");
  add_model_options(*eval, options->mechanism);
  eval->add_option("--state", options->state,
                   "JSON, - for standard input, or a .csv of several; default: neutral and at rest")
      ->type_name("FILE");
  add_assembly_options(*eval, options->assembling);
  eval->add_option("--want", options->want,
                   "Quantities to compute, from the list below; default: inverse_dynamics")
      ->type_name("QUANTITIES");
  eval->add_option("--representation", options->representation,
                   "Representation of twists and wrenches; default: body")
      ->type_name(words(representations));
  eval->add_option("--gravity", options->gravity, "x,y,z in m/s^2 instead of what the file says")
      ->type_name("NUMBERS");
  eval->add_option("--frame", options->frames, "Compute for this frame only; may be given again");
  eval->add_option("--relative-to", options->relative_to, "The observer's frame of relative_jacobian")
      ->capture_default_str();
  eval->add_option("--order", options->order, "The order of derivatives, from 0")
      ->check([](const std::string& order) {
        return order.starts_with('-') ? "order " + order + " is negative" : std::string();
      })
      ->capture_default_str();
  eval->add_option("--coriolis", options->coriolis, "The form of C")
      ->type_name(words(coriolis_forms))
      ->capture_default_str();
  eval->add_option(
          "--at", options->at,
          "Reference point of the moments of joint_wrenches: origin of the body, or point of the joint")
      ->type_name(words(wrench_points))
      ->capture_default_str();
  for (const auto& [name, words, purpose] :
       {std::tuple("--stiffness", &Options::stiffness,
                   "Stiffness of the springs between motors and joints, N m/rad or N/m; default: rigid"),
        std::tuple("--inertia", &Options::inertia,
                   "Inertia of the motors behind their gears, kg m^2 or kg; default: 0")})
    eval->add_option(name, (*options).*words, purpose)
        ->type_name("NUMBER,JOINT=NUMBER,...")
        ->delimiter(',')
        ->allow_extra_args(false);
  eval->add_flag("--joint-losses", options->joint_losses,
                 "Count damping, friction and losses of gears of the joints as forces");
  add_plot_option(*eval, options->plot);
  add_columns_option(*eval, options->columns);
  eval->add_option("--output", options->output, "Write the numbers of a sweep to a .csv")->type_name("FILE");
  eval->add_option("--format", options->format, "Output format; default: table")->type_name(words(formats));
  std::string list;
  for (const Quantity& quantity : quantities())
    list += fmt::format("  {:<39}{}\n", quantity.name, quantity.purpose);
  std::string help = footer;
  eval->footer(help.replace(help.find("{quantities}\n"), 13, list));
  eval->callback([options, &exit_code] {
    run(*options);
    exit_code = all_well;
  });
}

}  // namespace axode::command
