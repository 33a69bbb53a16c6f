#include "matrix_file.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>

#include "text_file.hpp"

namespace axode::command {

std::string as_csv(const Eigen::MatrixXd& matrix, const std::vector<std::string>& rows,
                   const std::vector<std::string>& columns) {
  std::string out = quoted("");
  for (const std::string& column : columns) out += "," + quoted(column);
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    out += "\n" + quoted(rows[static_cast<std::size_t>(i)]);
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) out += fmt::format(",{}", matrix(i, k));
  }
  return out + "\n";
}

std::string as_npy(const Eigen::MatrixXd& matrix) {
  constexpr std::size_t before_header = 10, line = 64;  // numbers begin at a multiple of 64 bytes
  std::string header = fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {}), }}",
                                   matrix.rows(), matrix.cols());
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

}  // namespace axode::command
