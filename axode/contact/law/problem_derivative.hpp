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

}  // namespace axode
