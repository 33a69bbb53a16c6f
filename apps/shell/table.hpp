#pragma once
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace axode::command {

/// A text, or a number that is written with as many decimals as its column needs.
using Cell = std::variant<std::string, double>;

/// A table for a terminal. Columns of numbers are aligned on the decimal point, with at most six digits for
/// the largest number of the column; columns without any entry are left out.
class Table {
 public:
  explicit Table(std::vector<std::string> headings) : headings_(std::move(headings)) {}

  Table& row(std::vector<Cell> cells);
  /// Draws a line between the rows so far and later rows.
  Table& rule();
  bool empty() const { return rows_.empty(); }

  /// Each number of the table with a name. The name consists of the words before the number in its row, and
  /// of the heading of its column. A blank word stands for the word in the row above.
  std::vector<std::pair<std::string, double>> numbers() const;

  /// The table as text. It consists of lines that end in a newline; the headings come first and are
  /// underlined.
  std::string text() const;

 private:
  std::vector<std::string> headings_;
  std::vector<std::vector<Cell>> rows_;
  std::vector<std::size_t> rules_;
};

/// The number of columns that a text takes on a terminal.
std::size_t width(std::string_view text);

/// The text with blanks after it, or before it, up to a width.
std::string padded(const std::string& text, std::size_t to, bool right = false);

/// The number with `digits` significant digits, zero without a sign.
std::string significant(double x, int digits = 6);

}  // namespace axode::command
