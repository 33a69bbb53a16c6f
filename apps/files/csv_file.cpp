#include "apps/files/csv_file.hpp"

#include <fmt/format.h>

#include <charconv>

#include "apps/files/text_file.hpp"
#include "apps/shell/commands.hpp"

namespace axode::command {

void for_rows_of_csv(const std::string& file,
                     const std::function<void(std::size_t, const std::vector<std::string>&)>& row) {
  const std::string content = read_text(file);
  const std::string_view text = content;
  std::vector<std::string> cells;
  std::size_t line = 1, begin = 1, quote = 1;
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
        quote = line;
      }
    } else if (quoted) {
      cell() += c;
    } else if (c == '\n' || c == '\r') {
      end();
    } else if (c == ',') {
      cell();
      cells.emplace_back();
    } else {
      cell() += c;
    }
    if (c == '\n' || (c == '\r' && !text.substr(k + 1).starts_with('\n'))) ++line;
  }
  if (quoted)
    throw InputError(fmt::format("{}:{}: a quote (\") is opened here and never closed", file, quote));
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
