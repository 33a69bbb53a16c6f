#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/loops.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// Small motions of a mechanism with loops: x' = A x + B δτ of the deviations x = (δ, δv) of k velocities that are
/// independent, as `linearize` has them of all velocities. Those of all joints are N δ and N δv + D δ.
struct IndependentLinearization {
  std::vector<int> velocities;  ///< which of the nv they are, k
  Eigen::MatrixXd N;            ///< nv × k; the identity in the rows of these velocities
  Eigen::MatrixXd D;            ///< nv × k; 0 there, and at rest everywhere
  Eigen::MatrixXd A, B;         ///< 2k × 2k and 2k × nv
  Solvability solvability;      ///< where it is not ok(), A and B are NaN
};

/// At a closed configuration and velocities that keep it closed. Without `velocities` those are taken that determine the
/// others best. Springs, dampers and stops act as in `linearize`, loads and losses likewise. Where q is an equilibrium and
/// v = 0 the eigenvalues of A are those of its small oscillations; they do not depend on the choice of velocities. Allocates;
/// O((nv + m)³). Throws std::invalid_argument as independent_equations does, and
/// for a state that leaves a loop open.
[[nodiscard]] IndependentLinearization independent_linearization(
    const Model& model, std::span<const double> q, std::span<const double> v, std::span<const double> tau,
    std::span<const int> velocities = {}, const Loads<double>& loads = {});

}  // namespace axode
