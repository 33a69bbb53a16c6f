#pragma once
#include "axode/contact/law/velocity_problem.hpp"

namespace axode {

/// The derivative of the solution of a VelocityProblem along given directions, a column for each direction. A
/// direction is a change of the data w, Y and r of the problem.
struct ProblemDerivative {
  Eigen::MatrixXd multipliers;  ///< dλ of rows scaled by friction coefficients, rows × directions
  Eigen::MatrixXd motion;       ///< d(w + Y λ), nv × directions
  /// Whether the motion w + Y λ has a derivative along each given change of the data w, Y and r of a contact
  /// problem. It may have none if contacts that slide are redundant, so that the laws do not determine how
  /// they share a load, or if the prescribed velocities r of redundant contacts change in contradictory ways.
  bool unique = true;
  /// Whether a contact, stop or joint with friction is within rounding of the boundary between two branches
  /// of its law, such as stick and slide. The derivative is then that of the branch that was taken.
  bool at_kink = false;
};

/// Differentiates the multipliers λ of constraint rows that solve a problem of contact (D11.11), along k
/// changes of its data w, Y and r. The velocities of the rows are u = Yᵀ (w + Y λ) + r. With the mass matrix
/// M = Lᵀ D L, w is D^½ L v for the joint velocities v without impulses, and Y = D^-½ L⁻ᵀ Jᵀ for the Jacobian
/// J of the rows. r has a given velocity for each row, such as the one with which a contact bounces. Friction
/// rows of J, r and u are multiplied by their coefficients of friction. dx (nv × k) has the changes dw + dY
/// λ, and du (rows × k) the changes dYᵀ (w + Y λ) + dr. If contacts are redundant, so that the laws do not
/// determine how they share a load, dλ is not unique; then the dλ with the least Σ d² dλ² is returned, where
/// d² is about the diagonal entry of Yᵀ Y for a row. Allocates; O(rows³).
ProblemDerivative differentiate(const VelocityProblem& problem, const double* lambda,
                                const Eigen::Ref<const Eigen::MatrixXd>& dx,
                                const Eigen::Ref<const Eigen::MatrixXd>& du);

/// The derivative of multipliers that obey contact laws, a column for each given change (direction) of the
/// data on which the velocities of the constraint rows depend.
struct LawDerivative {
  Eigen::MatrixXd multipliers;          ///< dλ of rows scaled by friction coefficients, rows × directions
  bool unique = true, at_kink = false;  ///< see ProblemDerivative
};

/// Differentiates multipliers λ that obey the laws of a problem if the velocities u of the rows depend on
/// λ in any way. The laws are λ = resolve(z) with the trial impulse z = λ - u/d²: `resolve` maps a trial
/// impulse to the impulse that the law allows, and d² is about the diagonal entry of the matrix J M⁻¹ Jᵀ
/// for a row, with the Jacobian J of the rows and the mass matrix M. by_lambda (rows × rows) is ∂u/∂λ at
/// constant data. by_data (rows × directions) is the change of u at constant λ for each direction, a change
/// of the data.
/// The multipliers change by
///   (1 - Z + Z d⁻² by_lambda) dλ = -Z d⁻² by_data                                                 (D11.18)
/// with the derivative Z of `resolve` at z. In u, J and their changes, the rows of friction are multiplied
/// by their coefficients of friction, so that the impulse of such a row is λ times its coefficient.
/// `speed` is the size √(vᵀ M v) of the velocities of the mechanism, and `change` is that of their changes
/// along the directions; rounding errors are judged by them. Allocates; O(rows³).
LawDerivative differentiate_law(const VelocityProblem& problem, const double* lambda, const double* u,
                                const Eigen::Ref<const Eigen::MatrixXd>& by_lambda,
                                const Eigen::Ref<const Eigen::MatrixXd>& by_data, double speed,
                                double change);

}  // namespace axode
