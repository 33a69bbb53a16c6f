#include "apps/commands/chart.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>

#include "apps/files/json_text.hpp"
#include "apps/files/text_file.hpp"
#include "apps/quantities/curve_colors.hpp"
#include "apps/shell/choice.hpp"
#include "apps/shell/commands.hpp"
#include "apps/shell/gnuplot.hpp"
#include "apps/shell/table.hpp"

namespace axode::command {
namespace {

constexpr std::size_t most_lines = 8, most_points = 2000, longest_name = 60;
constexpr std::size_t most_dots = 50;  ///< a line of at most this number of points has dots at its points

/// The text as a string literal of gnuplot. All bytes except letters and blanks are written as octal numbers;
/// digits are written as octal numbers too, because gnuplot would read a digit that follows an octal number
/// as a part of it. Control characters become blanks, and bytes that are not UTF-8 become question marks.
std::string literal(const std::string& text) {
  const std::string valid =
      Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace)).get<std::string>();
  std::string out = "\"";
  for (const char c : valid) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      out += ' ';
    } else if (c == ' ' || (byte < 0x80 && std::isalpha(byte) != 0)) {
      out += c;
    } else {
      out += fmt::format("\\{:03o}", byte);
    }
  }
  return out + '"';
}

/// The text, shortened if it is wider than `longest` characters.
std::string shortened(std::string text, std::size_t longest) {
  if (width(text) <= longest) return text;
  while (width(text) > longest - 3) text.pop_back();
  return text + "...";
}
std::string in_legend(const Curve& curve) { return shortened(curve.name, longest_name); }

double range(const Curve& curve) {
  const auto [low, high] = std::ranges::minmax(curve.y);
  return high / 2 - low / 2;  // high - low could overflow
}

/// The curves of a panel that are drawn. If a panel has more lines than a chart can show clearly, these are
/// the lines that change most, in their original order.
std::vector<const Curve*> chosen(const Panel& panel) {
  std::vector<const Curve*> curves;
  for (const Curve& curve : panel.curves)
    if (!curve.y.empty()) curves.push_back(&curve);
  if (curves.size() <= most_lines || curves.front()->kind != Curve::line) return curves;
  std::vector<const Curve*> order = curves;
  std::ranges::stable_sort(order, std::ranges::greater(), [](const Curve* curve) { return range(*curve); });
  order.resize(most_lines);
  std::erase_if(curves, [&](const Curve* curve) { return std::ranges::find(order, curve) == order.end(); });
  return curves;
}

/// The indices of the points of a line that are drawn. If a line has too many points for a chart, it is
/// divided into parts of equal length, and the lowest and the highest point of each part are drawn.
std::vector<std::size_t> thinned(const std::vector<double>& y) {
  std::vector<std::size_t> places;
  const std::size_t parts = y.size() <= most_points ? y.size() : most_points / 2;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t first = part * y.size() / parts, end = (part + 1) * y.size() / parts;
    const auto begin = y.begin() + static_cast<std::ptrdiff_t>(first);
    const auto [low, high] = std::minmax_element(begin, y.begin() + static_cast<std::ptrdiff_t>(end));
    const auto a = static_cast<std::size_t>(low - y.begin()), b = static_cast<std::size_t>(high - y.begin());
    places.push_back(std::min(a, b));
    if (a != b) places.push_back(std::max(a, b));
  }
  return places;
}

/// The step between the numbers at an axis: the smallest of 1, 2 or 5 times a power of ten such that the
/// range `whole` has at most `most` steps. It is 0 if `whole` is not positive and finite.
double round_step(double whole, double most) {
  if (!(whole > 0) || !std::isfinite(whole)) return 0;
  const double power = std::pow(10, std::floor(std::log10(whole / most)));
  for (const double digit : {1.0, 2.0, 5.0})
    if (digit * power * most >= whole) return digit * power;
  return 10 * power;
}

/// The power of ten of the first digit of a positive number.
int power_of_ten(double x) { return static_cast<int>(std::floor(std::log10(x) + 1e-9)); }

/// The numbers beside a linear axis.
struct Ticks {
  double step = 0;            ///< from number to number; 0 if gnuplot chooses it
  std::string format = "%h";  ///< that of gnuplot
  std::size_t width = 8;      ///< characters of the longest number
};

