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

/// Computes the matrix N of v = N y, where v are the velocities of the joints of a mechanism that keep its
/// loops closed, and y are independent entries of v. `wanted` are the indices of these entries, as many as
/// there are degrees of freedom; if it is empty, the entries that determine all others best are chosen.
/// `rows` says which loop equations are independent. Throws std::invalid_argument for an index that is not
/// from 0 to nv - 1, for a wrong number of indices, and if the entries do not determine all others.
IndependentVelocities independent_velocities(const Model& model, const IndependentRows<double>& rows,
                                             std::span<const int> wanted);

/// Solves A x = b for each column of b such that x is 0 at the independent velocities. A is the Jacobian of
/// the loop equations. `rows` says which of the equations are independent; the others are not used.
Eigen::MatrixXd dependent_part(const IndependentVelocities& independent, const IndependentRows<double>& rows,
                               const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);

}  // namespace axode
