#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Comma-separated values (CSV). A cell in quotes may contain commas, line ends and doubled quotes. Lines end
/// with LF, CR LF or CR.
namespace axode::command {

/// Reads a file and calls row(line, cells) for each row that is not empty. `line` is the number of the line
/// in which the row begins, from 1. Throws InputError if the file cannot be read, or a quote in it is never
/// closed.
void for_rows_of_csv(const std::string& file,
                     const std::function<void(std::size_t line, const std::vector<std::string>& cells)>& row);

/// The number in a cell, inf and nan included; empty if the cell contains anything else.
std::optional<double> number_in(std::string_view cell);

/// A text as a quoted cell of CSV.
std::string quoted(const std::string& word);

}  // namespace axode::command