/// Numbers with so many digits that no two of them look alike, at most `most` of them in a range.
Ticks ticks_in(double low, double high, double most) {
  const double step = round_step(high - low, most);
  const double first = step * std::floor(low / step), last = step * std::ceil(high / step);
  const double largest = std::max(std::abs(first), std::abs(last));
  if (step == 0 || !std::isfinite(largest)) return {};
  const int decimals = std::max(0, -power_of_ten(step)), power = power_of_ten(largest),
            digits = power - power_of_ten(step);
  const std::size_t sign = low < 0 ? 1 : 0;
  const std::size_t fixed =
      sign + static_cast<std::size_t>(std::max(power, 0) + 1 + decimals) + (decimals > 0 ? 1 : 0);
  const std::size_t floating =
      fmt::format("{:.{}e}", largest, digits).size() - 2 + sign + (std::abs(power) >= 10 ? 1 : 0);
  if ((decimals <= 5 && power < 6) || fixed <= floating) return {step, fmt::format("%.{}f", decimals), fixed};
  return {step, fmt::format("%.{}te%T", digits), floating};
}

/// Writes a chart as a script for gnuplot.
class Script {
 public:
  explicit Script(const Chart& chart) : chart_(chart) {
    for (const Panel& panel : chart.panels) {
      panels_.push_back(chosen(panel));
      if (chart.legend == Chart::below_all) continue;
      legend_ = std::max(legend_, width(note(panel)));
      for (const Curve* curve : panels_.back()) legend_ = std::max(legend_, width(in_legend(*curve)) + 4);
    }
    const int rows = (static_cast<int>(chart.panels.size()) + chart.columns - 1) / chart.columns;
    std::size_t longest = 0;
    for (std::size_t k = 0; k < panels_.size(); ++k)
      if (!panels_[k].empty())
        longest = std::max(longest, chart.panels[k].log_y ? 6 : y_ticks(panels_[k]).width);
    left_ = 36 + 10 * static_cast<int>(longest);
    right_ = legend_ == 0 ? 20 : 40 + 9 * static_cast<int>(legend_);
    titles_ =
        std::ranges::any_of(chart.panels, [](const Panel& panel) { return !panel.title.empty(); }) ? 16 : 0;
    gap_ = titles_ +
           (std::ranges::any_of(chart.panels, [&](const Panel& panel) { return slanted(panel); }) ? 104 : 62);
    size_ = {chart.columns * (left_ + chart.width + right_), top + rows * (chart.height + gap_) + bottom()};
  }

  bool empty() const {
    return std::ranges::all_of(panels_, [](const auto& curves) { return curves.empty(); });
  }

  std::string text(std::string_view terminal, int scale) {
    text_ = fmt::format(
        "set encoding utf8\nset terminal {} noenhanced size {},{} {}\n", terminal, scale * size_[0],
        scale * size_[1],
        scale == 1 ? "font \"sans-serif,12\""
                   : fmt::format("font \"sans,12\" fontscale {0} linewidth {0} pointscale {0}", scale));
    text_ +=
        "set border 3 linecolor rgb \"#777777\"\nset tics nomirror textcolor rgb \"#222222\"\n"
        "set grid linetype 1 linecolor rgb \"#e4e4e4\"\nset style fill solid 1 noborder\n";
    text_ += fmt::format("set multiplot\nset label 1 {} at screen {},{} left font \",15\"\n",
                         literal(shortened(chart_.title, static_cast<std::size_t>(size_[0] - left_) / 11)),
                         1.0 * left_ / size_[0], 1 - 20.0 / size_[1]);
    for (std::size_t k = 0; k < panels_.size(); ++k)
      if (!panels_[k].empty()) panel(k);
    if (chart_.legend == Chart::below_all) text_ += legend_below();
    return text_ + "unset multiplot\n";
  }

 private:
  static constexpr int top = 44;
  int bottom() const { return chart_.legend == Chart::below_all ? 48 : 0; }

