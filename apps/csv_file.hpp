#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Tables of text, a row a line and commas between cells. What is in quotes may hold commas, ends of lines
/// and, twice, quotes.
namespace axode::command {

/// Calls with each row that is not empty, and the number of the line on which it begins, from 1.
void for_rows_of_csv(std::string_view text,
                     const std::function<void(std::size_t line, const std::vector<std::string>& cells)>& row);

/// Of a cell that is a number and nothing else, infinite and NaN among them.
std::optional<double> number_in(std::string_view cell);

/// A word of CSV in quotes.
std::string quoted(const std::string& word);

}  // namespace axode::command
