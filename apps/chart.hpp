#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
}

/// Pictures of numbers. One maker of charts for all commands, drawn by gnuplot.
namespace axode::command {

struct Curve {
  enum Kind { line, points, bars, marks };  ///< marks are short horizontal lines across a bar
  std::string name = {};                    ///< in the legend; empty: not there
  std::vector<double> x = {}, y = {};
  Kind kind = line;
  int color = -1;  ///< of the palette; -1: that of its place among the curves, of marks black
};

struct Panel {
  std::string title = {}, x_axis = {}, y_axis = {};
  std::vector<Curve> curves = {};
  std::vector<std::pair<double, std::string>> x_ticks = {};  ///< instead of numbers
  std::optional<std::pair<double, double>> x_range = {};     ///< instead of that of the curves
  bool axes_through_zero = false;
  bool log_x = false, log_y = false;
  double bar_width = 0.85;
};

struct Chart {
  enum Legend { beside_each, below_all };  ///< below all is that of the first panel
  std::string title = {};
  std::vector<Panel> panels = {};  ///< row by row; one without curves leaves its place empty
  int columns = 1;
  int width = 640, height = 180;  ///< of a panel, pixels
  Legend legend = beside_each;
};

/// The picture that an option names.
class ChartFile {
 public:
  /// Throws UsageError where the ending is neither .svg nor .png, InputError where gnuplot is missing.
  ChartFile(std::string option, std::string file);

  /// Of a panel with many lines those that change most are drawn, of a long line as many points as can be
  /// seen. Throws InputError where the file cannot be written.
  void draw(const Chart& chart) const;

 private:
  enum class Format { svg, png };
  std::string option_, file_;
  Format format_;
};

void add_plot_option(CLI::App& command, std::string& file);
/// None where no file was named.
std::optional<ChartFile> chart_file(const std::string& file);

}  // namespace axode::command
