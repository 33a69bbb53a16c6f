#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/loop_system/independent_rows.hpp"

namespace axode {

/// Independent velocities y, which determine all velocities v while the loops stay closed: v = N y.
struct IndependentVelocities {
  std::vector<int> velocities;  ///< the indices of the k independent velocities
  Eigen::MatrixXd N;            ///< nv × k; the identity in the rows of the independent velocities
};

/// Computes the matrix N of v = N y for the joint velocities v, of which y are independent. `wanted` are the
/// indices of y; if it is empty, the velocities that determine the others best are chosen. `rows` is the
/// analysis of the loop equations. Throws std::invalid_argument for an index that is not from 0 to nv - 1, a
/// number that is not that of the degrees of freedom, or velocities that do not determine the others.
IndependentVelocities independent_velocities(const Model& model, const IndependentRows<double>& rows,
                                             std::span<const int> wanted);

/// Solves A x = b for each column of b, with the Jacobian A of the loop equations, of which only those are
/// used that are independent in the analysis `rows`. x is 0 at the independent velocities.
Eigen::MatrixXd dependent_part(const IndependentVelocities& independent, const IndependentRows<double>& rows,
                               const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);

}  // namespace axode
