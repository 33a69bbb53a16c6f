#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/dynamics/closed_form/coriolis.hpp"
#include "axode/recursion/loads.hpp"

/// The equations of motion in closed form (section 5 of the paper). Each function evaluates one equation in
/// matrices of the whole system. It is meant for analysis and for reading the paper; the recursions give the
/// same results and are faster. Armatures are part of the mass matrix and of the forces, as everywhere. All
/// functions throw std::invalid_argument for wrong sizes.
namespace axode::closed_form {

/// M = diag(M_1, ..., M_n), 6n × 6n: the inertia matrices of the bodies in their frames, in representation
/// Rep.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::MatrixXd inertia_matrix(const Model& model, std::span<const double> q);

/// The forces by the Euler-Jourdain equations (projection equations, Kane's equations): τ = Jᵀ (M_i V'_i -
/// ad_Vᵀ M_i V_i - W_i^app) (eq. PE). Each representation uses its own Newton-Euler equations. Gravity is an
/// applied wrench.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::VectorXd projection_equations(const Model& model, std::span<const double> q, std::span<const double> v,
                                     std::span<const double> a, const Loads<double>& loads = {});

/// The forces by the projected balance of spatial momentum: τ = (J^s)ᵀ (Π'_i^s - W_i^s,app) (eq. PEs).
Eigen::VectorXd momentum_balance(const Model& model, std::span<const double> q, std::span<const double> v,
                                 std::span<const double> a, const Loads<double>& loads = {});

/// The mass matrix Jᵀ M J (eq. MLE) with the stacked Jacobian J and the inertia matrix M of all bodies, nv ×
/// nv.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::MatrixXd mass_matrix(const Model& model, std::span<const double> q);

/// The Coriolis matrix of a form, nv × nv: the paper's C (eq. CMat), C', the spatial one, or Σ Γ_ijk v_k.
Eigen::MatrixXd coriolis_matrix(const Model& model, std::span<const double> q, std::span<const double> v,
                                CoriolisForm form);

/// The forces by Lagrange's equations: τ = M a + C v + ∂U/∂q - Q (eq. LE) with the paper's C.
Eigen::VectorXd lagrange_equations(const Model& model, std::span<const double> q, std::span<const double> v,
                                   std::span<const double> a, const Loads<double>& loads = {});

/// Christoffel symbols of the first kind with Binet's inertia tensor (eq. GammaBinet with erratum 26), Γ_ijk
/// = Σ_l tr(Ĵ_li P_l (Ĵ_lj Ĵ_lk)ᵀ) if j is not after k on a path; otherwise j and k are exchanged. Ĵ are the
/// 4×4 matrices of body-fixed columns, and P_l = [[ϑ_l, m c], [m cᵀ, m]]. The result has nv³ entries, Γ_ijk
/// at [(i nv + j) nv + k]. Throws std::invalid_argument if a joint has several degrees of freedom. O(n⁴).
std::vector<double> christoffel(const Model& model, std::span<const double> q);

}  // namespace axode::closed_form
