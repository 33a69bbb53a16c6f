#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/loops.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// The equations of motion of a mechanism with loops in independent velocities y, which are some of its joint
/// velocities:
///   M y' + h = Nᵀ τ,   v = N y,   a = N y' + c.
struct IndependentEquations {
  std::vector<int> velocities;  ///< the indices of the k independent velocities
  Eigen::MatrixXd N;            ///< nv × k; the identity in the rows of the independent velocities
  Eigen::VectorXd c;            ///< nv; 0 in the rows of the independent velocities
  Eigen::MatrixXd M;            ///< k × k, Nᵀ M N with the mass matrix of the tree
  Eigen::VectorXd h;            ///< k, Nᵀ (M c + h) with the forces of the tree
};

/// Computes the equations of motion in independent velocities, at a closed configuration q and velocities v
/// that keep it closed. `velocities` are the indices of the independent velocities; if it is empty, the
/// velocities that determine the others best are chosen. Allocates; O(nv³). Throws std::invalid_argument for
/// wrong sizes, if the number of velocities is not nv minus the rank of A, and if they do not determine the
/// others at q.
[[nodiscard]] IndependentEquations independent_equations(const Model& model, std::span<const double> q,
                                                         std::span<const double> v,
                                                         std::span<const int> velocities = {},
                                                         const Loads<double>& loads = {});

}  // namespace axode
