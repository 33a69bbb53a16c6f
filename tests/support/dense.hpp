#pragma once
#include <Eigen/Core>
#include <vector>

/// Dense linear algebra of any size, compiled once for all tests: it is most of what compiling a law would take.
namespace axode::test {

Eigen::VectorXd vector(const std::vector<double>& x);
std::vector<double> numbers(const Eigen::VectorXd& x);
/// So many rows, one after the other, as a matrix.
Eigen::MatrixXd matrix(int n_rows, const std::vector<double>& rows);
Eigen::MatrixXd product(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
Eigen::VectorXd product(const Eigen::MatrixXd& A, const Eigen::VectorXd& x);
/// Of a symmetric matrix.
double smallest_eigenvalue(const Eigen::MatrixXd& A);
bool is_positive_definite(const Eigen::MatrixXd& A);
/// The smallest eigenvalue of a symmetric matrix scaled to a unit diagonal: how far it is from singular.
double definiteness(const Eigen::MatrixXd& A);
double largest_entry(const Eigen::MatrixXd& A);

}  // namespace axode::test
