#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/loops.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The linearised equations of motion of a mechanism with loops, x' = A x + B δτ. The state is x = (δ, δv):
/// the displacements δ along k independent velocities, and the deviations δv of these velocities. δτ are the
/// deviations of the joint forces. The matrices N and D give the motion of all joints: their displacements
/// are N δ, and the deviations of their velocities are N δv + D δ.
struct IndependentLinearization {
  std::vector<int> velocities;  ///< the indices of the k independent velocities
  Eigen::MatrixXd N;            ///< nv × k; the identity in the rows of the independent velocities
  Eigen::MatrixXd D;            ///< nv × k; 0 in the rows of the independent velocities, and 0 at rest
  Eigen::MatrixXd A, B;         ///< 2k × 2k and 2k × nv
  Solvability solvability;      ///< if it is not ok(), A and B are NaN
};

/// Linearises the equations of motion, as x' = A x + B δτ, about a closed configuration q and velocities v
/// that keep the loops closed. x has the displacements along the independent velocities and the deviations of
/// these velocities, and δτ (nv) has the deviations of the joint forces. `velocities` are the indices of the
/// independent velocities, as many as there are degrees of freedom; if it is empty, the velocities that
/// determine all others best are chosen. Springs, dampers, mechanical stops and loads act, and also the
/// damping and friction of joints if loads.joint_losses is set. At an equilibrium with v = 0 the eigenvalues
/// of A describe the small oscillations. Allocates; O((nv + m)³) for m loop equations. Throws
/// std::invalid_argument for wrong sizes, for prescribed motions, for a state that leaves a loop open, for
/// drives with states, for a wrong number of independent velocities, and if they do not determine the other
/// velocities at q.
[[nodiscard]] IndependentLinearization independent_linearization(
    const Model& model, std::span<const double> q, std::span<const double> v, std::span<const double> tau,
    std::span<const int> velocities = {}, const Loads<double>& loads = {});

}  // namespace axode
