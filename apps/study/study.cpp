#include "apps/study/study.hpp"

#include <fmt/format.h>

#include <cmath>

#include "apps/commands/chart.hpp"
#include "apps/files/csv_file.hpp"
#include "apps/files/json_text.hpp"
#include "apps/files/text_file.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/table.hpp"
#include "apps/shell/terminal.hpp"
#include "apps/study/call_timer.hpp"
#include "apps/study/study_command.hpp"
#include "axode/dynamics/mass_matrix/mass_matrix.hpp"

namespace axode::command {
namespace {

/// A kind of operation that is counted: its heading in a table, and its name in a file.
struct Column {
  std::string_view heading, name;
  long (*count)(const Operations&);
};
template <ScrewOperation kind> long count_of(const Operations& x) { return x[kind]; }
constexpr std::array<Column, 12> columns{
    {{"mul", "mul", [](const Operations& x) { return x.products; }},
     {"add", "add", [](const Operations& x) { return x.sums; }},
     {"div", "div", [](const Operations& x) { return x.divisions; }},
     {"sqrt", "sqrt", [](const Operations& x) { return x.roots; }},
     {"sin cos", "sin_cos", [](const Operations& x) { return x.angles; }},
     {"Ad", "screw_transformations", count_of<ScrewOperation::transformation>},
     {"Ad_R", "screw_rotations", count_of<ScrewOperation::rotation>},
     {"Ad_r", "screw_translations", count_of<ScrewOperation::translation>},
     {"M Ad", "tensor_transformations", count_of<ScrewOperation::tensor_transformation>},
     {"M Ad_R", "tensor_rotations", count_of<ScrewOperation::tensor_rotation>},
     {"M Ad_r", "tensor_translations", count_of<ScrewOperation::tensor_translation>},
     {"ad", "brackets", count_of<ScrewOperation::bracket>}}};

constexpr std::string_view fast = "fast";
constexpr std::array<std::string_view, 5> ways_to_compute{"body", "spatial", "hybrid", "mixed", fast};
constexpr std::array<std::string_view, 4> frame_choices{"joint", "user", "com", "construction"};

/// A representation and a choice of body frames, in which all algorithms are run.
struct Variant {
  std::string_view frames, representation;
  std::unique_ptr<Subject> subject;
  Operations (*operations)(Algorithm, const Model&, const State&);
};

template <class Frames>
void add_variants(std::vector<Variant>& variants, std::string_view frames, const Model& model,
                  const State& state) {
  for (const auto& [name, representation] : representations)
    with_representation(representation, [&, name = name](auto rep) {
      variants.push_back({frames, name, make_subject<decltype(rep), Frames>(model, state),
                          operations<decltype(rep), Frames>});
    });
  if constexpr (std::same_as<Frames, JointFrames>)
    variants.push_back(
        {frames, fast, make_subject<Fast, JointFrames>(model, state), operations<Fast, JointFrames>});
}

std::vector<Variant> variants_of(const Model& model, const State& state) {
  std::vector<Variant> variants;
  add_variants<JointFrames>(variants, "joint", model, state);
  add_variants<UserFrames>(variants, "user", model, state);
  add_variants<MassCenterFrames>(variants, "com", model, state);
  add_variants<ConstructionFrames>(variants, "construction", model, state);
  return variants;
}

/// Shows a line on the terminal during long computations, if standard error is a terminal.
void show_progress(std::string_view text) {
  if (!is_terminal(stderr)) return;
  fmt::print(stderr, "\r\033[K{}", text);
  std::fflush(stderr);
}

bool needs_mass_matrix_inverse(Algorithm algorithm) {
  return algorithm == Algorithm::forward_dynamics || algorithm == Algorithm::inverse_mass_matrix ||
         algorithm == Algorithm::momentum_form;
}

Study studied(const Model& model, bool with_times) {
  constexpr int rounds = 6, batches = 50;  // there are several rounds, so that a temporary load of the
                                           // machine slows all variants alike
  const State state = random_state(model);
  Study study{model.name(), model.n_bodies(), model.nv(), {}, {}, {}, {}, {}};
  Workspace<> workspace(model);
  std::vector<double> inverse(static_cast<std::size_t>(model.nv()) * static_cast<std::size_t>(model.nv()));
  const Solvability solvability = inverse_mass_matrix<Hybrid>(model, workspace, state.q, inverse);
  if (!solvability.ok())
    study.left_out = "forward_dynamics, inverse_mass_matrix and momentum_form are left out: " +
                     to_string(model, solvability);

  if (solvability.ok()) study.contraction = contraction_counts(model, state);
  const std::vector<Variant> variants = variants_of(model, state);
  std::vector<CallTimer> timers;
  for (const auto& [name, algorithm] : algorithms)
    for (const Variant& variant : variants) {
      if (!variant.subject->can(algorithm) || (!solvability.ok() && needs_mass_matrix_inverse(algorithm)))
        continue;
      study.efforts.push_back({algorithm,
                               variant.frames,
                               variant.representation,
                               variant.operations(algorithm, model, state),
                               {}});
      if (!with_times) continue;
      timers.emplace_back(
          [&subject = *variant.subject, algorithm = algorithm](int calls) { subject.run(algorithm, calls); });
    }
  std::vector<std::unique_ptr<WaySubject>> subjects;
  for (const Way& way : ways()) {
    study.ways.push_back({way, operations(way, model, state), {}});
    if (!with_times) continue;
    subjects.push_back(make_subject(way, model, state));
    timers.emplace_back([&subject = *subjects.back()](int calls) { subject.run(calls); });
  }
  if (with_times)
    for (int round = 0; round < rounds; ++round) {
      show_progress(fmt::format("{}: round {} of {}", model.name(), round + 1, rounds));
      for (CallTimer& timer : timers) timer.sample(batches);
    }
  show_progress("");
  for (std::size_t k = 0; k < timers.size(); ++k)
    (k < study.efforts.size() ? study.efforts[k].seconds : study.ways[k - study.efforts.size()].seconds) =
        timers[k].median();
  return study;
}

/// A count in a table, where 0 is left out.
Cell cell(long count) { return count == 0 ? Cell("") : Cell(static_cast<double>(count)); }
/// The time of an effort that was measured.
template <class Measured> double nanoseconds(const Measured& effort) {
  return std::round(1e10 * *effort.seconds) / 10;
}

void print_ways(const std::vector<WayEffort>& ways) {
  std::vector<std::string> headings{"algorithm", "way", "representation"};
  for (const Column& column : columns) headings.emplace_back(column.heading);
  headings.emplace_back("in all");
  if (ways.front().seconds) headings.emplace_back("ns");
  Table table(headings);
  std::string_view algorithm;
  for (const WayEffort& effort : ways) {
    if (!algorithm.empty() && effort.way.algorithm != algorithm) table.rule();
    std::vector<Cell> row{std::string(effort.way.algorithm == algorithm ? "" : effort.way.algorithm),
                          std::string(effort.way.name), std::string(word_for(effort.way.representation))};
    algorithm = effort.way.algorithm;
    for (const Column& column : columns) row.push_back(cell(column.count(effort.operations)));
    row.push_back(cell(effort.operations.total()));
    if (effort.seconds) row.emplace_back(nanoseconds(effort));
    table.row(std::move(row));
  }
  fmt::print("\n{}\n{}", in(Ink::heading, "several ways, in joint frames"), table.text());
}

void print_contraction(const std::vector<ContractionCount>& counts) {
  if (counts.empty()) return;
  Table table({"compressions", "rounds", "operations", "longest path"});
  for (const ContractionCount& count : counts)
    table.row({Cell(static_cast<double>(count.compressions)), Cell(static_cast<double>(count.rounds)),
               Cell(static_cast<double>(count.operations.total())),
               Cell(static_cast<double>(count.longest_path))});
  fmt::print("\n{}\n{}", in(Ink::heading, "forward_dynamics by contraction of the tree"), table.text());
}

void print_rounding(const std::vector<RoundingErrors>& rounding) {
  if (rounding.empty()) return;
  Table table({"algorithm", "m", "heavier", "condition", "body", "spatial", "inertial", "hybrid", "mixed"});
  const auto add = [&](const char* algorithm, const RoundingErrors& row, const RoundingErrors::Of& of) {
    std::vector<Cell> cells{Cell(algorithm), Cell(row.distance), Cell(row.heaviness)};
    for (const double x : {row.condition, of.body, of.spatial, of.inertial, of.hybrid, of.mixed})
      cells.emplace_back(fmt::format("{:.0e}", x));
    table.row(std::move(cells));
  };
  for (const RoundingErrors& row : rounding) add("inverse_dynamics", row, row.inverse_dynamics);
  table.rule();
  for (const RoundingErrors& row : rounding) add("forward_dynamics", row, row.forward_dynamics);
  fmt::print("\n{}\n{}", in(Ink::heading, "rounding errors"), table.text());
}

void print_drift(const std::vector<Drift>& drift) {
  if (drift.empty()) return;
  Table table({"joints", "step", "SE(3)", "SO(3) x R^3", "by joint"});
  const auto add = [&](const char* joints, double Drift::Of::*of) {
    for (const Drift& row : drift) {
      std::vector<Cell> cells{Cell(joints), Cell(fmt::format("1/{:.0f} s", 1 / row.step))};
      for (const Drift::Of* const group : {&row.SE3, &row.SO3xR3, &row.by_joint})
        cells.emplace_back(fmt::format("{:.0e}", group->*of));
      table.row(std::move(cells));
    }
  };
  add("on the ground", &Drift::Of::joints_on_ground);
  table.rule();
  add("all", &Drift::Of::all_joints);
  fmt::print("\n{}\n{}",
             in(Ink::heading, "drift of joints in absolute coordinates without projection, rad and m"),
             table.text());
}

void print(const Study& study) {
  fmt::print("{}\n", in(Ink::heading, fmt::format("{}: {} moving bodies, nv = {}", study.model, study.bodies,
                                                  study.velocities)));
  if (!study.left_out.empty()) fmt::print("{}\n", in(Ink::warning, study.left_out));
  for (const auto& [name, algorithm] : algorithms) {
    std::vector<std::string> headings{"frames", "representation"};
    for (const Column& column : columns) headings.emplace_back(column.heading);
    if (study.timed()) headings.emplace_back("ns");
    Table table(headings);
    std::string_view frames;
    for (const Effort& effort : study.efforts) {
      if (effort.algorithm != algorithm) continue;
      if (!frames.empty() && effort.frames != frames) table.rule();
      std::vector<Cell> row{std::string(effort.frames == frames ? "" : effort.frames),
                            std::string(effort.representation)};
      frames = effort.frames;
      for (const Column& column : columns) row.push_back(cell(column.count(effort.operations)));
      if (effort.seconds) row.emplace_back(nanoseconds(effort));
      table.row(std::move(row));
    }
    if (!table.empty()) fmt::print("\n{}\n{}", in(Ink::heading, name), table.text());
  }
  print_ways(study.ways);
  print_contraction(study.contraction);
  print_rounding(study.rounding);
  print_drift(study.drift);
}

std::string as_csv(const std::vector<Study>& studies) {
  std::string out = "model,bodies,velocities,algorithm,frames,representation";
  for (const Column& column : columns) out += fmt::format(",{}", column.name);
  out += ",ns\n";
  for (const Study& study : studies)
    for (const Effort& effort : study.efforts) {
      out += fmt::format("{},{},{},{},{},{}", quoted(study.model), study.bodies, study.velocities,
                         word_for(effort.algorithm, algorithms), effort.frames, effort.representation);
      for (const Column& column : columns) out += fmt::format(",{}", column.count(effort.operations));
      out += effort.seconds ? fmt::format(",{}\n", nanoseconds(effort)) : ",\n";
    }
  return out;
}

Json as_json(const std::vector<Study>& studies) {
  Json out = Json::array();
  for (const Study& study : studies) {
    Json efforts = Json::array();
    for (const Effort& effort : study.efforts) {
      Json row{{"algorithm", word_for(effort.algorithm, algorithms)},
               {"frames", effort.frames},
               {"representation", effort.representation}};
      for (const Column& column : columns) row[std::string(column.name)] = column.count(effort.operations);
      if (effort.seconds) row["ns"] = nanoseconds(effort);
      efforts.push_back(row);
    }
    out.push_back({{"model", study.model},
                   {"bodies", study.bodies},
                   {"velocities", study.velocities},
                   {"efforts", efforts}});
    for (const WayEffort& effort : study.ways) {
      Json row{{"algorithm", effort.way.algorithm},
               {"way", effort.way.name},
               {"representation", word_for(effort.way.representation)}};
      for (const Column& column : columns) row[std::string(column.name)] = column.count(effort.operations);
      if (effort.seconds) row["ns"] = nanoseconds(effort);
      out.back()["ways"].push_back(row);
    }
    for (const ContractionCount& count : study.contraction)
      out.back()["contraction"].push_back({{"compressions", count.compressions},
                                           {"rounds", count.rounds},
                                           {"operations", count.operations.total()},
                                           {"longest_path", count.longest_path}});
    for (const Drift& row : study.drift) {
      const auto as_object = [](const Drift::Of& of) {
        return Json{{"joints_on_ground", of.joints_on_ground}, {"all_joints", of.all_joints}};
      };
      out.back()["drift"].push_back({{"step", row.step},
                                     {"SE3", as_object(row.SE3)},
                                     {"SO3xR3", as_object(row.SO3xR3)},
                                     {"by_joint", as_object(row.by_joint)}});
    }
    for (const RoundingErrors& row : study.rounding) {
      const auto as_object = [](const RoundingErrors::Of& of) {
        return Json{{"body", of.body},
                    {"spatial", of.spatial},
                    {"inertial", of.inertial},
                    {"hybrid", of.hybrid},
                    {"mixed", of.mixed}};
      };
      out.back()["rounding"].push_back({{"distance", row.distance},
                                        {"heaviness", row.heaviness},
                                        {"condition", row.condition},
                                        {"inverse_dynamics", as_object(row.inverse_dynamics)},
                                        {"forward_dynamics", as_object(row.forward_dynamics)}});
    }
    if (!study.left_out.empty()) out.back()["left_out"] = study.left_out;
  }
  return out;
}

/// The horizontal position of a bar in the chart of costs, grouped by the choice of body frames.
double place_of(const Effort& effort) {
  const auto number = [](const auto& names, std::string_view name) {
    return static_cast<int>(std::ranges::find(names, name) - names.begin());
  };
  const int frames = number(frame_choices, effort.frames);
  return number(ways_to_compute, effort.representation) + (frames == 0 ? 0 : 5.8 + 4.8 * (frames - 1));
}

Panel panel_of(const Study& study, Algorithm algorithm) {
  Panel panel{.title = study.model + ": " + std::string(word_for(algorithm, algorithms)), .y_axis = "µs"};
  for (std::size_t k = 0; k < ways_to_compute.size(); ++k)
    panel.curves.push_back(
        {.name = std::string(ways_to_compute[k]), .kind = Curve::bars, .color = static_cast<int>(k)});
  Curve operations{.name = "operations", .kind = Curve::marks};
  double scale = 0;
  for (const Effort& effort : study.efforts) {
    if (effort.algorithm != algorithm) continue;
    const Operations& all = effort.operations;
    const double sum = static_cast<double>(all.products + all.sums + all.divisions + all.roots + all.angles);
    const double microseconds = 1e6 * *effort.seconds, x = place_of(effort);
    if (scale == 0) scale = microseconds / sum;
    Curve& bars = panel.curves[static_cast<std::size_t>(
        std::ranges::find(ways_to_compute, effort.representation) - ways_to_compute.begin())];
    bars.x.push_back(x);
    bars.y.push_back(microseconds);
    operations.x.push_back(x);
    operations.y.push_back(scale * sum);
  }
  if (scale == 0) return {};
  panel.curves.push_back(operations);
  panel.x_ticks = {{2, "joint"}, {7.3, "user"}, {12.1, "com"}, {16.9, "constr."}};
  panel.x_range = {-0.8, 18.8};
  return panel;
}

/// The chart of the studies, with a column for each model and a row for each algorithm.
Chart chart_of(const std::vector<Study>& studies) {
  Chart chart{
      .columns = static_cast<int>(studies.size()), .width = 240, .height = 130, .legend = Chart::below_all};
  for (const auto& [name, algorithm] : algorithms)
    for (const Study& study : studies) chart.panels.push_back(panel_of(study, algorithm));
  return chart;
}

}  // namespace

void run_study(const StudyOptions& options, const std::vector<Model>& models, char**) {
  std::vector<Study> studies;
  studies.reserve(models.size());
  for (const Model& model : models) {
    studies.push_back(studied(model, !options.counts));
    if (options.rounding && studies.back().left_out.empty()) studies.back().rounding = rounding_errors(model);
    if (options.drift) studies.back().drift = drifts(model);
  }
  if (!options.csv.empty()) write_text(options.csv, as_csv(studies));
  if (const std::optional<ChartFile> plot = chart_file(options.plot)) plot->draw(chart_of(studies));
  if (choose("--format", options.format, formats) == Format::json) {
    fmt::print("{}", text(as_json(studies)));
    return;
  }
  for (std::size_t k = 0; k < studies.size(); ++k) {
    if (k > 0) fmt::print("\n");
    print(studies[k]);
  }
}

}  // namespace axode::command