  void panel(std::size_t place) {
    const Panel& panel = chart_.panels[place];
    const int row = static_cast<int>(place) / chart_.columns,
              column = static_cast<int>(place) % chart_.columns;
    const double x0 = column * (left_ + chart_.width + right_) + left_;
    const double y1 = size_[1] - top - titles_ - row * (chart_.height + gap_);
    const double y0 = y1 - chart_.height;
    text_ += fmt::format(
        "set lmargin at screen {}\nset rmargin at screen {}\nset bmargin at screen {}\nset tmargin at screen "
        "{}\n",
        x0 / size_[0], (x0 + chart_.width) / size_[0], y0 / size_[1], y1 / size_[1]);
    text_ += fmt::format("set title {} offset 0,-0.5\nset xlabel {}\n", literal(panel.title),
                         literal(panel.x_axis));
    // gnuplot's own label of the axis would be moved out of the picture by long numbers beside the axis.
    const double label_x = x0 - left_ + 12, label_y = (y0 + y1) / 2;
    text_ += fmt::format("set label 2 {} at screen {},{} center rotate by 90\n", literal(panel.y_axis),
                         label_x / size_[0], label_y / size_[1]);
    text_ += panel.axes_through_zero
                 ? "set xzeroaxis lt 1 lc rgb \"#777777\"\nset yzeroaxis lt 1 lc rgb \"#777777\"\n"
                 : "unset xzeroaxis\nunset yzeroaxis\n";
    const std::vector<const Curve*>& curves = panels_[place];
    text_ += axis('x', panel.log_x, x_ticks(panel, curves)) + axis('y', panel.log_y, y_ticks(curves)) +
             fmt::format("set boxwidth {} absolute\n", panel.bar_width);
    text_ += ranges(curves.front()->kind);
    if (const auto [low, high] = y_range(curves); !panel.log_y && is_constant(curves))
      text_ += fmt::format("set yrange [{:.17g}:{:.17g}]\n", low, high);
    if (panel.log_x && powers_of_ten(curves) < 2)
      text_ += "set autoscale x\n";  // the axis ends at the next
                                     // powers of ten
    if (panel.x_range)
      text_ += fmt::format("set xrange [{}:{}]\n", panel.x_range->first, panel.x_range->second);
    if (!panel.x_ticks.empty()) {
      std::string ticks;
      for (const auto& [x, name] : panel.x_ticks)
        ticks += fmt::format("{}{} {}", ticks.empty() ? "" : ", ", literal(name), x);
      text_ += "set xtics (" + ticks + ") scale 0" + (slanted(panel) ? " rotate by 20 right\n" : "\n");
    }
    legend(place, x0 + chart_.width + 16, y1);
    const std::vector<std::string> colors = colors_of(curves);
    std::string plots;
    for (std::size_t k = 0; k < curves.size(); ++k) {
      data(*curves[k], k);
      plots += (k == 0 ? "plot " : ", ") + plotted(*curves[k], k, colors[k]);
    }
    text_ += plots + "\nunset label 1\nunset label 2\n";
  }

  /// Whether the names below a panel are too long to stand side by side, so that they are written aslant.
  bool slanted(const Panel& panel) const {
    std::size_t longest = 0;
    for (const auto& [x, name] : panel.x_ticks) longest = std::max(longest, width(name));
    return 7 * longest * panel.x_ticks.size() > static_cast<std::size_t>(chart_.width);
  }

  static std::string axis(char name, bool logarithmic, const Ticks& ticks) {
    const std::string step = logarithmic || ticks.step == 0 ? "autofreq" : fmt::format("{:.9g}", ticks.step);
    return fmt::format("{0} logscale {1}{2}\nset format {1} \"{3}\"\nset {1}tics {4}{5}\n",
                       logarithmic ? "set" : "unset", name, logarithmic ? " 10" : "",
                       logarithmic ? "%.0te%T" : ticks.format, name == 'x' ? "norotate " : "", step);
  }

  static std::pair<double, double> extent(const std::vector<const Curve*>& curves,
                                          std::vector<double> Curve::*numbers) {
    double low = (curves.front()->*numbers).front(), high = low;
    for (const Curve* curve : curves)
      for (const double x : curve->*numbers) {
        low = std::min(low, x);
        high = std::max(high, x);
      }
    return {low, high};
  }

  /// Whether all numbers of a panel are equal to rounding.
  static bool is_constant(const std::vector<const Curve*>& curves) {
    const auto [low, high] = extent(curves, &Curve::y);
    return curves.front()->kind == Curve::line &&
           high / 2 - low / 2 <= 1e-13 * std::max(std::abs(low), std::abs(high));
  }

  /// The range of the vertical axis, which has a height even if the curves have none.
  static std::pair<double, double> y_range(const std::vector<const Curve*>& curves) {
    auto [low, high] = extent(curves, &Curve::y);
    if (curves.front()->kind == Curve::bars) {
      low = std::min(low, 0.0);
      high = std::max(high, 0.0);
    }
    if (!is_constant(curves)) return {low, high};
    const double part = low == 0 ? 1 : 0.01 * std::abs(low);
    return {low - part, high + part};
  }

  Ticks y_ticks(const std::vector<const Curve*>& curves) const {
    const auto [low, high] = y_range(curves);
    return ticks_in(low, high, chart_.height / 30.0);
  }
  Ticks x_ticks(const Panel& panel, const std::vector<const Curve*>& curves) const {
    if (!panel.x_ticks.empty()) return {};
    const auto [low, high] = extent(curves, &Curve::x);
    return ticks_in(low, high, chart_.width / 90.0);
  }

