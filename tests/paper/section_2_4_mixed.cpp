#include "tests/paper/columns.hpp"

/// Section 2.4: accelerations and jerk, mixed representation, from the hybrid one.
namespace axode::test::paper {
namespace {

/// diag(R_iᵀ, I).
Mat6 angular_to_body(const Motion& m, int i) {
  return block_diagonal(to_matrix(m.C(i).R).transpose(), identity(3));
}

// J̇_{i,j}^m = diag(R_iᵀ, I) (J̇_{i,j}^h - ad_{ω_i} ωJ_{i,j}^h)
TEST(Paper, Jmdot) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Mat6 ad_omega = ad_w(angular(m.V<Spatial>(i)));
    for (const int j : m.path(i)) {
      const Vec6 left = dJ<Mixed>(m, i, j), dJ_h = dJ<Hybrid>(m, i, j), J_h = m.J<Hybrid>(i, j);
      eq.holds(left, angular_to_body(m, i) * (dJ_h - ad_omega * angular_screw(J_h)), J_h.norm());
      eq.holds(left, library_dJ<Mixed>(m, i, j), J_h.norm());
      eq.fails(left, angular_to_body(m, i) * dJ_h);
    }
  });
}

// V̇_i^m = diag(R_iᵀ, I) V̇_i^h
TEST(Paper, Vmdot) {
  each_body([](Equation& eq, const Motion& m, int i) {
    eq.holds(m.dV<Mixed>(i), angular_to_body(m, i) * m.dV<Hybrid>(i));
    eq.holds(m.twist_rate<Mixed>(i), angular_to_body(m, i) * to_matrix(m.twist_rate<Hybrid>(i)));
  });
}

// V̈_i^m = diag(R_iᵀ, I) (V̈_i^h - (ω_i × ω̇_i; 0))
TEST(Paper, Vmddot) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Vec6 turned = stack(angular(m.V<Spatial>(i)).cross(angular(m.dV<Spatial>(i))), Vec3d());
    eq.holds(ddV<Mixed>(m, i), angular_to_body(m, i) * (ddV<Hybrid>(m, i) - turned));
    eq.holds(jerk<Mixed>(m, i), ddV<Mixed>(m, i));
    eq.fails(ddV<Mixed>(m, i), angular_to_body(m, i) * ddV<Hybrid>(m, i));
  });
}

}  // namespace
}  // namespace axode::test::paper
