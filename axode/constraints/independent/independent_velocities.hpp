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

/// Computes the matrix N of v = N y, where y are the independent ones of the joint velocities v, with the
/// indices `wanted`; if this is empty, the velocities that determine the others best at the configuration of
/// `rows` are chosen. Throws std::invalid_argument for indices that are not from 0 to nv - 1, if their number
/// is not that of the degrees of freedom, or if these velocities do not determine the others.
IndependentVelocities independent_velocities(const Model& model, const IndependentRows<double>& rows,
                                             std::span<const int> wanted);

/// Solves A x = b for each column of b, where A is the Jacobian of the loop equations, of which only the
/// independent ones in `rows` are used. Of the solutions x it returns the one that is 0 at the independent
/// velocities.
Eigen::MatrixXd dependent_part(const IndependentVelocities& independent, const IndependentRows<double>& rows,
                               const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);

}  // namespace axode
