#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Comma-separated values (CSV). A cell in quotes may contain commas, line ends and doubled quotes.
namespace axode::command {

/// Calls row(line, cells) for each row that is not empty, with the number of its first line, from 1.
void for_rows_of_csv(std::string_view text,
                     const std::function<void(std::size_t line, const std::vector<std::string>& cells)>& row);

/// The number in a cell, inf and nan included; empty if the cell contains anything else.
std::optional<double> number_in(std::string_view cell);

/// A text as a quoted cell of CSV.
std::string quoted(const std::string& word);

}  // namespace axode::command
