#pragma once
#include <span>

#include "axode/kinematics/system_matrices.hpp"
#include "tests/paper/equation.hpp"

/// Derivatives of Jacobian columns, computed without formulas. Whatever depends on the motion is a series: in
/// t, or in one ε for each coordinate with respect to which it is differentiated. The templates are compiled
/// for all four representations.
namespace axode::test::paper {

inline Vec6 bracket(const Vec6& X, const Vec6& Y) { return ad(X) * Y; }

using One = Taylor<double, 2>;
using Two = Taylor<One, 2>;
using Three = Taylor<Two, 2>;
/// The poses of all frames at any configuration, in the scalar types Two, Three and Taylor<Three, 2>.
template <class T> std::vector<SE3<T>> poses_on(const Motion& m, const std::vector<T>& q);

/// ∂^ν J_{i,j} / ∂q_α1 ... ∂q_αν for the ν <= 3 joints in `alpha`; from C_i, by the definitions of appendix
/// A.
template <class Rep> Vec6 partial_of(const Motion& m, int i, int j, const std::vector<int>& alpha);

/// The Jacobian of body i as the library computes it, one column for each velocity.
template <class Rep> Matrix jacobian_of(const Motion& m, int i);
/// The partial derivatives of the Jacobian of body i of an order ν as the library computes them; column ((αν
/// nv + ...) nv + α1) nv + j.
template <class Rep> Matrix partials_of(const Motion& m, int i, int order);
/// ∂J_{i,j} / ∂q_k as the library computes it.
template <class Rep> Vec6 library_partial(const Motion& m, int i, int j, int k);
/// The rate of the Jacobian as the library computes it, and its column J̇_{i,j}.
template <class Rep> Matrix jacobian_rate(const Motion& m, int i);
template <class Rep> Vec6 library_dJ(const Motion& m, int i, int j);
inline int velocity(const Motion& m, int j) { return m.model().joint(j).iv; }

// ------------------------------------------------------------------ along a motion, of joints with one screw

/// The third derivative of the coordinate of joint j; a Motion has none.
inline double qddd(int j) { return (j % 2 == 0 ? 1 : -1) * (0.6 + 0.15 * j); }
template <class Rep> Vec6 dJ(const Motion& m, int i, int j);
template <class Rep> Vec6 ddJ(const Motion& m, int i, int j);
/// The second derivative of the twist of body i.
template <class Rep> Vec6 ddV(const Motion& m, int i);
/// The library's results for the higher derivatives of the motion with these third derivatives.
HigherOrderMotion<> jerk_motion(const Motion& m);
template <class Rep> TwistRate<Rep> jerk(const Motion& m, int i);

/// ∂(C_f⁻¹ C_g) / ∂q_k from the library's products of exponentials.
Mat4 relative_pose_partial(const Motion& m, int f, int g, int k);

// -------------------------------------------------------------------------------- all bodies, one on another

/// The matrices f(i) of all bodies, one below the other; each has six rows.
Matrix stacked(const Motion& m, const std::function<Matrix(int i)>& f);
template <class Rep> Matrix system_jacobian(const Motion& m);
template <class Rep> Matrix system_V(const Motion& m);
template <class Rep> Matrix system_dV(const Motion& m);
/// The library's matrices of the whole system.
struct MatricesOfSystem {
  Matrix A, D, X;
  MatricesOfSystem(const SystemMatrices& s) : A(s.A), D(s.D), X(s.X) {}
};
/// The joint accelerations that the library computes from the body-fixed twists of all bodies and their
/// rates.
Matrix joint_accelerations_of(const Motion& m);
inline Matrix as_vector(const std::vector<double>& x) { return Matrix(x); }
/// diag(f(1), ..., f(n)).
Matrix block_diagonal_of(const Motion& m, const std::function<Mat6(int i)>& f);

using CheckOfMotion = std::function<void(Equation&, const Motion&)>;
/// Calls check for every motion.
void each_system(const CheckOfMotion& check);
void each_system_with_one_screw_joints(const CheckOfMotion& check);

}  // namespace axode::test::paper
