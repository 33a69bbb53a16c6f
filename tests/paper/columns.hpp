#pragma once
#include "axode/kinematics/system_matrices.hpp"
#include "tests/paper/equation.hpp"
#include "tests/support/any_scalar.hpp"

/// Derivatives of Jacobian columns without formulas. What moves is a series: in t, or in one ε for each
/// coordinate in which is differentiated.
namespace axode::test::paper {

using Mat4 = Eigen::Matrix4d;

inline Vec6 bracket(const Vec6& X, const Vec6& Y) { return ad(X) * Y; }

/// The poses of all frames at any configuration.
template <class T> std::vector<SE3<T>> poses_on(const Motion& m, const std::vector<T>& q) {
  return frame_poses(axode::cast<T>(m.model().tree<double>()), q);
}

/// J_{i,j}(q), on any scalar: from C_i and its derivative in q_j, by the definitions of appendix A.
template <class Rep, class T> Vector6<T> column_of(const Motion& m, int i, int j, const std::vector<T>& q) {
  using Along = Taylor<T, 2>;
  std::vector<Along> q_moved(q.begin(), q.end());
  q_moved[m.model().joint(j).iq].c[1] = T(1);
  const SE3<Along> C = poses_on(m, q_moved)[i];
  const auto part = [](const Vec3<Along>& x, int k) { return Vec3<T>{x.x.c[k], x.y.c[k], x.z.c[k]}; };
  const SO3<T> R{part(C.R.x, 0), part(C.R.y, 0), part(C.R.z, 0)};
  const Vec3<T> dx = part(C.R.x, 1), dy = part(C.R.y, 1), dz = part(C.R.z, 1);
  const Vec3<T> w_b{dot(R.z, dy), dot(R.x, dz), dot(R.y, dx)}, w_s = R * w_b, dr = part(C.r, 1),
                                                               r = part(C.r, 0);
  if constexpr (std::same_as<Rep, BodyFixed>) return to_eigen(Screw<T>{w_b, transpose(R) * dr});
  if constexpr (std::same_as<Rep, Spatial>) return to_eigen(Screw<T>{w_s, dr + cross(r, w_s)});
  if constexpr (std::same_as<Rep, Hybrid>) return to_eigen(Screw<T>{w_s, dr});
  return to_eigen(Screw<T>{w_b, dr});
}

template <int Order> struct Nested { using type = Taylor<typename Nested<Order - 1>::type, 2>; };
template <> struct Nested<0> { using type = double; };
inline double innermost(double x) { return x; }
template <class T> double innermost(const Taylor<T, 2>& x) { return innermost(x.c[1]); }
inline void move(double&, const int*, int) {}
template <class T> void move(Taylor<T, 2>& x, const int* alpha, int c) {
  move(x.c[0], alpha + 1, c);
  if (*alpha == c) x.c[1] = T(1);
}

/// ∂^ν J_{i,j} / ∂q_α1 ... ∂q_αν of joints α.
template <class Rep, std::size_t Order>
Vec6 partial_of(const Motion& m, int i, int j, const std::array<int, Order>& alpha) {
  using T = typename Nested<static_cast<int>(Order)>::type;
  std::vector<T> q(m.q().begin(), m.q().end());
  for (int k = 1; k <= m.n(); ++k) move(q[m.model().joint(k).iq], alpha.data(), k);
  const Vector6<T> J = column_of<Rep>(m, i, j, q);
  Vec6 d;
  for (int r = 0; r < 6; ++r) d[r] = innermost(J[r]);
  return d;
}

/// The library's answers about body i, one column for each velocity.
template <class Columns> Mat6X matrix_of(const Columns& columns) {
  Mat6X J(6, static_cast<int>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) J.col(static_cast<int>(c)) = to_eigen(columns[c]);
  return J;
}
template <class Rep> Mat6X jacobian_of(const Motion& m, int i) {
  std::vector<Twist<Rep>> J(m.v().size());
  Workspace<double> workspace(m.model());
  jacobian<Rep>(m.model(), workspace, m.q(), i, J);
  return matrix_of(J);
}
/// Partials of an order, column ((αν nv + ...) nv + α1) nv + j.
template <class Rep> Mat6X partials_of(const Motion& m, int i, int order) {
  std::size_t size = m.v().size();
  for (int k = 0; k < order; ++k) size *= m.v().size();
  std::vector<Twist<Rep>> J(size);
  Workspace<double> workspace(m.model());
  jacobian_partials<Rep>(m.model(), workspace, m.q(), i, order, J);
  return matrix_of(J);
}
/// The rate of the Jacobian.
template <class Rep> Mat6X jacobian_rate(const Motion& m, int i) {
  std::vector<double> rates = m.v();
  rates.insert(rates.end(), m.a().begin(), m.a().end());
  HigherOrderMotion<> motion(m.model(), 1);
  motion.evaluate(m.q(), rates);
  std::vector<TwistRate<Rep>> J(m.v().size());
  motion.jacobian_derivative<Rep>(i, 1, J);
  return matrix_of(J);
}
inline int velocity(const Motion& m, int j) { return m.model().joint(j).iv; }

// ------------------------------------------------------------------------ along a motion, of joints with one screw

/// The third derivatives of the coordinates, for which the motion has room.
inline double qddd(int j) { return (j % 2 == 0 ? 1 : -1) * (0.6 + 0.15 * j); }
/// J_{i,j} along the motion, to the second order in t.
template <class Rep> Vec6OfT column_of_t(const Motion& m, int i, int j) {
  std::vector<Series> q(m.q().begin(), m.q().end());
  for (int k = 1; k <= m.n(); ++k) {
    Series& q_k = q[m.model().joint(k).iq];
    q_k.c[1] = m.qd(k)[0], q_k.c[2] = m.qdd(k)[0] / 2;
  }
  return column_of<Rep>(m, i, j, q);
}
template <class Rep> Vec6 dJ(const Motion& m, int i, int j) { return rate(column_of_t<Rep>(m, i, j)); }
template <class Rep> Vec6 ddJ(const Motion& m, int i, int j) {
  return rate(derivative(column_of_t<Rep>(m, i, j)));
}
/// The second derivative of the twist of body i.
template <class Rep> Vec6 ddV(const Motion& m, int i) {
  Vec6OfT V = Vec6OfT::Zero();
  for (const int j : m.path(i)) {
    Series qd;
    qd.c = {m.qd(j)[0], m.qdd(j)[0], qddd(j) / 2};
    V += column_of_t<Rep>(m, i, j) * qd;
  }
  return rate(derivative(V));
}
/// The library's series of that motion.
inline HigherOrderMotion<> jerk_motion(const Motion& m) {
  std::vector<double> rates = m.v(), third(m.v().size());
  rates.insert(rates.end(), m.a().begin(), m.a().end());
  for (int j = 1; j <= m.n(); ++j) third[velocity(m, j)] = qddd(j);
  rates.insert(rates.end(), third.begin(), third.end());
  HigherOrderMotion<> motion(m.model(), 2);
  motion.evaluate(m.q(), rates);
  return motion;
}
template <class Rep> TwistRate<Rep> jerk(const Motion& m, int i) {
  return jerk_motion(m).twist_derivative<Rep>(i, 2);
}

/// ∂(C_f⁻¹ C_g) / ∂q_k.
inline Mat4 relative_pose_partial(const Motion& m, int f, int g, int k) {
  std::vector<Taylor<double, 2>> q(m.q().begin(), m.q().end());
  q[m.model().joint(k).iq].c[1] = 1;
  const auto C = poses_on(m, q);
  return to_eigen(inverse(C[f]) * C[g]).unaryExpr([](const Taylor<double, 2>& x) { return x.c[1]; });
}

// ----------------------------------------------------------------------------------------- all bodies, one on another

/// f(i) of all bodies, six rows each.
template <class F> Eigen::MatrixXd stacked(const Motion& m, const F& f) {
  Eigen::MatrixXd out(6 * m.n(), f(1).cols());
  for (int i = 1; i <= m.n(); ++i) out.middleRows(6 * (i - 1), 6) = f(i);
  return out;
}
template <class Rep> Eigen::MatrixXd system_jacobian(const Motion& m) {
  return stacked(m, [&](int i) {
    Mat6X J = Mat6X::Zero(6, m.model().nv());
    for (const int j : m.path(i)) J.middleCols(velocity(m, j), m.model().joint(j).nv) = m.J<Rep>(i, j);
    return J;
  });
}
template <class Rep> Eigen::VectorXd system_V(const Motion& m) {
  return stacked(m, [&](int i) { return m.V<Rep>(i); });
}
template <class Rep> Eigen::VectorXd system_dV(const Motion& m) {
  return stacked(m, [&](int i) { return m.dV<Rep>(i); });
}
inline Eigen::Map<const Eigen::VectorXd> as_vector(const std::vector<double>& x) {
  return {x.data(), static_cast<Eigen::Index>(x.size())};
}
/// diag(f(1), ..., f(n)).
template <class F> Eigen::MatrixXd block_diagonal_of(const Motion& m, const F& f) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(6 * m.n(), 6 * m.n());
  for (int i = 1; i <= m.n(); ++i) out.block<6, 6>(6 * (i - 1), 6 * (i - 1)) = f(i);
  return out;
}
/// check(eq, m) for every motion.
template <class Check> void each_system(const Check& check) {
  each_body([&](Equation& eq, const Motion& m, int i) {
    if (i == 1) check(eq, m);
  });
}
template <class Check> void each_system_with_one_screw_joints(const Check& check) {
  each_body_with_one_screw([&](Equation& eq, const Motion& m, int i) {
    if (i == 1) check(eq, m);
  });
}

}  // namespace axode::test::paper
