#include "apps/files/csv_file.hpp"

#include <charconv>

namespace axode::command {

void for_rows_of_csv(std::string_view text,
                     const std::function<void(std::size_t, const std::vector<std::string>&)>& row) {
  std::vector<std::string> cells;
  std::size_t line = 1, begin = 1;
  bool quoted = false;
  const auto cell = [&]() -> std::string& {
    if (cells.empty()) {
      begin = line;
      cells.emplace_back();
    }
    return cells.back();
  };
  const auto end = [&] {
    if (!cells.empty()) row(begin, cells);
    cells.clear();
  };
  for (std::size_t k = 0; k < text.size(); ++k) {
    const char c = text[k];
    if (c == '"') {
      std::string& into = cell();
      if (quoted && text.substr(k + 1).starts_with('"')) {
        into += text[k++];
      } else {
        quoted = !quoted;
      }
    } else if (quoted) {
      cell() += c;
    } else if (c == '\n') {
      end();
    } else if (c == ',') {
      cell();
      cells.emplace_back();
    } else if (c != '\r') {
      cell() += c;
    }
    if (c == '\n') ++line;
  }
  end();
}

std::optional<double> number_in(std::string_view cell) {
  double x = 0;
  const auto [stop, failure] = std::from_chars(cell.data(), cell.data() + cell.size(), x);
  if (failure != std::errc{} || stop != cell.data() + cell.size()) return std::nullopt;
  return x;
}

std::string quoted(const std::string& word) {
  std::string out = "\"";
  for (const char c : word) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

}  // namespace axode::command
