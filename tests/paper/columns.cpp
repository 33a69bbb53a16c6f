#include "tests/paper/columns.hpp"

#include "tests/support/any_scalar.hpp"

namespace axode::test::paper {

template <class T> std::vector<SE3<T>> poses_on(const Motion& m, const std::vector<T>& q) {
  return frame_poses(axode::cast<T>(m.model().tree<double>()), q);
}
template std::vector<SE3<Two>> poses_on(const Motion&, const std::vector<Two>&);
template std::vector<SE3<Three>> poses_on(const Motion&, const std::vector<Three>&);
template std::vector<SE3<Taylor<Three, 2>>> poses_on(const Motion&, const std::vector<Taylor<Three, 2>>&);

namespace {

/// The angular and the linear part of a column of a Jacobian.
template <class T> struct Column { Vec3<T> a, b; };
/// J_{i,j}(q) in any scalar type: from C_i and its derivative with respect to q_j, by the definitions of
/// appendix A.
template <class T>
Column<T> column_of(Representation representation, const Motion& m, int i, int j, const std::vector<T>& q) {
  using Along = Taylor<T, 2>;
  std::vector<Along> q_moved(q.begin(), q.end());
  q_moved[m.model().joint(j).iq].c[1] = T(1);
  const SE3<Along> C = poses_on(m, q_moved)[i];
  const auto part = [](const Vec3<Along>& x, int k) { return Vec3<T>{x.x.c[k], x.y.c[k], x.z.c[k]}; };
  const SO3<T> R{part(C.R.x, 0), part(C.R.y, 0), part(C.R.z, 0)};
  const Vec3<T> dx = part(C.R.x, 1), dy = part(C.R.y, 1), dz = part(C.R.z, 1);
  const Vec3<T> w_b{dot(R.z, dy), dot(R.x, dz), dot(R.y, dx)}, w_s = R * w_b, dr = part(C.r, 1),
                                                               r = part(C.r, 0);
  switch (representation) {
    case Representation::body: return {w_b, transpose(R) * dr};
    case Representation::spatial: return {w_s, dr + cross(r, w_s)};
    case Representation::hybrid: return {w_s, dr};
    case Representation::mixed: break;
  }
  return {w_b, dr};
}

double innermost(double x) { return x; }
template <class T> double innermost(const Taylor<T, 2>& x) { return innermost(x.c[1]); }
void move(double&, const int*, int) {}
template <class T> void move(Taylor<T, 2>& x, const int* alpha, int c) {
  move(x.c[0], alpha + 1, c);
  if (*alpha == c) x.c[1] = T(1);
}

/// The partial derivatives by T, a series in one ε for each joint α.
template <class T>
Vec6 partial_on(Representation representation, const Motion& m, int i, int j, const std::vector<int>& alpha) {
  std::vector<T> q(m.q().begin(), m.q().end());
  for (int k = 1; k <= m.n(); ++k) move(q[m.model().joint(k).iq], alpha.data(), k);
  const auto [a, b] = column_of(representation, m, i, j, q);
  const auto of = [](const Vec3<T>& x) { return Vec3<>{innermost(x.x), innermost(x.y), innermost(x.z)}; };
  return Screw<>{of(a), of(b)};
}

template <class Columns> Matrix matrix_of(const Columns& columns) {
  Matrix J(6, static_cast<int>(columns.size()));
  for (int c = 0; c < J.cols(); ++c) J.set_block(0, c, columns[static_cast<std::size_t>(c)]);
  return J;
}

/// J_{i,j} along the motion, as a series in t up to the second order.
Vec6OfT column_of_t(Representation representation, const Motion& m, int i, int j) {
  std::vector<Series> q(m.q().begin(), m.q().end());
  for (int k = 1; k <= m.n(); ++k) {
    Series& q_k = q[m.model().joint(k).iq];
    q_k.c[1] = m.qd(k)[0], q_k.c[2] = m.qdd(k)[0] / 2;
  }
  const auto [a, b] = column_of(representation, m, i, j, q);
  return Screw<Series>{a, b};
}

}  // namespace

template <class Rep> Vec6 partial_of(const Motion& m, int i, int j, const std::vector<int>& alpha) {
  switch (alpha.size()) {
    case 1: return partial_on<One>(value_of<Rep>, m, i, j, alpha);
    case 2: return partial_on<Two>(value_of<Rep>, m, i, j, alpha);
    case 3: return partial_on<Three>(value_of<Rep>, m, i, j, alpha);
    default: throw std::logic_error("partials are of order 1, 2 or 3");
  }
}

template <class Rep> Matrix jacobian_of(const Motion& m, int i) {
  std::vector<Twist<Rep>> J(m.v().size());
  Workspace<double> workspace(m.model());
  jacobian<Rep>(m.model(), workspace, m.q(), i, J);
  return matrix_of(J);
}
template <class Rep> Matrix partials_of(const Motion& m, int i, int order) {
  std::size_t size = m.v().size();
  for (int k = 0; k < order; ++k) size *= m.v().size();
  std::vector<Twist<Rep>> J(size);
  Workspace<double> workspace(m.model());
  jacobian_partials<Rep>(m.model(), workspace, m.q(), i, order, J);
  return matrix_of(J);
}
template <class Rep> Matrix jacobian_rate(const Motion& m, int i) {
  std::vector<Twist<Rep>> J(m.v().size());
  Workspace<double> workspace(m.model());
  jacobian_derivative_along<Rep>(m.model(), workspace, m.q(), i, 1, m.v(), J);
  return matrix_of(J);
}
template <class Rep> Vec6 library_partial(const Motion& m, int i, int j, int k) {
  return partials_of<Rep>(m, i, 1).col(velocity(m, k) * m.model().nv() + velocity(m, j));
}
template <class Rep> Vec6 library_dJ(const Motion& m, int i, int j) {
  return jacobian_rate<Rep>(m, i).col(velocity(m, j));
}

template <class Rep> Vec6 dJ(const Motion& m, int i, int j) {
  return rate(column_of_t(value_of<Rep>, m, i, j));
}
template <class Rep> Vec6 ddJ(const Motion& m, int i, int j) {
  return rate(derivative(column_of_t(value_of<Rep>, m, i, j)));
}
template <class Rep> Vec6 ddV(const Motion& m, int i) {
  Vec6OfT V;
  for (const int j : m.path(i)) {
    Series qd;
    qd.c = {m.qd(j)[0], m.qdd(j)[0], qddd(j) / 2};
    V += column_of_t(value_of<Rep>, m, i, j) * qd;
  }
  return rate(derivative(V));
}
HigherOrderMotion<> jerk_motion(const Motion& m) {
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

Mat4 relative_pose_partial(const Motion& m, int f, int g, int k) {
  std::vector<Series> q(m.q().begin(), m.q().end());
  q[m.model().joint(k).iq].c[1] = 1;
  const auto C = poses_by_spatial_screws(m.model(), q.data());
  return rate(to_matrix(inverse(C[f]) * C[g]));
}

Matrix stacked(const Motion& m, const std::function<Matrix(int i)>& f) {
  Matrix out(6 * m.n(), f(1).cols());
  for (int i = 1; i <= m.n(); ++i) out.set_block(6 * (i - 1), 0, f(i));
  return out;
}
template <class Rep> Matrix system_jacobian(const Motion& m) {
  return stacked(m, [&](int i) {
    Matrix J(6, m.model().nv());
    for (const int j : m.path(i)) J.set_block(0, velocity(m, j), m.J<Rep>(i, j));
    return J;
  });
}
template <class Rep> Matrix system_V(const Motion& m) {
  return stacked(m, [&](int i) { return m.V<Rep>(i); });
}
template <class Rep> Matrix system_dV(const Motion& m) {
  return stacked(m, [&](int i) { return m.dV<Rep>(i); });
}
Matrix block_diagonal_of(const Motion& m, const std::function<Mat6(int i)>& f) {
  Matrix out(6 * m.n(), 6 * m.n());
  for (int i = 1; i <= m.n(); ++i) out.set_block(6 * (i - 1), 6 * (i - 1), f(i));
  return out;
}
void each_system(const CheckOfMotion& check) {
  each_body([&](Equation& eq, const Motion& m, int i) {
    if (i == 1) check(eq, m);
  });
}
void each_system_with_one_screw_joints(const CheckOfMotion& check) {
  each_body_with_one_screw([&](Equation& eq, const Motion& m, int i) {
    if (i == 1) check(eq, m);
  });
}

Matrix joint_accelerations_of(const Motion& m) {
  return joint_accelerations<BodyFixed>(m.model(), m.q(), to_eigen_vector(system_V<BodyFixed>(m)),
                                        to_eigen_vector(system_dV<BodyFixed>(m)));
}

template Vec6 partial_of<BodyFixed>(const Motion&, int, int, const std::vector<int>&);
template Matrix jacobian_of<BodyFixed>(const Motion&, int);
template Matrix partials_of<BodyFixed>(const Motion&, int, int);
template Vec6 library_partial<BodyFixed>(const Motion&, int, int, int);
template Matrix jacobian_rate<BodyFixed>(const Motion&, int);
template Vec6 library_dJ<BodyFixed>(const Motion&, int, int);
template Vec6 dJ<BodyFixed>(const Motion&, int, int);
template Vec6 ddJ<BodyFixed>(const Motion&, int, int);
template Vec6 ddV<BodyFixed>(const Motion&, int);
template Matrix system_jacobian<BodyFixed>(const Motion&);
template Matrix system_V<BodyFixed>(const Motion&);
template Matrix system_dV<BodyFixed>(const Motion&);
template TwistRate<BodyFixed> jerk<BodyFixed>(const Motion&, int);
template Vec6 partial_of<Spatial>(const Motion&, int, int, const std::vector<int>&);
template Matrix jacobian_of<Spatial>(const Motion&, int);
template Matrix partials_of<Spatial>(const Motion&, int, int);
template Vec6 library_partial<Spatial>(const Motion&, int, int, int);
template Matrix jacobian_rate<Spatial>(const Motion&, int);
template Vec6 library_dJ<Spatial>(const Motion&, int, int);
template Vec6 dJ<Spatial>(const Motion&, int, int);
template Vec6 ddJ<Spatial>(const Motion&, int, int);
template Vec6 ddV<Spatial>(const Motion&, int);
template Matrix system_jacobian<Spatial>(const Motion&);
template Matrix system_V<Spatial>(const Motion&);
template Matrix system_dV<Spatial>(const Motion&);
template TwistRate<Spatial> jerk<Spatial>(const Motion&, int);
template Vec6 partial_of<Hybrid>(const Motion&, int, int, const std::vector<int>&);
template Matrix jacobian_of<Hybrid>(const Motion&, int);
template Matrix partials_of<Hybrid>(const Motion&, int, int);
template Vec6 library_partial<Hybrid>(const Motion&, int, int, int);
template Matrix jacobian_rate<Hybrid>(const Motion&, int);
template Vec6 library_dJ<Hybrid>(const Motion&, int, int);
template Vec6 dJ<Hybrid>(const Motion&, int, int);
template Vec6 ddJ<Hybrid>(const Motion&, int, int);
template Vec6 ddV<Hybrid>(const Motion&, int);
template Matrix system_jacobian<Hybrid>(const Motion&);
template Matrix system_V<Hybrid>(const Motion&);
template Matrix system_dV<Hybrid>(const Motion&);
template TwistRate<Hybrid> jerk<Hybrid>(const Motion&, int);
template Vec6 partial_of<Mixed>(const Motion&, int, int, const std::vector<int>&);
template Matrix jacobian_of<Mixed>(const Motion&, int);
template Matrix partials_of<Mixed>(const Motion&, int, int);
template Vec6 library_partial<Mixed>(const Motion&, int, int, int);
template Matrix jacobian_rate<Mixed>(const Motion&, int);
template Vec6 library_dJ<Mixed>(const Motion&, int, int);
template Vec6 dJ<Mixed>(const Motion&, int, int);
template Vec6 ddJ<Mixed>(const Motion&, int, int);
template Vec6 ddV<Mixed>(const Motion&, int);
template Matrix system_jacobian<Mixed>(const Motion&);
template Matrix system_V<Mixed>(const Motion&);
template Matrix system_dV<Mixed>(const Motion&);
template TwistRate<Mixed> jerk<Mixed>(const Motion&, int);

}  // namespace axode::test::paper
