#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>

#include "apps/commands/assembling.hpp"
#include "apps/files/json_text.hpp"
#include "apps/files/model_options.hpp"
#include "apps/files/state.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/table.hpp"
#include "apps/shell/terminal.hpp"
#include "axode/constraints/local_mobility/local_mobility.hpp"
#include "axode/model/configuration.hpp"

namespace axode::command {
namespace {

struct MobilityOptions {
  ModelOptions mechanism;
  std::string state, format = "table";
  Assembling assembling;
  LocalMobilityOptions mobility;
};

constexpr const char* mobility_footer =
    R"(A mechanism with loops may have fewer or other motions than its differential mobility suggests. The
command prints how many velocities satisfy the closure of the loops up to order 1, 2, ..., the motions that
begin at the configuration, with tangent and curvature, and words for it: regular, branch point,
kinematotropic, cusp, shaky, rigid at order m, kinematic singularity, dead points and idle drives. Ranks are
decided numerically; points that were closed near the configuration are evidence, and the last lines say so.

STATE is the JSON object of `axode eval` with the key q. Loops have to be closed at q; --assemble closes them.
Lengths are divided by the length of --length before they are compared with angles, by default the mean
distance between two joints.

Example:
  axode mobility bricard.toml --order 6)";

constexpr double rounding = 1e-13;

using Names = std::vector<std::string>;

Names names_of(const std::vector<ClosureCoordinate>& coordinates, const std::vector<int>& which) {
  Names out;
  for (const int c : which) out.push_back(coordinates[static_cast<std::size_t>(c)].name);
  return out;
}
Names names_of(const Names& loops, const std::vector<int>& which) {
  Names out;
  for (const int l : which) out.push_back(loops[static_cast<std::size_t>(l)]);
  return out;
}

double without_rounding(double x) { return std::abs(x) < rounding ? 0 : x; }

/// The numbers, of which those that are rounding errors are set to 0.
std::vector<double> numbers(const Eigen::Ref<const Eigen::VectorXd>& x) {
  std::vector<double> out(x.begin(), x.end());
  for (double& entry : out) entry = without_rounding(entry);
  return out;
}
Json rows(const Eigen::MatrixXd& A) {
  Json out = Json::array();
  for (Eigen::Index k = 0; k < A.rows(); ++k) out.push_back(numbers(A.row(k).transpose()));
  return out;
}

Json as_json(const LocalMobility& found, const MotionBranch& branch) {
  Json points = Json::array();
  for (const BranchPoint& point : branch.points)
    points.push_back({{"parameter", numbers(point.parameter)},
                      {"x", numbers(point.x)},
                      {"q", point.q},
                      {"residual", point.residual}});
  return {{"dimension", branch.dimension},
          {"cusp", branch.cusp()},
          {"power", branch.power},
          {"multiple", branch.multiple},
          {"settled", branch.settled},
          {"closes", branch.closes},
          {"differential_mobility_beside", branch.differential_mobility_beside},
          {"loops", names_of(found.loops, branch.loops)},
          {"dead", names_of(found.coordinates, branch.dead)},
          {"idle", names_of(found.coordinates, branch.idle)},
          {"tangent", rows(branch.T)},
          {"second_form", rows(branch.II)},
          {"series", rows(branch.series)},
          {"residual_orders", branch.residual_orders},
          {"points", points}};
}

Json as_json(const Model& model, const LocalMobility& found) {
  Json coordinates = Json::array(), conditions = Json::array(), branches = Json::array();
  for (const ClosureCoordinate& coordinate : found.coordinates) coordinates.push_back(coordinate.name);
  for (const MobilityCondition& condition : found.conditions)
    conditions.push_back({{"degree", condition.degree}, {"loops", names_of(found.loops, condition.loops)}});
  for (const MotionBranch& branch : found.branches) branches.push_back(as_json(found, branch));
  Names outside;
  for (const int c : found.outside) outside.push_back(velocity_names(model)[static_cast<std::size_t>(c)]);
  return {{"words", mobility_words(model, found)},
          {"local_mobility", found.local_mobility},
          {"differential_mobility", found.differential_mobility},
          {"mobility_by_order", found.mobility_by_order},
          {"settled", found.settled},
          {"settled_at_order", found.settled_at_order},
          {"rigid_at_order", found.rigid_at_order},
          {"order", found.order},
          {"length", found.length},
          {"loops", found.loops},
          {"equations", found.equations},
          {"rank", found.rank},
          {"smallest_kept", found.smallest_kept},
          {"largest_dropped", found.largest_dropped},
          {"decided_by_rank", found.decided_by_rank},
          {"conditions", conditions},
          {"coordinates", coordinates},
          {"outside", outside},
          {"branches", branches},
          {"probe",
           {{"starts", found.probe.starts}, {"closed", found.probe.closed}, {"missed", found.probe.missed}}}};
}

std::string ranks(const LocalMobility& found) {
  std::string text = fmt::format(
      "mobility by order: {}; {}\nlocal mobility {}, differential mobility {}\n{} equations of {} have rank "
      "{}",
      fmt::join(found.mobility_by_order, ", "),
      found.settled ? fmt::format("settled at order {}", found.settled_at_order)
                    : fmt::format("not settled up to order {}", found.order),
      found.local_mobility, found.differential_mobility, found.equations, fmt::join(found.loops, ", "),
      found.rank);
  text += found.rank == found.equations
              ? fmt::format("; the smallest singular value is {}\n", significant(found.smallest_kept, 2))
              : fmt::format("; singular values on either side of it are {} and {}\n",
                            significant(found.smallest_kept, 2),
                            significant(without_rounding(found.largest_dropped), 2));
  for (const MobilityCondition& condition : found.conditions)
    text += fmt::format("a condition of degree {} from {}\n", condition.degree,
                        fmt::join(names_of(found.loops, condition.loops), ", "));
  if (!found.outside.empty())
    text += fmt::format("{} in no loop are left out; each adds 1\n",
                        counted(found.outside.size(), "velocity", "velocities"));
  return text;
}

/// Returns a table of one branch of the motion of a mechanism: a curve or surface of configurations through
/// the given one. The table has a row for each coordinate. Its columns are the tangent vectors of the branch
/// and, for a curve, the curvature; for a curve with a cusp they are the first two coefficients of its power
/// series instead. The last column says whether the coordinate is constant along the whole branch (idle) or
/// has the rate 0 only at the given configuration (dead point).
std::string coordinates_table(const LocalMobility& found, const MotionBranch& branch) {
  std::vector<std::string> headings{"joint"};
  std::vector<std::vector<double>> columns;
  const auto add = [&](std::string heading, const Eigen::VectorXd& x) {
    headings.push_back(std::move(heading));
    columns.push_back(numbers(x));
  };
  if (branch.dimension > 1) {
    for (int a = 0; a < branch.dimension; ++a) add(fmt::format("T{}", a + 1), branch.T.row(a).transpose());
  } else {
    add(branch.cusp() ? fmt::format("zeta^{}", branch.power) : "tangent", branch.T.row(0).transpose());
    if (branch.cusp()) {
      if (branch.series.cols() > branch.power + 1)
        add(fmt::format("zeta^{}", branch.power + 1), branch.series.col(branch.power + 1));
    } else if (branch.II.rows() > 0) {
      add("curvature", branch.II.row(0).transpose());
    }
  }
  headings.emplace_back("at rest");
  Table table(headings);
  for (std::size_t c = 0; c < found.coordinates.size(); ++c) {
    std::vector<Cell> row{found.coordinates[c].name};
    for (const std::vector<double>& column : columns) row.emplace_back(column[c]);
    const auto is_in = [&](const std::vector<int>& list) {
      return std::ranges::find(list, static_cast<int>(c)) != list.end();
    };
    row.emplace_back(std::string(is_in(branch.dead) ? "dead point" : is_in(branch.idle) ? "idle" : ""));
    table.row(std::move(row));
  }
  return table.text();
}

std::string heading(const LocalMobility& found, std::size_t k) {
  const MotionBranch& branch = found.branches[k];
  std::string text = fmt::format("dimension {}", branch.dimension);
  if (branch.cusp()) text += ", a cusp: the mechanism moves in the direction of the tangent only";
  if (branch.multiple) text += ", a multiple solution of the closure equations";
  text += fmt::format("; moves {}", fmt::join(names_of(found.loops, branch.loops), ", "));
  if (branch.dimension > 1)
    text += fmt::format("; largest entry of the second form {}",
                        significant(branch.II.size() > 0 ? branch.II.cwiseAbs().maxCoeff() : 0, 3));
  if (branch.differential_mobility_beside > branch.dimension)
    text += fmt::format("; shaky: the differential mobility is {}", branch.differential_mobility_beside);
  return fmt::format("\n{}: {}\n", in(Ink::heading, fmt::format("branch {}", k + 1)), text);
}

std::string evidence(const LocalMobility& found) {
  std::string text = "\n" + in(Ink::heading, "evidence") + "\n";
  for (std::size_t k = 0; k < found.branches.size(); ++k) {
    const MotionBranch& branch = found.branches[k];
    double worst = 0;
    for (const BranchPoint& point : branch.points) worst = std::max(worst, point.residual);
    text += fmt::format("branch {}: {} close the loops to {}{}{}\n", k + 1,
                        counted(branch.points.size(), "point"),
                        worst < rounding ? "rounding" : significant(worst, 2),
                        branch.closes ? "" : "; some near q do not close",
                        branch.settled ? "" : "; too few orders are left to settle it");
  }
  text +=
      fmt::format("{} random starts near q led to {}; {} on no branch\n", found.probe.starts,
                  counted(static_cast<std::size_t>(found.probe.closed), "closed point"), found.probe.missed);
  return text + (found.decided_by_rank
                     ? "Ranks and roots alone decide this, up to rounding.\n"
                     : "The equations are dependent or several velocities are free: the points are evidence "
                       "for these motions, and no proof.\n");
}

void run(const MobilityOptions& options) {
  const Format format = choose("--format", options.format, formats);
  const Model model = load(options.mechanism);
  State state = options.state.empty() ? neutral_state(model) : read_state(model, options.state);
  assemble(model, options.assembling, state);
  const LocalMobility found = local_mobility(model, state.q, options.mobility);
  if (format == Format::json) {
    fmt::print("{}", text(as_json(model, found)));
    return;
  }
  fmt::print("{}: {}\n", in(Ink::heading, model.name()), fmt::join(mobility_words(model, found), ", "));
  if (found.coordinates.empty()) return;
  fmt::print("\n{}", ranks(found));
  for (std::size_t k = 0; k < found.branches.size(); ++k)
    fmt::print("{}{}", heading(found, k), coordinates_table(found, found.branches[k]));
  if (found.differential_mobility > 0) fmt::print("{}", evidence(found));
}

}  // namespace

void add_mobility(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<MobilityOptions>();
  CLI::App* mobility = app.add_subcommand("mobility", "Find what the loops let a mechanism do, to any order");
  add_model_options(*mobility, options->mechanism);
  mobility->add_option("--state", options->state, "JSON, - for standard input; default: neutral")
      ->type_name("FILE");
  add_assembly_options(*mobility, options->assembling);
  mobility->add_option("--order", options->mobility.order, "Highest order; default: chosen by the mechanism")
      ->check(CLI::Range(2, 20));
  mobility
      ->add_option("--length", options->mobility.length,
                   "Length by which lengths are divided, m; default: the mean distance between two joints")
      ->check(CLI::Validator(
          [](const std::string& word) {
            double length = 0;
            const bool positive = CLI::detail::lexical_cast(word, length) && length > 0;
            return positive ? "" : "\"" + word + "\" is not a positive number of m";
          },
          "POSITIVE"));
  mobility->add_option("--format", options->format, "Output format; default: table")
      ->type_name(words(formats));
  mobility->footer(mobility_footer);
  mobility->callback([options, &exit_code] {
    run(*options);
    exit_code = all_well;
  });
}

}  // namespace axode::command
