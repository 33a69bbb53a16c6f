#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/loops.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// The equations of motion of a mechanism with loops in k independent velocities y, which are entries of its
/// joint velocities v:
///   M y' + h = Nᵀ τ,   v = N y,   a = N y' + c
/// with the mass matrix M (k × k), the bias forces h, the joint forces τ, and the joint accelerations a. N
/// (nv × k) and c depend on the state; N y are the velocities that keep the loops closed.
struct IndependentEquations {
  std::vector<int> velocities;  ///< the indices of the k independent velocities
  Eigen::MatrixXd N;            ///< nv × k; the identity in the rows of the independent velocities
  Eigen::VectorXd c;            ///< nv numbers; 0 in the rows of the independent velocities
  Eigen::MatrixXd M;            ///< k × k: Nᵀ M_t N with the mass matrix M_t of the tree
  Eigen::VectorXd h;            ///< k numbers: Nᵀ (M_t c + h_t) with the bias forces h_t of the tree
};

/// Computes the equations of motion in independent velocities, at a closed configuration q and velocities v
/// that keep the loops closed. `velocities` are the indices of the independent velocities, as many as there
/// are degrees of freedom; if it is empty, the velocities that determine all others best are chosen. Springs
/// are ignored; their forces spring_forces(q, v) can be added to the joint forces τ. Allocates; O(nv³).
/// Throws std::invalid_argument for wrong sizes, for prescribed motions, for a wrong number of independent
/// velocities, and if they do not determine the other velocities at q.
[[nodiscard]] IndependentEquations independent_equations(const Model& model, std::span<const double> q,
                                                         std::span<const double> v,
                                                         std::span<const int> velocities = {},
                                                         const Loads<double>& loads = {});

}  // namespace axode
