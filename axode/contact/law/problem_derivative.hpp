#pragma once
#include "axode/contact/law/velocity_problem.hpp"

namespace axode {

/// The derivative of the solution of a VelocityProblem, a column for each direction.
struct ProblemDerivative {
  Eigen::MatrixXd multipliers;  ///< dλ in scaled rows, rows × directions
  Eigen::MatrixXd motion;       ///< d(w + Y λ), nv × directions
  /// Whether the motion has a derivative. Contacts that share a load and slide may not have one, because
  /// friction depends on their share; nor do redundant contacts along changes of r that contradict each
  /// other.
  bool unique = true;
  /// Whether a block is within rounding of the boundary between two branches of its law. The derivative is
  /// then that of the branch that was taken.
  bool at_kink = false;
};

/// Differentiates the solution λ of a problem (D11.11) along changes of its data: dx (nv × k) is dw + dY λ,
/// and du (rows × k) is dYᵀ (w + Y λ) + dr, in scaled rows. Of the changes of multipliers that shared loads
/// allow, the least one in the metric of the masses is given. Allocates; O(rows³).
ProblemDerivative differentiate(const VelocityProblem& problem, const double* lambda,
                                const Eigen::Ref<const Eigen::MatrixXd>& dx,
                                const Eigen::Ref<const Eigen::MatrixXd>& du);

/// The change of multipliers that obey the laws of a problem, a column for each direction.
struct LawDerivative {
  Eigen::MatrixXd multipliers;          ///< dλ in scaled rows, rows × directions
  bool unique = true, at_kink = false;  ///< see ProblemDerivative
};

/// Where the rows of a problem have velocities u that depend on λ in any way, with the derivatives by_lambda
/// (rows × rows) at constant data, and by_data (rows × directions) at constant λ, the multipliers change by
///   (1 - Z + Z d⁻² by_lambda) dλ = -Z d⁻² by_data,   Z at z = λ - u/d²                            (D11.18)
/// All rows are scaled. `speed` is the size of the velocities in the metric of the masses, and `change` that
/// of their changes along the directions. Allocates; O(rows³).
LawDerivative differentiate_law(const VelocityProblem& problem, const double* lambda, const double* u,
                                const Eigen::Ref<const Eigen::MatrixXd>& by_lambda,
                                const Eigen::Ref<const Eigen::MatrixXd>& by_data, double speed,
                                double change);

}  // namespace axode
