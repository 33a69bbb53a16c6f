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
  };                      ///< how the curve is drawn; marks are short horizontal lines
                          ///< across a bar
  std::string name = {};  ///< entry in the legend; if empty, there is none
  std::vector<double> x = {}, y = {};
  Kind kind = line;
  int color = -1;  ///< index in the palette; -1 stands for the index of the curve, and for black if the curve
                   ///< is marks
  std::vector<std::string> of = {};  ///< further names by which --columns finds the curve
};

struct Panel {
  std::string title = {}, x_axis = {}, y_axis = {};
  std::vector<Curve> curves = {};
  std::vector<std::pair<double, std::string>> x_ticks = {};  ///< positions and texts that replace the numbers
                                                             ///< of the axis
  std::optional<std::pair<double, double>> x_range = {};     ///< range of the axis; if empty, that of the
                                                             ///< curves
  bool axes_through_zero = false;
  bool log_x = false, log_y = false;
  double bar_width = 0.85;
  std::string name = {};  ///< name by which --columns finds all curves of the panel
};

struct Chart {
  enum Legend { beside_each, below_all };  ///< below_all shows only the legend of the first panel
  std::string title = {};
  std::vector<Panel> panels = {};  ///< row by row; a panel without curves is left empty
  int columns = 1;
  int width = 640, height = 180;  ///< pixels of a panel
  Legend legend = beside_each;
};

/// The picture that an option names.
class ChartFile {
 public:
  /// Checks the file of an option. Throws UsageError if the ending is neither .svg nor .png, InputError if
  /// gnuplot is missing.
  ChartFile(std::string option, std::string file);

  /// Draws the chart. Of a panel with many lines it draws those that change most, and of a long line as many
  /// points as can be distinguished. Throws InputError if the file cannot be written.
  void draw(const Chart& chart) const;

 private:
  enum class Format { svg, png };
  std::string option_, file_;
  Format format_;
};

void add_plot_option(CLI::App& command, std::string& file);
/// The option --columns of a command that draws a chart.
void add_columns_option(CLI::App& command, std::vector<std::string>& columns);
/// Keeps the curves that the words of --columns name: all curves of a panel, a curve by its own name or by
/// another of its names, or one curve of a panel by both names. Without words it keeps all curves. Throws
/// UsageError if a word names no curve.
void keep_columns(Chart& chart, const std::vector<std::string>& columns);
/// The picture of an option; empty if the option names no file.
std::optional<ChartFile> chart_file(const std::string& file);

}  // namespace axode::command
