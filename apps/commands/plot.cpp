#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <set>

#include "apps/commands/chart.hpp"
#include "apps/files/csv_file.hpp"
#include "apps/files/model_options.hpp"
#include "apps/files/text_file.hpp"
#include "apps/quantities/components.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"

/// The command `plot`: charts of tables in CSV files.
namespace axode::command {
namespace {

struct PlotOptions {
  std::vector<std::string> tables, columns;
  std::string picture, logarithmic;
  ModelOptions mechanism;
  bool bars = false;
};

constexpr const char* plot_footer =
    R"(TABLE is a CSV file with the names of its columns in the first line, as `axode simulate --output
run.csv` writes it. The first column is the horizontal axis, and each other column is a curve. Columns
with the same first word, or the same words before a colon, share a panel of that name: "q pin" and "q
elbow" are the curves pin and elbow of the panel q. Cells that are empty or not finite are left out, and
on logarithmic axes also numbers that are not above 1e-307. Each table has its own panels, side by side; a
chart has room for 60 panels.

With --model, the mechanism of the motion in a table, each panel has one unit, and a curve has the name of
its joint and the colour of its body in the viewer.

Example:
  axode simulate four_bar.toml --until 2 --output run.csv
  axode plot run.csv --model four_bar.toml --output run.svg
  axode plot run.csv --columns crank_joint,energy --output crank.svg

With --bars the first column has names, and each number is a bar.)";

constexpr std::size_t most_places = 60;
constexpr double least_on_logarithmic_axes = 1e-307;  // gnuplot treats subnormal numbers as 0

struct Logarithmic {
  bool x = false, y = false;
};
constexpr std::array<std::pair<std::string_view, Logarithmic>, 3> logarithmic_axes{
    {{"x", {true, false}}, {"y", {false, true}}, {"xy", {true, true}}}};

/// The panel and the curve that a column heading names, separated by the first ": " or else the first blank.
std::pair<std::string, std::string> split(const std::string& heading) {
  const std::size_t colon = heading.find(": "), end = colon == std::string::npos ? heading.find(' ') : colon;
  if (end == std::string::npos) return {heading, ""};
  return {heading.substr(0, end), heading.substr(end + (end == colon ? 2 : 1))};
}

/// Reads a table from a CSV file and makes the panels of a chart.
class TableReader {
 public:
  TableReader(const std::string& file, const std::map<std::string, ColumnOfMotion>& known, bool bars,
              Logarithmic log, std::size_t most_panels)
      : file_(file), known_(known), bars_(bars), log_(log), most_panels_(most_panels) {}

  std::vector<Panel> panels() {
    for_rows_of_csv(file_, [&](std::size_t line, const std::vector<std::string>& cells) {
      if (curves_.empty()) return read_headings(cells);
      if (cells.size() != curves_.size() + 1)
        throw InputError(fmt::format("{}:{}: there are {} columns; the first line has {}", file_, line,
                                     cells.size(), curves_.size() + 1));
      read_numbers(line, cells);
    });
    if (rows_ == 0)
      throw InputError(file_ + ": expected a line with the names of columns, and numbers below it");
    std::vector<Panel> panels;
    for (std::size_t k = 0; k < curves_.size(); ++k) {
      const auto& [name, y_axis] = of_panels_[k];
      auto panel = std::ranges::find(panels, y_axis, &Panel::y_axis);
      if (panel == panels.end()) {
        panels.push_back(
            {.y_axis = y_axis, .x_ticks = ticks_, .log_x = log_.x, .log_y = log_.y, .name = name});
        panel = panels.end() - 1;
      }
      panel->curves.push_back(std::move(curves_[k]));
    }
    if (bars_)
      for (Panel& panel : panels) set_side_by_side(panel);
    panels.back().x_axis = x_axis_;
    return panels;
  }

 private:
  void read_headings(const std::vector<std::string>& cells) {
    if (cells.size() == 1)
      throw InputError(
          file_ +
          ": there is only one column; the first one is the horizontal axis, and the others are drawn");
    if (std::ranges::all_of(cells, [](const std::string& cell) { return number_in(cell).has_value(); }))
      throw InputError(file_ + ": the first line has numbers; write the names of the columns there");
    x_axis_ = with_unit(cells.front());
    for (std::size_t k = 1; k < cells.size(); ++k) {
      auto [panel, name] = split(cells[k]);
      Curve curve{.name = std::move(name)};
      const auto known = known_.find(cells[k]);
      if (known != known_.end()) panel = known->second.symbol;
      if (known != known_.end() && known->second.component) curve = curve_of(*known->second.component);
      curve.kind = bars_ ? Curve::bars : Curve::line;
      curves_.push_back(std::move(curve));
      of_panels_.emplace_back(panel, known == known_.end() ? panel : panel + ", " + known->second.unit);
    }
    const std::size_t count = std::set(of_panels_.begin(), of_panels_.end()).size();
    if (count > most_panels_)
      throw InputError(fmt::format(
          "{}: its columns make {} panels, one of each first word; a chart has {} places, {} for this table",
          file_, count, most_places, most_panels_));
  }

  std::string with_unit(const std::string& heading) const {
    const auto known = known_.find(heading);
    return known == known_.end() ? heading : heading + ", " + known->second.unit;
  }

  double number(std::size_t line, const std::string& cell) const {
    if (cell.empty()) return NAN;
    const std::optional<double> x = number_in(cell);
    if (!x) throw InputError(fmt::format("{}:{}: \"{}\" is not a number", file_, line, cell.substr(0, 40)));
    return *x;
  }

  void read_numbers(std::size_t line, const std::vector<std::string>& cells) {
    const double x = bars_ ? static_cast<double>(rows_) : number(line, cells.front());
    if (bars_) ticks_.emplace_back(x, cells.front());
    ++rows_;
    for (std::size_t k = 0; k < curves_.size(); ++k) {
      const double y = number(line, cells[k + 1]);
      if (!is_drawn(x, log_.x) || !is_drawn(y, log_.y)) continue;
      curves_[k].x.push_back(x);
      curves_[k].y.push_back(y);
    }
  }

  static bool is_drawn(double number, bool logarithmic) {
    return std::isfinite(number) && (!logarithmic || number >= least_on_logarithmic_axes);
  }

  /// Places the bars that have the same name on the horizontal axis side by side; together they are 0.8 wide.
  static void set_side_by_side(Panel& panel) {
    const auto count = static_cast<double>(panel.curves.size());
    panel.bar_width = 0.8 / count;
    for (std::size_t k = 0; k < panel.curves.size(); ++k)
      for (double& x : panel.curves[k].x) x += (static_cast<double>(k) - (count - 1) / 2) * panel.bar_width;
    panel.x_range = {-0.5, static_cast<double>(panel.x_ticks.size()) - 0.5};
  }

  const std::string& file_;
  const std::map<std::string, ColumnOfMotion>& known_;
  bool bars_;
  Logarithmic log_;
  std::size_t most_panels_;
  std::string x_axis_;
  std::vector<std::pair<std::string, std::string>>
      of_panels_;  ///< the name and the axis of each curve's panel
  std::vector<Curve> curves_;
  std::vector<std::pair<double, std::string>> ticks_;
  std::size_t rows_ = 0;
};

void run(const PlotOptions& options, int& exit_code) {
  const Logarithmic logarithmic =
      options.logarithmic.empty() ? Logarithmic{} : choose("--log", options.logarithmic, logarithmic_axes);
  if (options.bars && (logarithmic.x || logarithmic.y))
    throw UsageError("--bars excludes --log; bars begin at 0, which has no logarithm");
  const ChartFile picture("--output", options.picture);
  std::map<std::string, ColumnOfMotion> known;
  if (!options.mechanism.files.empty()) known = columns_of_motion(load(options.mechanism));
  std::vector<std::vector<Panel>> of_tables;
  std::size_t rows = 0;
  Chart chart{.columns = static_cast<int>(options.tables.size())};
  for (const std::string& table : options.tables) {
    of_tables.push_back(
        TableReader(table, known, options.bars, logarithmic, most_places / options.tables.size()).panels());
    rows = std::max(rows, of_tables.back().size());
    of_tables.back().front().title = std::filesystem::path(table).stem().string();
  }
  if (chart.columns > 1) chart.width = 400;
  if (rows == 1) chart.height = 320;
  for (std::size_t row = 0; row < rows; ++row)
    for (std::vector<Panel>& panels : of_tables)
      chart.panels.push_back(row < panels.size() ? std::move(panels[row]) : Panel{});
  keep_columns(chart, options.columns);
  picture.draw(chart);
  fmt::print("{}: {} of {}\n", options.picture, options.bars ? "bars" : "curves",
             fmt::join(options.tables, ", "));
  exit_code = all_well;
}

}  // namespace

void add_plot(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<PlotOptions>();
  CLI::App* plot = app.add_subcommand("plot", "Draw a chart of columns of numbers");
  plot->add_option("TABLE", options->tables, "CSV files, or - for standard input")
      ->required()
      ->type_name("FILE");
  plot->add_option("--output", options->picture, "The .svg or .png to draw")->required()->type_name("FILE");
  plot->add_option("--log", options->logarithmic, "Logarithmic axes; default: none")
      ->type_name(words(logarithmic_axes));
  CLI::Option* model = plot->add_option("--model", options->mechanism.files,
                                        "The drawing (.toml), URDF or SDFormat that moves")
                           ->type_name("FILE")
                           ->expected(1);
  plot->add_option("--base", options->mechanism.base, "How its base is held; as the file says if left out")
      ->type_name("fixed|free")
      ->needs(model);
  add_columns_option(*plot, options->columns);
  plot->add_flag("--bars", options->bars, "Bars instead of curves");
  plot->footer(plot_footer);
  plot->callback([options, &exit_code] { run(*options, exit_code); });
}

}  // namespace axode::command
