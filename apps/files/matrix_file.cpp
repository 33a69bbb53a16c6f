#include "apps/files/matrix_file.hpp"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>

#include "apps/files/csv_file.hpp"
#include "apps/fmu/zip_archive.hpp"
#include "apps/shell/choice.hpp"

namespace axode::command {

namespace {

/// A line of CSV: the words with commas between them, and the end of the line.
std::string line_of(const std::vector<std::string>& words) {
  return fmt::format("{}\n", fmt::join(words, ","));
}
std::vector<std::string> all_quoted(const std::vector<std::string>& words) {
  std::vector<std::string> all;
  for (const std::string& word : words) all.push_back(quoted(word));
  return all;
}
void append_row(std::vector<std::string>& words, const Eigen::MatrixXd& matrix, Eigen::Index i) {
  for (Eigen::Index k = 0; k < matrix.cols(); ++k) words.push_back(fmt::format("{}", matrix(i, k)));
}

}  // namespace

FileFormat file_format(const std::string& file, const char* option) {
  static constexpr std::array<std::pair<std::string_view, FileFormat>, 3> endings{
      {{".json", FileFormat::json}, {".csv", FileFormat::csv}, {".npz", FileFormat::npz}}};
  return choose(std::string(option) + ": " + file + ": the ending",
                std::filesystem::path(file).extension().string(), endings);
}

std::string as_csv(const Eigen::MatrixXd& matrix, const std::vector<std::string>& rows,
                   const std::vector<std::string>& columns) {
  std::vector<std::string> headings{""};
  headings.insert(headings.end(), columns.begin(), columns.end());
  std::string out = line_of(all_quoted(headings));
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    std::vector<std::string> words{quoted(rows[static_cast<std::size_t>(i)])};
    append_row(words, matrix, i);
    out += line_of(words);
  }
  return out;
}

std::string as_csv(const Eigen::MatrixXd& matrix, const std::vector<std::string>& columns) {
  std::string out = line_of(all_quoted(columns));
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    std::vector<std::string> words;
    append_row(words, matrix, i);
    out += line_of(words);
  }
  return out;
}

namespace {

/// The bytes of an .npy file (format 1.0) with this array.
std::string as_npy(const NamedArray& array) {
  const Eigen::MatrixXd& matrix = array.numbers;
  constexpr std::size_t before_header = 10, line = 64;  // numbers begin at a multiple of 64 bytes
  const std::string columns = array.is_vector ? "" : fmt::format(" {}", matrix.cols());
  std::string header =
      fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},{}), }}", matrix.rows(), columns);
  header.append(line - 1 - (before_header + header.size()) % line, ' ');
  header += '\n';
  std::string out("\x93NUMPY\x01\x00", 8);
  const auto append = [&](std::uint64_t number, int bytes) {
    for (int k = 0; k < bytes; ++k) out += static_cast<char>(number >> (8 * k) & 0xFF);
  };
  append(header.size(), 2);
  out += header;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) append(std::bit_cast<std::uint64_t>(matrix(i, k)), 8);
  return out;
}

}  // namespace

std::string as_npz(const std::vector<NamedArray>& arrays) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const NamedArray& array : arrays) files.emplace_back(array.name + ".npy", as_npy(array));
  return as_zip(files, Compression::stored);
}

}  // namespace axode::command