  /// The number of powers of ten in the horizontal range of the curves. gnuplot labels a logarithmic axis at
  /// powers of ten only.
  static double powers_of_ten(const std::vector<const Curve*>& curves) {
    const auto [low, high] = extent(curves, &Curve::x);
    return std::floor(std::log10(high)) - std::ceil(std::log10(low)) + 1;
  }

  static const char* ranges(Curve::Kind kind) {
    switch (kind) {
      case Curve::line: return "set autoscale xfix\nset offsets 0, 0, 0, 0\nset yrange [*:*]\n";
      case Curve::points:
        return "set autoscale x\nset offsets graph 0.05, graph 0.05, graph 0.05, graph 0.05\nset yrange "
               "[*:*]\n";
      case Curve::bars:
      case Curve::marks: break;
    }
    return "set autoscale xfix\nset offsets 0.5, 0.5, 0, 0\nset yrange [0:*]\n";
  }

  /// The text of the legend about lines that are not drawn; empty if all lines are drawn.
  std::string note(const Panel& panel) const {
    const auto all = std::ranges::count_if(panel.curves, [](const Curve& curve) { return !curve.y.empty(); });
    const std::size_t drawn = panels_[static_cast<std::size_t>(&panel - chart_.panels.data())].size();
    return drawn < static_cast<std::size_t>(all) ? fmt::format("the {} of {} that change most", drawn, all)
                                                 : "";
  }

  void legend(std::size_t place, double x, double y) {
    if (chart_.legend == Chart::below_all) return void(text_ += "unset key\n");
    text_ += fmt::format(
        "set key at screen {},{} left top vertical maxrows 20 Left reverse noautotitle samplen 2 title {} "
        "left\n",
        x / size_[0], y / size_[1], literal(note(chart_.panels[place])));
  }

  /// The gnuplot commands that draw one legend in a strip below all panels. The strip is as wide as the
  /// chart, and the legend has the curves of the first panel. It belongs to an additional plot without
  /// curves.
  std::string legend_below() const {
    std::string text = fmt::format(
        "set lmargin at screen 0\nset rmargin at screen 1\nset bmargin at screen 0\nset tmargin at screen "
        "{}\n"
        "unset border\nunset tics\nunset grid\nset title \"\"\nset xlabel \"\"\nset ylabel \"\"\nset xrange "
        "[0:1]\n"
        "set yrange [0:1]\nset key inside center center horizontal Left reverse noautotitle\n",
        1.0 * bottom() / size_[1]);
    const std::vector<std::string> colors = colors_of(panels_[0]);
    for (std::size_t k = 0; k < panels_[0].size(); ++k) {
      const Curve& curve = *panels_[0][k];
      const std::string line = curve.kind == Curve::marks ? "lines linewidth 1.5" : "boxes";
      text += fmt::format("{} NaN with {} linecolor rgb \"{}\" title {}", k == 0 ? "plot" : ",", line,
                          colors[k], literal(in_legend(curve)));
    }
    return text + "\n";
  }

  /// Chooses the colours of curves. If all curves belong to different bodies, each has the colour of its
  /// body. Otherwise curve k has colour k of the palette, unless a colour number is set in the curve, and
  /// curves that are drawn as marks (short horizontal lines) are black.
  static std::vector<std::string> colors_of(const std::vector<const Curve*>& curves) {
    std::vector<std::string> of_bodies, colors;
    for (std::size_t k = 0; k < curves.size(); ++k) {
      const Curve& curve = *curves[k];
      if (curve.body > 0) of_bodies.push_back(color_of_body(curve.body));
      const std::size_t place = curve.color < 0 ? k : static_cast<std::size_t>(curve.color);
      colors.emplace_back(curve.kind == Curve::marks ? "#000000"
                                                     : curve_palette[place % curve_palette.size()]);
    }
    const std::set<std::string> different(of_bodies.begin(), of_bodies.end());
    return different.size() == curves.size() ? of_bodies : colors;
  }

  void data(const Curve& curve, std::size_t k) {
    text_ += fmt::format("$d{} << END\n", k);
    for (const std::size_t i : thinned(curve.y))
      text_ += fmt::format("{:.15g} {:.15g}\n", curve.x[i], curve.y[i]);
    text_ += "END\n";
  }

