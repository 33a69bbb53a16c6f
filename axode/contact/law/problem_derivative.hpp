#pragma once
#include <functional>

#include "axode/contact/law/velocity_problem.hpp"
#include "axode/recursion/changes.hpp"

namespace axode {

/// The derivative of the multipliers λ and the motion w + Y λ that solve a contact problem, a column for each
/// given change (direction) of the data w, Y and r of the problem. With the mass matrix Lᵀ D L, w is D^½ L v
/// for the joint velocities v without impulses, and Y = D^-½ L⁻ᵀ Jᵀ for the Jacobian J of the constraint
/// rows. r is a given velocity for each row, such as that with which a contact bounces.
struct ProblemDerivative {
  Eigen::MatrixXd multipliers;  ///< dλ of rows scaled by friction coefficients, rows × directions
  Eigen::MatrixXd motion;       ///< d(w + Y λ), nv × directions
  /// Whether the velocities after the impulses have a derivative along each given change of the data of a
  /// contact problem. They may have none if contacts that slide are redundant, so that the laws do not
  /// determine how they share a load. They may also have none if the velocities that are given for redundant
  /// contacts, such as those with which they bounce, change in contradictory ways.
  bool unique = true;
  /// Whether a contact, stop or joint with friction is within rounding of the boundary between two branches
  /// of its law, such as stick and slide. The derivative is then that of the branch that was taken.
  bool at_kink = false;
};

/// Differentiates the multipliers λ of constraint rows that solve a contact problem with the data w, Y and r,
/// along k given changes of the data (D11.11). The velocities of the rows are u = Yᵀ (w + Y λ) + r. With the
/// mass matrix Lᵀ D L, w is D^½ L v for the joint velocities v without impulses, and Y = D^-½ L⁻ᵀ Jᵀ for the
/// Jacobian J of the rows. r is a given velocity for each row, such as that with which a contact bounces.
/// Friction rows of J, r and u are multiplied by their coefficients of friction. Column by column for the
/// changes, dx (nv × k) is dw + dY λ, and du (rows × k) is dYᵀ (w + Y λ) + dr. If contacts are redundant, so
/// that the laws do not determine how they share a load, the dλ with the least Σ d² dλ² is returned, where d²
/// is about the diagonal entry of Yᵀ Y for a row. Allocates; O(rows³).
ProblemDerivative differentiate(const VelocityProblem& problem, const double* lambda,
                                const Eigen::Ref<const Eigen::MatrixXd>& dx,
                                const Eigen::Ref<const Eigen::MatrixXd>& du);

/// The derivative of multipliers λ that obey contact laws together with the velocities u of the constraint
/// rows. u depends on λ and on other data, such as the state or parameters. The derivative has a column for
/// each of the given changes (directions) of these data, each of which is given by the change of u at
/// constant λ.
struct LawDerivative {
  Changes multipliers;                  ///< dλ of rows scaled by friction coefficients, rows × directions
  bool unique = true, at_kink = false;  ///< see ProblemDerivative
};

/// Differentiates multipliers λ that obey the laws of contact and friction together with velocities u of the
/// constraint rows, where u is any differentiable function of λ and of some data. The laws are λ = resolve(z)
/// with the trial impulse z = λ - u/d²: `resolve` maps a trial impulse to the impulse that the law allows,
/// and d² is about the diagonal entry of J M⁻¹ Jᵀ for a row, with the Jacobian J of the rows and the mass
/// matrix M. by_lambda (rows × rows) is ∂u/∂λ. Each column of by_data (rows × directions) is the change of u
/// at constant λ for one change (direction) of the data. The multipliers change by
///   (1 - Z + Z d⁻² by_lambda) dλ = -Z d⁻² by_data                                                 (D11.18)
/// with the derivative Z of `resolve` at z. Friction rows of u and J are multiplied by their coefficients of
/// friction; the impulse of such a row is λ times its coefficient. `speed` is the size √(vᵀ M v) of the
/// velocities v of the mechanism, and `change` returns the size of their changes along the directions;
/// rounding errors are judged by both. `change` is called only if the equations for dλ are singular, as they
/// are where contacts share a load. Allocates; O(rows³).
LawDerivative differentiate_law(const VelocityProblem& problem, const double* lambda, const double* u,
                                const Eigen::Ref<const Eigen::MatrixXd>& by_lambda, const Changes& by_data,
                                double speed, const std::function<double()>& change);

}  // namespace axode
