#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "study.hpp"

namespace axode::command {
namespace {

constexpr double bar = 11, gap = 9, panel_height = 110, panel_gap = 34, left = 46, top = 64, column_gap = 30;

constexpr std::array<std::pair<std::string_view, std::string_view>, 5> colors{{{"body", "#4477aa"},
                                                                               {"spatial", "#ee7733"},
                                                                               {"hybrid", "#228833"},
                                                                               {"mixed", "#aa3377"},
                                                                               {"fast", "#999933"}}};
constexpr std::array<std::string_view, 4> frames{"joint", "user", "com", "construction"};

/// 5 bars for the joint frames, 4 for the others.
constexpr double panel_width = 17 * bar + 3 * gap;

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      default: out += c;
    }
  }
  return out;
}

std::string text_at(double x, double y, std::string_view anchor, std::string_view text) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor,
                     escaped(text));
}

/// Where the bar of an effort stands in its panel.
double place(const Effort& effort) {
  const auto f = std::ranges::find(frames, effort.frames) - frames.begin();
  const auto r =
      std::ranges::find(colors, effort.representation, &decltype(colors)::value_type::first) - colors.begin();
  return static_cast<double>(r) * bar +
         (f == 0 ? 0 : 5 * bar + gap + static_cast<double>(f - 1) * (4 * bar + gap));
}

std::string_view color(const Effort& effort) {
  return std::ranges::find(colors, effort.representation, &decltype(colors)::value_type::first)->second;
}

std::string duration(double seconds) {
  return seconds < 1e-6 ? fmt::format("{:.0f} ns", 1e9 * seconds) : fmt::format("{:.3g} µs", 1e6 * seconds);
}

/// The efforts of one algorithm on one model. Ticks are operations, to the scale at which the first tick meets its bar.
std::string panel(const std::vector<Effort>& efforts, double x, double y) {
  const Effort& first = efforts.front();
  const double per_operation = first.seconds / static_cast<double>(first.operations.total());
  const auto tick = [&](const Effort& effort) {
    return per_operation * static_cast<double>(effort.operations.total());
  };
  double most = 0;
  for (const Effort& effort : efforts) most = std::max({most, effort.seconds, tick(effort)});
  const auto height = [&](double seconds) { return panel_height * seconds / most; };
  std::string out = fmt::format("<path class=\"axis\" d=\"M{:.1f} {:.1f}h{:.1f}M{:.1f} {:.1f}h{:.1f}\"/>\n",
                                x, y, panel_width, x, y - panel_height, panel_width);
  for (const Effort& effort : efforts) {
    const double at = x + place(effort), h = height(effort.seconds), t = height(tick(effort));
    out += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"><title>{} frames, "
        "{}: {}, {} "
        "operations</title></rect>\n<path class=\"tick\" d=\"M{:.1f} {:.1f}h{:.1f}\"/>\n",
        at, y - h, bar - 2, h, color(effort), effort.frames, effort.representation, duration(effort.seconds),
        effort.operations.total(), at - 1, y - t, bar);
  }
  return out + text_at(x, y - panel_height - 5, "start", duration(most));
}

}  // namespace

std::string plot(const std::vector<Study>& studies) {
  std::string out;
  double y = top;
  for (const auto& [name, algorithm] : algorithms) {
    double x = left;
    bool any = false;
    for (const Study& study : studies) {
      std::vector<Effort> efforts;
      std::ranges::copy_if(
          study.efforts, std::back_inserter(efforts),
          [algorithm = algorithm](const Effort& effort) { return effort.algorithm == algorithm; });
      if (!efforts.empty()) out += panel(efforts, x, y + panel_height);
      any = any || !efforts.empty();
      x += panel_width + column_gap;
    }
    if (!any) continue;
    std::string title(name);
    std::ranges::replace(title, '_', ' ');
    out += fmt::format(
        "<text transform=\"translate({:.1f} {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
        left - 14, y + panel_height / 2, title);
    y += panel_height + panel_gap;
  }
  double x = left;
  for (const Study& study : studies) {
    double at = x;
    out += text_at(x + panel_width / 2, top - 26, "middle", study.model);
    for (const std::string_view name : frames) {
      const double width = (name == "joint" ? 5 : 4) * bar;
      out += text_at(at + width / 2, y - panel_gap + 14, "middle", name == "construction" ? "constr." : name);
      at += width + gap;
    }
    x += panel_width + column_gap;
  }
  double at = left;
  for (const auto& [name, fill] : colors) {
    out += fmt::format("<rect x=\"{:.1f}\" y=\"10\" width=\"{}\" height=\"{}\" fill=\"{}\"/>\n", at, bar, bar,
                       fill);
    out += text_at(at + bar + 4, 19, "start", name);
    at += bar + 12 + 7 * static_cast<double>(name.size());
  }
  out += fmt::format("<path class=\"tick\" d=\"M{:.1f} 15h{}\"/>\n", at, bar) +
         text_at(at + bar + 4, 19, "start", "operations");
  const double width = std::max(x, at + 90), height = y - panel_gap + 24;
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
             "height=\"{1:.0f}\">\n"
             "<title>Times and operations by algorithm, body frames and representation</title>\n"
             "<style>text {{ font: 11px sans-serif; fill: #222 }} .paper {{ fill: #fff }} .axis {{ stroke: "
             "#888 }} "
             ".tick {{ stroke: #222; stroke-width: 2 }}\n"
             "@media (prefers-color-scheme: dark) {{ text {{ fill: #ddd }} .paper {{ fill: #111 }} "
             ".tick {{ stroke: #eee }} }}</style>\n"
             "<path class=\"paper\" d=\"M0 0h{0:.0f}v{1:.0f}h-{0:.0f}z\"/>\n",
             width, height) +
         out + "</svg>\n";
}

}  // namespace axode::command
