#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

namespace axode::command {

/// What the ending of a file says that is to be written or read.
enum class FileFormat { json, csv, npz };
/// Of the file of an option. Throws UsageError for another ending.
FileFormat file_format(const std::string& file, const char* option = "--output");

/// Comma-separated values: a line with the names of the columns, then for each row its name and its numbers,
/// which read back to the same doubles.
std::string as_csv(const Eigen::MatrixXd& matrix, const std::vector<std::string>& rows,
                   const std::vector<std::string>& columns);
/// The same without names of rows.
std::string as_csv(const Eigen::MatrixXd& matrix, const std::vector<std::string>& columns);

/// A matrix, or a vector, and its name.
struct NamedArray {
  std::string name;
  Eigen::MatrixXd numbers;
  bool is_vector = false;
};
/// The bytes of a file that numpy.load reads: doubles, row by row, not compressed.
std::string as_npz(const std::vector<NamedArray>& arrays);

}  // namespace axode::command
