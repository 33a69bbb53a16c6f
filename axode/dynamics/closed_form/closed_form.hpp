#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/dynamics/closed_form/coriolis.hpp"
#include "axode/recursion/loads.hpp"

/// The equations of motion in closed form, each as matrices of the whole system, for analysis. They are those
/// of section 5 of A. Müller, Screw and Lie group theory in multibody dynamics: recursive algorithms and
/// equations of motion of tree-topology systems (2018); equation labels are those of this paper. The
/// recursions give the same results and are faster. Mass matrices and drive forces include armatures. All
/// functions throw std::invalid_argument for wrong sizes.
namespace axode::closed_form {

/// The inertia matrix diag(M_1, ..., M_n) of all n bodies, 6n × 6n. The 6 × 6 matrix M_i maps the twist of
/// the frame of body i to the momentum of body i, both in representation Rep.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::MatrixXd inertia_matrix(const Model& model, std::span<const double> q);

/// The drive forces τ (nv) by the Euler-Jourdain equations (projection equations, Kane's equations): τ = Σ
/// J_iᵀ (M_i V'_i - ad_{V_i}ᵀ M_i V_i - W_i^app) (Müller, eq. PE), with the Jacobian J_i, the inertia matrix
/// M_i and the twist V_i of body i in representation Rep. The applied wrenches W_i^app include gravity.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::VectorXd projection_equations(const Model& model, std::span<const double> q, std::span<const double> v,
                                     std::span<const double> a, const Loads<double>& loads = {});

/// The drive forces τ (nv) by the balance of spatial momentum, projected onto the joint motions: τ = (J^s)ᵀ
/// (Π'^s - W^s,app) (Müller, eq. PEs). The spatial Jacobian J^s, momenta Π^s and applied wrenches W^s,app of
/// all bodies are stacked, and the applied wrenches include gravity.
Eigen::VectorXd momentum_balance(const Model& model, std::span<const double> q, std::span<const double> v,
                                 std::span<const double> a, const Loads<double>& loads = {});

/// The mass matrix Jᵀ M J (Müller, eq. MLE) plus armatures, nv × nv, with the stacked Jacobian J and the
/// inertia matrix M of all bodies.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::MatrixXd mass_matrix(const Model& model, std::span<const double> q);

/// The Coriolis matrix C(q, v), nv × nv, in the form `form`. It is computed by products of system matrices,
/// or by Christoffel symbols for the form `christoffel`.
Eigen::MatrixXd coriolis_matrix(const Model& model, std::span<const double> q, std::span<const double> v,
                                CoriolisForm form);

/// The drive forces τ (nv) by Lagrange's equations: τ = M a + C v + ∂U/∂q - Q (Müller, eq. LE), with the mass
/// matrix M, the Coriolis matrix C of eq. CMat, the potential energy U of gravity and the generalised forces
/// Q of the loads. The equation labels are those of A. Müller, Screw and Lie group theory in multibody
/// dynamics (2018); there are other matrices C with the same product C v.
Eigen::VectorXd lagrange_equations(const Model& model, std::span<const double> q, std::span<const double> v,
                                   std::span<const double> a, const Loads<double>& loads = {});

/// Christoffel symbols of the first kind with Binet's inertia tensor (Müller, eq. GammaBinet with
/// erratum 26 of docs/errata.md):
///   Γ_ijk = Σ_l tr(Ĵ_li P_l (Ĵ_lj Ĵ_lk)ᵀ),
/// summed over the bodies l that the joints of i, j and k all move, if the joint of j is that of k or nearer
/// to the ground; otherwise j and k are exchanged. Ĵ_li is the 4×4 matrix of column i of the body-fixed
/// Jacobian of body l, and P_l = [[ϑ_l, m c], [m cᵀ, m]] has Binet's tensor ϑ_l, the mass m and the centre of
/// mass c of body l. nv³ entries, Γ_ijk at [(i nv + j) nv + k]. Throws std::invalid_argument if a joint has
/// several degrees of freedom. O(n⁴).
std::vector<double> christoffel(const Model& model, std::span<const double> q);

}  // namespace axode::closed_form
