#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

namespace axode::command {

/// The formats of output files, by the ending of their names.
enum class FileFormat { json, csv, npz };
/// The format of the file that an option names, by its ending. Throws UsageError for an unknown ending.
FileFormat file_format(const std::string& file, const char* option = "--output");

/// The matrix as comma-separated values, with the names of the columns above and those of the rows in front.
std::string as_csv(const Eigen::MatrixXd& matrix, const std::vector<std::string>& rows,
                   const std::vector<std::string>& columns);
/// The matrix as comma-separated values, with the names of the columns above.
std::string as_csv(const Eigen::MatrixXd& matrix, const std::vector<std::string>& columns);

/// A matrix, or a vector (a matrix of one column), and its name.
struct NamedArray {
  std::string name;
  Eigen::MatrixXd numbers;
  bool is_vector = false;
};
/// The bytes of an .npz file, which numpy.load reads, with these arrays: doubles, row by row, not compressed.
std::string as_npz(const std::vector<NamedArray>& arrays);

}  // namespace axode::command
