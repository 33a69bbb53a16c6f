#pragma once
#include <Eigen/SparseCore>

#include "axode/lie/twist.hpp"
#include "axode/model/model.hpp"

/// The kinematics of the whole system as sparse block matrices over the bodies 1..n, for analysis; the
/// recursions are faster. Each body has six rows, angular before linear, in the body frame that the user
/// placed. The block of two bodies that are not on one path to the ground is zero. All functions throw
/// std::invalid_argument for wrong sizes.
namespace axode {

using SystemMatrix = Eigen::SparseMatrix<double>;

/// The matrices A, D and X in V = A X v, where V has the twists of all n bodies one below the other, and A =
/// (I - D)⁻¹ (Müller, eqs. VbAX, JbSys). X (6n × nv) has the joint screws. Block (i, p) of D (6n × 6n)
/// transforms the twist of the predecessor p to body i, and block (i, j) of A (6n × 6n) transforms the twist
/// of body j, on the path from the ground to i, to body i.
struct SystemMatrices {
  SystemMatrix A, D, X;
};
/// Computes the matrices A, D and X of V = A X v and A = (I - D)⁻¹ in representation Rep. V has the twists of
/// all bodies, v the joint velocities, and X the joint screws, which depend on q unless they are body-fixed.
/// D transforms twists from each predecessor to its body, and block (i, j) of A from body j on the path from
/// the ground to body i. This block is Ad_{C_ij} in the body-fixed representation, with the pose C_ij of body
/// j relative to body i, Ad_{r_ij} in the hybrid one, with the vector r_ij from the origin of body i to that
/// of body j, and the identity in the spatial one.
template <RecursionRepresentation Rep = BodyFixed>
SystemMatrices system_matrices(const Model& model, std::span<const double> q);

/// The matrices of two factorisations J^s = A_s Y_s = A_sb X^b of the spatial Jacobians J^s of all bodies,
/// one below the other (Müller, eq. JbSys). Y_s has the joint screws in the inertial frame at q = 0, and X^b,
/// which system_matrices<BodyFixed>() returns as X, has the joint screws in the body frames; both are
/// constant. Block (i, j) of A_s and of A_sb transforms the screw of joint j, which is on the path to body i,
/// from the constant screw in Y_s or X^b to the present spatial screw.
struct SpatialFactors {
  SystemMatrix A_s, Y_s, A_sb;
};
SpatialFactors spatial_factors(const Model& model, std::span<const double> q);

/// The matrix a^b(v) = diag(ad_{X_i v_i}), 6n × 6n (Müller, eq. ab), with the joint screws X_i in the body
/// frames. Let D transform body-fixed twists from each predecessor to its body, and A = (I - D)⁻¹. Then the
/// stacked body-fixed Jacobian J of all bodies has the rate J' = -A a^b D J, or -A a^b J if every joint has
/// one degree of freedom (Müller, eq. u:Jb_dot matrix).
SystemMatrix a_matrix(const Model& model, std::span<const double> v);
/// The matrix b(V) = diag(ad_{V_1}, ..., ad_{V_n}), 6n × 6n, of the body-fixed or spatial twists V_i of all
/// bodies (Müller, eqs. bb, bs).
SystemMatrix b_matrix(const Model& model, const Eigen::VectorXd& V);

/// The twists V = J v of all bodies at (q, v), stacked in one vector of 6n numbers.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::VectorXd system_twist(const Model& model, std::span<const double> q, std::span<const double> v);
/// The twist rates V' of all bodies at (q, v, a), stacked in one vector of 6n numbers.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::VectorXd system_acceleration(const Model& model, std::span<const double> q, std::span<const double> v,
                                    std::span<const double> a);

/// Overall inverse kinematics: the velocities v = (XᵀX)⁻¹ Xᵀ (I - D) V of the joints for given twists V of
/// all bodies, where X has the joint screws and D transforms twists from each predecessor to its body
/// (system_matrices()). If no v gives V, this is a least-squares solution.
template <RecursionRepresentation Rep = BodyFixed>
Eigen::VectorXd joint_velocities(const Model& model, std::span<const double> q, const Eigen::VectorXd& V);
/// The accelerations of the joints for given twists V and twist rates V' of all bodies, (XᵀX)⁻¹ Xᵀ ((I - D)
/// V' - bias) (Müller, eq. solqddot1). X has the joint screws, and D transforms twists from each predecessor
/// to its body (system_matrices()). The bias is the part of (I - D) V' that is due to velocities; in the
/// body-fixed representation it is -a^b V with a^b = diag(ad_{X_i v_i}).
template <RecursionRepresentation Rep = BodyFixed>
Eigen::VectorXd joint_accelerations(const Model& model, std::span<const double> q, const Eigen::VectorXd& V,
                                    const Eigen::VectorXd& dV);

}  // namespace axode
