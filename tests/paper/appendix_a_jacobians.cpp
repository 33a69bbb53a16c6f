#include "tests/paper/columns.hpp"

/// Appendix A: Jacobians. If a joint has several screws, J_{i,j} has one column for each of them.
namespace axode::test::paper {
namespace {

template <class Rep> void expect_twist_by_columns(Equation& eq, const Motion& m, int i) {
  Vec6 sum;
  for (const int j : m.path(i)) sum += m.J<Rep>(i, j) * m.qd(j);
  const Matrix qd = as_vector(m.v());
  eq.holds(m.V<Rep>(i), sum);
  eq.holds(m.V<Rep>(i), jacobian_of<Rep>(m, i) * qd);
}

// V_i = Σ_{j<=i} J_{i,j} q̇_j = J_i q̇, body-fixed and spatial
TEST(Paper, VbJac) {
  each_body([](Equation& eq, const Motion& m, int i) {
    expect_twist_by_columns<BodyFixed>(eq, m, i);
    expect_twist_by_columns<Spatial>(eq, m, i);
    eq.holds(m.V<BodyFixed>(i), m.twist<BodyFixed>(i));
  });
}

// V_i = Σ_{j<=i} J_{i,j} q̇_j = J_i q̇, hybrid and mixed
TEST(Paper, VhVmJac) {
  each_body([](Equation& eq, const Motion& m, int i) {
    expect_twist_by_columns<Hybrid>(eq, m, i);
    expect_twist_by_columns<Mixed>(eq, m, i);
    eq.holds(m.V<Hybrid>(i), m.twist<Hybrid>(i));
  });
}

template <class Rep> Matrix library_columns(const Motion& m, int i, int j) {
  return jacobian_of<Rep>(m, i).middle_cols(velocity(m, j), m.model().joint(j).nv);
}

// J_{i,j}^b = Ad_{C_{i,j}} X_j = Ad_{C_{i,j} A_j⁻¹} Y_j
TEST(Paper, JbX) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    for (const int j : m.path(i)) {
      const SE3<> C_ij = inverse(m.pose(i)) * m.pose(j);
      eq.holds(m.J<BodyFixed>(i, j), Ad(C_ij) * m.X(j));
      eq.holds(library_columns<BodyFixed>(m, i, j), m.J<BodyFixed>(i, j));
      eq.holds(m.J<BodyFixed>(i, j), Ad(C_ij * inverse(m.body(j).A)) * to_matrix(m.drawn(j).Y));
    }
  });
}

// J_j^s = Ad_{C_j} X_j = Ad_{C_j A_j⁻¹} Y_j, the same for every body i >= j
TEST(Paper, JsX) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    for (const int j : m.path(i)) {
      eq.holds(m.J<Spatial>(i, j), Ad(m.pose(j)) * m.X(j));
      eq.holds(library_columns<Spatial>(m, i, j), m.J<Spatial>(i, j));
      eq.holds(m.J<Spatial>(i, j), Ad(m.pose(j) * inverse(m.body(j).A)) * to_matrix(m.drawn(j).Y));
    }
  });
}

// J_{i,j}^h = Ad_{r_{i,j}} ^0X_j^j for j <= i
TEST(Paper, Jh) {
  each_body([](Equation& eq, const Motion& m, int i) {
    for (const int j : m.path(i)) {
      const Matrix right = Ad(m.pose(j).r - m.pose(i).r) * Ad(m.pose(j).R) * m.X(j);
      eq.holds(m.J<Hybrid>(i, j), right);
      eq.holds(library_columns<Hybrid>(m, i, j), right);
    }
  });
}

// J_j^s = Ad_{r_i} J_{i,j}^h = Ad_{C_i} J_{i,j}^b, J_{i,j}^h = Ad_{R_i} J_{i,j}^b
TEST(Paper, JhJb) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const SE3<> C = m.pose(i);
    for (const int j : m.path(i)) {
      eq.holds(m.J<Spatial>(i, j), Ad(C.r) * library_columns<Hybrid>(m, i, j));
      eq.holds(m.J<Spatial>(i, j), Ad(C) * library_columns<BodyFixed>(m, i, j));
      eq.holds(m.J<Hybrid>(i, j), Ad(C.R) * library_columns<BodyFixed>(m, i, j));
    }
  });
}

// V = A X q̇ of all bodies, body-fixed
TEST(Paper, VbAX) {
  each_system([](Equation& eq, const Motion& m) {
    const MatricesOfSystem s = system_matrices<BodyFixed>(m.model(), m.q());
    eq.holds(system_V<BodyFixed>(m), s.A * s.X * as_vector(m.v()));
    eq.holds(system_V<BodyFixed>(m), system_twist<BodyFixed>(m.model(), m.q(), m.v()));
  });
}

/// A has the block f(i, j) for every j <= i and D that of the predecessor; (I - D) A = I.
template <class F>
void expect_blocks(Equation& eq, const Motion& m, const MatricesOfSystem& system, const F& f) {
  Matrix A(6 * m.n(), 6 * m.n()), D = A;
  for (int i = 1; i <= m.n(); ++i) {
    for (const int j : m.path(i)) A.set_block(6 * (i - 1), 6 * (j - 1), f(i, j));
    if (const int p = m.predecessor(i); p > 0) D.set_block(6 * (i - 1), 6 * (p - 1), f(i, p));
  }
  eq.holds(system.A, A);
  eq.holds(system.D, D);
  eq.holds((identity(A.rows()) - D) * A, identity(A.rows()));
}

// J^b = A^b X^b, J^s = A^s Y^s = A^sb X^b, J^h = A^h X^h of all bodies
TEST(Paper, JbSys) {
  each_system_with_one_screw_joints([](Equation& eq, const Motion& m) {
    const MatricesOfSystem body = system_matrices<BodyFixed>(m.model(), m.q()),
                           spatial = system_matrices<Spatial>(m.model(), m.q()),
                           hybrid = system_matrices<Hybrid>(m.model(), m.q()),
                           mixed = system_matrices<Mixed>(m.model(), m.q());
    const SpatialFactors factors = spatial_factors(m.model(), m.q());
    const Matrix A_s = factors.A_s, Y_s = factors.Y_s, A_sb = factors.A_sb;
    expect_blocks(eq, m, body, [&](int i, int j) { return Ad(m.C(i, j)); });
    expect_blocks(eq, m, spatial, [&](int, int) { return identity(6); });
    expect_blocks(eq, m, hybrid, [&](int i, int j) { return Ad(m.C(j).r - m.C(i).r); });
    eq.holds(system_jacobian<BodyFixed>(m), body.A * body.X);
    eq.holds(system_jacobian<Spatial>(m), spatial.A * spatial.X);
    eq.holds(system_jacobian<Spatial>(m), A_s * Y_s);
    eq.holds(system_jacobian<Spatial>(m), A_sb * body.X);
    eq.holds(system_jacobian<Hybrid>(m), hybrid.A * hybrid.X);
    eq.holds(system_jacobian<Mixed>(m), mixed.A * mixed.X);
    for (int i = 1; i <= m.n(); ++i) {
      eq.holds(Y_s.block(6 * (i - 1), velocity(m, i), 6, 1), to_matrix(m.drawn(i).Y));
      eq.holds(body.X.block(6 * (i - 1), velocity(m, i), 6, 1), m.X(i));
    }
  });
}

}  // namespace
}  // namespace axode::test::paper
