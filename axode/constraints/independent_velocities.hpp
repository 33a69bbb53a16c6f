#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/independent_rows.hpp"

namespace axode {

/// Velocities that determine all others where the loops stay closed: v = N y.
struct IndependentVelocities {
  std::vector<int> velocities;  ///< which of the nv they are, k
  Eigen::MatrixXd N;            ///< nv × k; the identity in the rows of these velocities
};

/// Those that are asked for, or where none are the ones that determine the others best; at the place of the rows. Throws
/// std::invalid_argument where they are more or fewer than the loops leave, or do not determine the others.
IndependentVelocities independent_velocities(const Model& model, const IndependentRows<double>& rows,
                                             std::span<const int> wanted);

/// The x, 0 in the rows of the independent velocities, for which the kept rows of A x are b.
Eigen::MatrixXd dependent_part(const IndependentVelocities& independent, const IndependentRows<double>& rows,
                               const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);

}  // namespace axode
