#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/loop_system/independent_rows.hpp"

namespace axode {

/// Independent velocities y, which determine all others while the loops stay closed: v = N y.
struct IndependentVelocities {
  std::vector<int> velocities;  ///< the indices of the k independent velocities
  Eigen::MatrixXd N;            ///< nv × k; the identity in the rows of the independent velocities
};

/// Makes the velocities `wanted` the independent ones; if it is empty, the velocities that determine the
/// others best at the configuration of the rows. Throws std::invalid_argument if their number is not that of
/// the degrees of freedom, or if they do not determine the others.
IndependentVelocities independent_velocities(const Model& model, const IndependentRows<double>& rows,
                                             std::span<const int> wanted);

/// Solves A x = b in the independent rows for the x that is 0 in the rows of the independent velocities.
Eigen::MatrixXd dependent_part(const IndependentVelocities& independent, const IndependentRows<double>& rows,
                               const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);

}  // namespace axode
