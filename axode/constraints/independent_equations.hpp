#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/loops.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// The equations of motion of a mechanism with loops in velocities y that are independent, some of those of its joints:
///   M y' + h = Nᵀ τ,   v = N y,   a = N y' + c.
struct IndependentEquations {
  std::vector<int> velocities;  ///< which of the nv they are, k
  Eigen::MatrixXd N;            ///< nv × k; the identity in the rows of these velocities
  Eigen::VectorXd c;            ///< nv; 0 there
  Eigen::MatrixXd M;            ///< k × k, Nᵀ M N with the mass matrix of the tree
  Eigen::VectorXd h;            ///< k, Nᵀ (M c + h) with the forces of the tree
};

/// At a closed configuration and velocities that keep it closed. Without `velocities` those are taken that determine the
/// others best. Allocates; O(nv³). Throws std::invalid_argument for wrong sizes, and where the velocities are more or fewer
/// than the loops leave (nv less the rank of A), or do not determine the others at q.
[[nodiscard]] IndependentEquations independent_equations(const Model& model, std::span<const double> q,
                                                         std::span<const double> v,
                                                         std::span<const int> velocities = {},
                                                         const Loads<double>& loads = {});

}  // namespace axode
