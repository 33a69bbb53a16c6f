#pragma once
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace axode::command {

/// A cell of a table: a text, or a number, which is written with as many decimals as its column needs.
using Cell = std::variant<std::string, double>;

/// A table for a terminal. Numbers in a column are aligned on the decimal point and have so many decimals
/// that the largest of them has six digits. Empty columns are left out.
class Table {
 public:
  explicit Table(std::vector<std::string> headings) : headings_(std::move(headings)) {}

  Table& row(std::vector<Cell> cells);
  /// Draws a line between the rows that the table has now and rows that are added later.
  Table& rule();
  bool empty() const { return rows_.empty(); }

  /// All numbers of the table, each with a name that is made of the words before it in its row and the
  /// heading of its column. An empty cell repeats the word in the row above.
  std::vector<std::pair<std::string, double>> numbers() const;

  /// The table as text: the underlined headings, then the rows, each a line that ends in a newline.
  std::string text() const;

 private:
  std::vector<std::string> headings_;
  std::vector<std::vector<Cell>> rows_;
  std::vector<std::size_t> rules_;
};

/// The number of columns that a text takes on a terminal.
std::size_t width(std::string_view text);

/// The text with blanks after it, or before it if `right` is set, so that it has the width `to`.
std::string padded(const std::string& text, std::size_t to, bool right = false);

/// The number as text with `digits` significant digits; zero has no sign.
std::string significant(double x, int digits = 6);

/// The number and what is counted, such as `1 step` and `2 steps`. The plural is given if it is not the
/// singular with an s.
std::string counted(std::size_t n, const std::string& singular, const std::string& plural = "");

}  // namespace axode::command
