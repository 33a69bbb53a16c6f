#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

namespace axode::command {

/// The format of a file, by its ending.
enum class FileFormat { json, csv, npz };
/// The format of the file of an option. Throws UsageError for an unknown ending.
FileFormat file_format(const std::string& file, const char* option = "--output");

/// Comma-separated values: a line with the names of the columns, then for each row its name and its numbers,
/// which read back to the same doubles.
std::string as_csv(const Eigen::MatrixXd& matrix, const std::vector<std::string>& rows,
                   const std::vector<std::string>& columns);
/// Comma-separated values without names of rows.
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
