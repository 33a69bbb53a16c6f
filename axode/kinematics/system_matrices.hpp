#pragma once
#include <Eigen/SparseCore>

#include "axode/lie/twist.hpp"
#include "axode/model/model.hpp"

/// The kinematics of the whole system as sparse block matrices over the bodies 1..n in the frames that the
/// user placed: six rows for each body, angular before linear; blocks of bodies that are not on one path are
/// zero. The matrices are meant for analysis and for reading the paper; the recursions are faster. All
/// functions throw std::invalid_argument for wrong sizes.
namespace axode {

using SystemMatrix = Eigen::SparseMatrix<double>;

/// The matrices of V = A X v with (I - D) A = I (eqs. VbAX, JbSys): D holds the transformation of the
/// predecessor's twist at the block (i, predecessor(i)), A its products along the paths, X the joint screws,
/// 6n × nv.
struct SystemMatrices {
  SystemMatrix A, D, X;
};
/// The system matrices in representation Rep. A^b has blocks Ad_{C_ij}, A^h has Ad_{r_ij}; spatial D has
/// identities, and X the instantaneous screws J_i^s, so that A is the lower block-triangular identity L.
template <RecursionRepresentation Rep = BodyFixed>
SystemMatrices system_matrices(const Model& model, std::span<const double> q);

/// The other factorisations of the spatial Jacobian, J^s = A^s Y^s = A^sb X^b (eq. JbSys), with constant Y^s
/// = diag(Y_i).
struct SpatialFactors {
  SystemMatrix A_s, Y_s, A_sb;
};
SpatialFactors spatial_factors(const Model& model, std::span<const double> q);

/// The matrix a^b(v) = diag(ad_{X_i v_i}), 6n × 6n (eq. ab), with which J^b' = -A^b a^b D^b J^b. If every
/// joint has one degree of freedom, a^b X^b = 0 and this is -A^b a^b J^b (eq. u:Jb_dot matrix).
SystemMatrix a_matrix(const Model& model, std::span<const double> v);
/// The matrix b(V) = diag(ad_{V_1}, ..., ad_{V_n}) of stacked body-fixed or spatial twists (eqs. bb, bs).
SystemMatrix b_matrix(const Model& model, const Eigen::VectorXd& V);

/// The twists V = J v of all bodies, stacked in one vector of 6n numbers.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::VectorXd system_twist(const Model& model, std::span<const double> q, std::span<const double> v);
/// The twist rates V' of all bodies, stacked in one vector of 6n numbers.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::VectorXd system_acceleration(const Model& model, std::span<const double> q, std::span<const double> v,
                                    std::span<const double> a);

/// The velocities v that belong to given twists of all bodies, (XᵀX)⁻¹ Xᵀ (I - D) V: the overall inverse
/// kinematics. If no v gives V, the result is the least-squares solution.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::VectorXd joint_velocities(const Model& model, std::span<const double> q, const Eigen::VectorXd& V);
/// The accelerations that belong to given twists and twist rates of all bodies, (XᵀX)⁻¹ Xᵀ ((I - D) V' -
/// bias) (eq. solqddot1, where the bias is -a^b V^b).
template <RecursionRepresentation Rep = BodyFixed>
Eigen::VectorXd joint_accelerations(const Model& model, std::span<const double> q, const Eigen::VectorXd& V,
                                    const Eigen::VectorXd& dV);

}  // namespace axode
