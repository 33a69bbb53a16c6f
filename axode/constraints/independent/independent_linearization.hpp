#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/loops.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// Small motions of a mechanism with loops: x' = A x + B δτ for the deviations x = (δ, δv) of k independent
/// velocities, as `linearize` computes them for all velocities of a tree. The deviations of all joints are N
/// δ and N δv + D δ.
struct IndependentLinearization {
  std::vector<int> velocities;  ///< the indices of the k independent velocities
  Eigen::MatrixXd N;            ///< nv × k; the identity in the rows of the independent velocities
  Eigen::MatrixXd D;            ///< nv × k; 0 in the rows of the independent velocities, and 0 at rest
  Eigen::MatrixXd A, B;         ///< 2k × 2k and 2k × nv
  Solvability solvability;      ///< if it is not ok(), A and B are NaN
};

/// Computes the small motions about a closed configuration q and velocities v that keep it closed.
/// `velocities` are the indices of the independent velocities; if it is empty, the velocities that determine
/// the others best are chosen. Springs, dampers, stops, loads and losses act as in `linearize`. At an
/// equilibrium with v = 0 the eigenvalues of A are those of the small oscillations; they do not depend on the
/// choice of velocities. Allocates; O((nv + m)³). Throws std::invalid_argument as independent_equations does,
/// for a state that leaves a loop open, and for drives with states.
[[nodiscard]] IndependentLinearization independent_linearization(
    const Model& model, std::span<const double> q, std::span<const double> v, std::span<const double> tau,
    std::span<const int> velocities = {}, const Loads<double>& loads = {});

}  // namespace axode
