#include "apps/shell/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/shell/terminal.hpp"

namespace axode::command {
namespace {

/// The format of a column's numbers: six digits for the largest, without zeros at the end that all have.
class NumberStyle {
 public:
  explicit NumberStyle(const std::vector<double>& column) {
    double largest = 0;
    for (const double x : column) largest = std::max(largest, std::abs(x));
    if (largest == 0) return;
    const int exponent = static_cast<int>(std::floor(std::log10(largest)));
    scientific_ = exponent < -4 || exponent > 6;
    decimals_ = scientific_ ? 5 : std::max(0, 5 - exponent);
    int needed = 0;
    for (const double x : column) needed = std::max(needed, needed_decimals(x));
    decimals_ = needed;
  }

  std::string write(double x) const {
    const std::string text =
        scientific_ ? fmt::format("{:.{}e}", x, decimals_) : fmt::format("{:.{}f}", x, decimals_);
    const bool zero = text.find_first_of("123456789") == std::string::npos;
    return zero && text.front() == '-' ? text.substr(1) : text;
  }

 private:
  int needed_decimals(double x) const {
    const std::string text = write(x), digits = text.substr(0, text.find('e'));
    const std::size_t point = digits.find('.');
    return point == std::string::npos ? 0 : static_cast<int>(digits.find_last_not_of('0') - point);
  }

  bool scientific_ = false;
  int decimals_ = 0;
};

struct Column {
  std::vector<std::string> cells;
  bool numbers = false, empty = true;
  std::size_t width = 0;
};

Column column(const std::vector<std::vector<Cell>>& rows, std::size_t k, const std::string& heading) {
  std::vector<double> numbers;
  for (const auto& row : rows)
    if (const double* x = std::get_if<double>(&row[k])) numbers.push_back(*x);
  const NumberStyle style(numbers);
  Column out;
  out.numbers = !numbers.empty();
  out.width = width(heading);
  for (const auto& row : rows) {
    const double* x = std::get_if<double>(&row[k]);
    out.cells.push_back(x != nullptr ? style.write(*x) : std::get<std::string>(row[k]));
    out.empty &= out.cells.back().empty();
    out.width = std::max(out.width, width(out.cells.back()));
  }
  return out;
}

std::string trimmed(std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  return line;
}

}  // namespace

std::size_t width(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t to, bool right) {
  const std::string space(to - width(text), ' ');
  return right ? space + text : text + space;
}

std::string significant(double x, int digits) { return fmt::format("{:.{}g}", x == 0 ? 0.0 : x, digits); }

std::string counted(std::size_t n, const std::string& singular, const std::string& plural) {
  return std::to_string(n) + ' ' + (n == 1 ? singular : plural.empty() ? singular + 's' : plural);
}

Table& Table::row(std::vector<Cell> cells) {
  cells.resize(headings_.size());
  rows_.push_back(std::move(cells));
  return *this;
}

Table& Table::rule() {
  rules_.push_back(rows_.size());
  return *this;
}

std::vector<std::pair<std::string, double>> Table::numbers() const {
  std::vector<std::pair<std::string, double>> all;
  std::vector<std::string> words(headings_.size());
  for (const std::vector<Cell>& row : rows_) {
    std::string name;
    for (std::size_t k = 0; k < row.size(); ++k) {
      if (const double* x = std::get_if<double>(&row[k])) {
        all.emplace_back(name + headings_[k], *x);
        continue;
      }
      const std::string& word = std::get<std::string>(row[k]);
      if (!word.empty()) words[k] = word;
      if (!words[k].empty()) name += words[k] + " ";
    }
  }
  return all;
}

std::string Table::text() const {
  if (rows_.empty()) return "  none\n";
  std::string head, line;
  std::vector<std::string> body(rows_.size());
  for (std::size_t k = 0; k < headings_.size(); ++k) {
    const Column c = column(rows_, k, headings_[k]);
    if (c.empty) continue;
    const std::string gap = head.empty() ? "" : "  ";
    head += gap + padded(headings_[k], c.width, c.numbers);
    for (std::size_t bar = 0; bar < c.width + gap.size(); ++bar) line += "─";
    for (std::size_t i = 0; i < body.size(); ++i) body[i] += gap + padded(c.cells[i], c.width, c.numbers);
  }
  line = "  " + in(Ink::faint, line) + "\n";
  std::string out = "  " + in(Ink::heading, trimmed(head)) + "\n" + line;
  for (std::size_t i = 0; i < body.size(); ++i) {
    if (std::find(rules_.begin(), rules_.end(), i) != rules_.end()) out += line;
    out += "  " + trimmed(body[i]) + "\n";
  }
  return out;
}

}  // namespace axode::command
