#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/dynamics/closed_form/coriolis.hpp"
#include "axode/recursion/loads.hpp"

/// Section 5 of the paper: the equations of motion in closed form, each function the equation in matrices of
/// the whole system. Meant for analysis and for reading; the recursions give the same and are faster.
/// Armatures are part of the mass matrix and of the forces, as everywhere. All throw std::invalid_argument
/// for wrong sizes.
namespace axode::closed_form {

/// M = diag(M_1, ..., M_n), 6n × 6n: the inertia matrices of the bodies in their frames, in representation
/// Rep.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::MatrixXd inertia_matrix(const Model& model, std::span<const double> q);

/// The Euler-Jourdain (projection, Kane) equations: τ = Jᵀ (M_i V'_i - ad_Vᵀ M_i V_i - W_i^app) (eq. PE), in
/// any representation with its own Newton-Euler equations. Gravity is an applied wrench.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::VectorXd projection_equations(const Model& model, std::span<const double> q, std::span<const double> v,
                                     std::span<const double> a, const Loads<double>& loads = {});

/// The projected balance of spatial momentum: τ = (J^s)ᵀ (Π'_i^s - W_i^s,app) (eq. PEs).
Eigen::VectorXd momentum_balance(const Model& model, std::span<const double> q, std::span<const double> v,
                                 std::span<const double> a, const Loads<double>& loads = {});

/// M = Jᵀ M J (eq. MLE), nv × nv.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::MatrixXd mass_matrix(const Model& model, std::span<const double> q);

/// The Coriolis matrix by the formula of its form (eq. CMat; C'; the spatial one), and Σ Γ_ijk v_k.
Eigen::MatrixXd coriolis_matrix(const Model& model, std::span<const double> q, std::span<const double> v,
                                CoriolisForm form);

/// Lagrange's equations: τ = M a + C v + ∂U/∂q - Q (eq. LE) with the paper's C.
Eigen::VectorXd lagrange_equations(const Model& model, std::span<const double> q, std::span<const double> v,
                                   std::span<const double> a, const Loads<double>& loads = {});

/// Christoffel symbols of the first kind with Binet's inertia tensor (eq. GammaBinet with erratum 26), Γ_ijk
/// = Σ_l tr(Ĵ_li P_l (Ĵ_lj Ĵ_lk)ᵀ) for j not behind k, with 4×4 matrices Ĵ of body-fixed columns and P_l =
/// [[ϑ_l, m c], [m cᵀ, m]]. nv³ entries, Γ_ijk at [(i nv + j) nv + k]; all joints must have one degree of
/// freedom, else std::invalid_argument. O(n⁴).
std::vector<double> christoffel(const Model& model, std::span<const double> q);

}  // namespace axode::closed_form
