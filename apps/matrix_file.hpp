#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

namespace axode::command {

/// Comma-separated values: a line with the names of the columns, then for each row its name and its numbers, which read
/// back to the same doubles.
std::string as_csv(const Eigen::MatrixXd& matrix, const std::vector<std::string>& rows,
                   const std::vector<std::string>& columns);

/// The bytes of a file that numpy.load reads (format 1.0): rows of little-endian doubles.
std::string as_npy(const Eigen::MatrixXd& matrix);

}  // namespace axode::command