  static std::string plotted(const Curve& curve, std::size_t k, const std::string& color) {
    std::string style;
    switch (curve.kind) {
      case Curve::line:
        style = fmt::format("with {} linewidth 1.8 dashtype {}",
                            curve.y.size() <= most_dots ? "linespoints pointtype 7 pointsize 0.4" : "lines",
                            k < most_lines / 2 ? "1" : "(8,4)");
        break;
      case Curve::points: style = "with points pointtype 7 pointsize 1"; break;
      case Curve::bars:  // bars are hatched if their colour has been used before
        style = k < curve_palette.size()
                    ? "with boxes"
                    : fmt::format("with boxes fillstyle pattern {}", k / curve_palette.size());
        break;
      case Curve::marks: style = "with vectors nohead linewidth 1.5"; break;
    }
    return fmt::format("$d{} using {} {} linecolor rgb \"{}\" {}", k,
                       curve.kind == Curve::marks ? "($1-0.5):2:(1):(0)" : "1:2", style, color,
                       curve.name.empty() ? "notitle" : "title " + literal(in_legend(curve)));
  }

  const Chart& chart_;
  std::vector<std::vector<const Curve*>> panels_;
  std::size_t legend_ = 0;
  int left_, right_, gap_, titles_;
  std::array<int, 2> size_;
  std::string text_;
};

}  // namespace

ChartFile::ChartFile(std::string option, std::string file)
    : option_(std::move(option)), file_(std::move(file)) {
  static constexpr std::array<std::pair<std::string_view, Format>, 2> endings{
      {{".svg", Format::svg}, {".png", Format::png}}};
  format_ = choose(option_ + ": " + file_ + ": the ending", std::filesystem::path(file_).extension().string(),
                   endings);
  if (!gnuplot(""))
    throw InputError(option_ +
                     ": charts need gnuplot, which is not installed (on Debian: apt install gnuplot-nox)");
}

void ChartFile::draw(const Chart& chart) const {
  Script script(chart);
  if (script.empty()) throw InputError(option_ + ": there are no numbers to draw");
  const std::optional<GnuplotOutcome> drawn =
      gnuplot(format_ == Format::svg ? script.text("svg background rgb \"white\"", 1)
                                     : script.text("pngcairo background rgb \"white\"", 2));
  if (!drawn || drawn->status != 0 || drawn->out.empty())
    throw InputError(option_ + ": gnuplot could not draw it" + (drawn ? ": " + drawn->err : ""));
  write_text(file_, drawn->out);
}

void add_plot_option(CLI::App& command, std::string& file) {
  command.add_option("--plot", file, "Draw a .svg or .png")->type_name("FILE");
}

void add_columns_option(CLI::App& command, std::vector<std::string>& columns) {
  CLI::Option* option =
      command
          .add_option("--columns", columns,
                      "Draw these curves only: names of panels, curves, joints or bodies, as q or \"q pin\"")
          ->type_name("NAMES")
          ->delimiter(',')
          ->allow_extra_args(false);
  if (CLI::Option* plot = command.get_option_no_throw("--plot")) option->needs(plot);
}

void keep_columns(Chart& chart, const std::vector<std::string>& columns) {
  if (columns.empty()) return;
  std::vector<bool> used(columns.size());
  std::vector<std::string> names;
  for (Panel& panel : chart.panels) {
    std::erase_if(panel.curves, [&](const Curve& curve) {
      std::vector<std::string> own = curve.of;
      own.push_back(curve.name);
      bool kept = false;
      for (std::size_t k = 0; k < columns.size(); ++k) {
        const bool named =
            columns[k] == panel.name || std::ranges::any_of(own, [&](const std::string& name) {
              return !name.empty() && (columns[k] == name || columns[k] == panel.name + " " + name);
            });
        used[k] = used[k] || named;
        kept = kept || named;
      }
      own.push_back(panel.name);
      for (const std::string& name : own)
        if (!name.empty() && std::ranges::find(names, name) == names.end()) names.push_back(name);
      return !kept;
    });
  }
  for (std::size_t k = 0; k < columns.size(); ++k)
    if (!used[k])
      throw UsageError("--columns: " + none_of(columns[k], names, [](const auto& name) { return name; }));
  std::string x_axis;
  for (const Panel& panel : chart.panels)
    if (!panel.x_axis.empty()) x_axis = panel.x_axis;
  if (chart.columns == 1) {
    std::erase_if(chart.panels, [](const Panel& panel) { return panel.curves.empty(); });
    if (!chart.panels.empty()) chart.panels.back().x_axis = x_axis;
  }
}

std::optional<ChartFile> chart_file(const std::string& file) {
  if (file.empty()) return std::nullopt;
  return ChartFile("--plot", file);
}

}  // namespace axode::command
