#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
}

/// Charts of numbers for all commands, drawn by gnuplot.
namespace axode::command {

struct Curve {
  enum Kind {
    line,
    points,
    bars,
    marks
  };                      ///< how a curve is drawn; marks are short horizontal lines
                          ///< across bars
  std::string name = {};  ///< entry in the legend; if empty, there is none
  std::vector<double> x = {}, y = {};
  Kind kind = line;
  int color = -1;  ///< index in the palette; -1: index of the curve in its panel, or black for marks
  std::vector<std::string> of = {};  ///< further names by which --columns finds the curve
  int body = 0;  ///< the body whose colour it has if that tells the curves of its panel apart; 0 for none
};

struct Panel {
  std::string title = {}, x_axis = {}, y_axis = {};
  std::vector<Curve> curves = {};
  std::vector<std::pair<double, std::string>> x_ticks = {};  ///< positions and texts that replace the numbers
                                                             ///< of the axis
  std::optional<std::pair<double, double>> x_range = {};     ///< range of the axis; if empty, the range
                                                             ///< of the curves
  bool axes_through_zero = false;
  bool log_x = false, log_y = false;
  double bar_width = 0.85;
  std::string name = {};  ///< name by which --columns finds all curves of the panel
};

struct Chart {
  enum Legend { beside_each, below_all };  ///< below_all: only that of the first panel, below the chart
  std::string title = {};
  std::vector<Panel> panels = {};  ///< row by row; the place of a panel without curves stays empty
  int columns = 1;
  int width = 640, height = 180;  ///< pixels of a panel
  Legend legend = beside_each;
};

/// The file of a picture that an option of a command names.
class ChartFile {
 public:
  /// Throws UsageError unless the file's name ends in .svg or .png, and InputError if gnuplot is missing.
  ChartFile(std::string option, std::string file);

  /// Draws the chart into the file. Throws InputError if the file cannot be written.
  void draw(const Chart& chart) const;

 private:
  enum class Format { svg, png };
  std::string option_, file_;
  Format format_;
};

void add_plot_option(CLI::App& command, std::string& file);
/// Adds the option --columns to a command that draws a chart.
void add_columns_option(CLI::App& command, std::vector<std::string>& columns);
/// Keeps only the curves of a chart that an entry of `columns` names, or all curves if it is empty. An entry
/// is the name of a panel, which names all of its curves; a name of a curve; or the name of a panel and a
/// name of one of its curves. Throws UsageError if an entry names no curve.
void keep_columns(Chart& chart, const std::vector<std::string>& columns);
/// The file of a picture that an option names; empty if the option has no value.
std::optional<ChartFile> chart_file(const std::string& file);

}  // namespace axode::command
