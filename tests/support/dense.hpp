#pragma once
#include <Eigen/Core>
#include <vector>

/// Dense linear algebra of any size. It is compiled once for all tests, because compiling Eigen's templates
/// would otherwise take most of the time that compiling a law takes.
namespace axode::test {

Eigen::VectorXd vector(const std::vector<double>& x);
std::vector<double> numbers(const Eigen::VectorXd& x);
/// The matrix with `n_rows` rows whose entries are given row by row.
Eigen::MatrixXd matrix(int n_rows, const std::vector<double>& rows);
Eigen::MatrixXd product(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
Eigen::VectorXd product(const Eigen::MatrixXd& A, const Eigen::VectorXd& x);
/// The smallest eigenvalue of a symmetric matrix, and whether all of them are positive.
double smallest_eigenvalue(const Eigen::MatrixXd& A);
bool is_positive_definite(const Eigen::MatrixXd& A);
/// The smallest eigenvalue of a symmetric matrix after its diagonal is scaled to 1. It says how far the
/// matrix is from a singular one.
double definiteness(const Eigen::MatrixXd& A);
double largest_entry(const Eigen::MatrixXd& A);

}  // namespace axode::test
