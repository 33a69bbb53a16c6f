#include "tests/paper/equation.hpp"

/// Section 4.2: recursive Newton-Euler algorithm, spatial representation. "i - 1" is the predecessor p of
/// body i; with more than one screw to a joint, J_i q̇_i is the sum of its screws times their rates.
namespace axode::test::paper {
namespace {

Vec6 Jqd(const Motion& m, int i) { return m.J<Spatial>(i, i) * m.qd(i); }
Vec6 Jqdd(const Motion& m, int i) { return m.J<Spatial>(i, i) * m.qdd(i); }

// V_i = V_{i-1} + J_i q̇_i, spatial
TEST(Paper, Vsirec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    eq.holds(m.V<Spatial>(i), m.V<Spatial>(m.predecessor(i)) + Jqd(m, i));
    eq.holds(m.twist<Spatial>(i), m.V<Spatial>(m.predecessor(i)) + Jqd(m, i));
  });
}

// V̇_i = V̇_{i-1} + ad_{V_i} J_i q̇_i + J_i q̈_i = V̇_{i-1} + ad_{V_{i-1}} V_i + J_i q̈_i, spatial
TEST(Paper, Visdotrec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    const Vec6 V_i = m.V<Spatial>(i), V_p = m.V<Spatial>(p), dV_p = m.dV<Spatial>(p);
    eq.holds(m.dV<Spatial>(i), dV_p + ad(V_i) * Jqd(m, i) + Jqdd(m, i));
    eq.holds(m.dV<Spatial>(i), dV_p + ad(V_p) * V_i + Jqdd(m, i));
    eq.holds(m.dV<Spatial>(i), dV_p + m.bias<Spatial>(i) + Jqdd(m, i));
  });
}

// C_i = C_{i-1} B_i exp(X_i q_i) = exp(Y_1 q_1) ... exp(Y_i q_i) A_i; the spatial recursion carries C_i
TEST(Paper, AVsRec) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    eq.holds(m.link<Spatial>(i).C, m.pose(m.predecessor(i)) * m.body(i).B * exp(m.q(i) * m.X_screw(i)));
    eq.holds(m.link<Spatial>(i).C, m.product_of_Y(i) * m.body(i).A);
  });
}

// J_i = Ad_{C_i} X_i = Ad_{C_i A_i⁻¹} Y_i = Ad_{C_i S_{i,i}} Z_i, spatial
TEST(Paper, BVsRec) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Vec6 J = m.J<Spatial>(i, i);
    eq.holds(J, Ad(m.pose(i)) * m.X(i));
    eq.holds(J, Ad(m.pose(i) * inverse(m.body(i).A)) * to_matrix(m.drawn(i).Y));
    eq.holds(J, Ad(m.pose(i) * m.joint_frames(i).S_self) * to_matrix(m.joint_frames(i).Z));
    eq.holds(J, m.joint_screw(i));
    eq.holds(m.push_Xqd<Spatial>(i), J * m.qd(i));
  });
}

// V_i = V_{i-1} + J_i q̇_i, spatial, as a step of the recursion
TEST(Paper, CVsRec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    const Vec6 right = m.V<Spatial>(p) + Jqd(m, i);
    eq.holds(m.link<Spatial>(i).down(m.twist<Spatial>(p)) + m.push_Xqd<Spatial>(i), right);
    eq.holds(m.twist<Spatial>(i), right);
  });
}

// V̇_i = V̇_{i-1} + J_i q̈_i + ad_{V_{i-1}} V_i, spatial
TEST(Paper, DVsRec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    const Vec6 right = m.dV<Spatial>(p) + Jqdd(m, i) + ad(m.V<Spatial>(p)) * m.V<Spatial>(i);
    eq.holds(m.twist_rate<Spatial>(i), right);
  });
}

// M_i^s = Ad_{C_i}⁻ᵀ M_i^b Ad_{C_i}⁻¹
TEST(Paper, AWsRec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 Ad_inv = Ad(m.pose(i)).inverse(), right = Ad_inv.transpose() * to_matrix(m.M(i)) * Ad_inv;
    eq.holds(transform(m.link<Spatial>(i).C, m.M(i)), right);
    eq.holds(m.M(i, m.frame<Spatial>(i)), right);
  });
}

// For i = n..1: W_i = Σ_{children k} W_k + M_i V̇_i - ad_{V_i}ᵀ M_i V_i - W_i^app, spatial. Printed: from i =
// n - 1, with body i + 1 as the only successor and with + W_i^app.
TEST(Paper, BWsRec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const auto W = [&](int k) -> Vec6 { return to_matrix(m.joint_wrench<Spatial>(k)); };
    const Mat6 M = m.M(i, m.frame<Spatial>(i));
    const Vec6 V = m.V<Spatial>(i), own = M * m.dV<Spatial>(i) - ad(V).transpose() * M * V;
    Vec6 right = own - m.W_app<Spatial>(i);
    for (const int k : m.children(i)) right += W(k);
    eq.holds(m.joint_wrench<Spatial>(i), right);
    eq.holds(m.transmitted<Spatial>(i), right);
    if (i < m.n()) eq.fails(m.transmitted<Spatial>(i), W(i + 1) + own + m.W_app<Spatial>(i));
  });
}

// Q_i = J_iᵀ W_i, spatial
TEST(Paper, CWsRec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Matrix J = m.J<Spatial>(i, i);
    const Vec6 W = to_matrix(m.joint_wrench<Spatial>(i));
    const double size = J.norm() * W.norm();
    eq.holds(m.joint_force<Spatial>(i), J.transpose() * W, size);
    eq.holds(m.joint_force<Spatial>(i), J.transpose() * m.transmitted<Spatial>(i), size);
  });
}

}  // namespace
}  // namespace axode::test::paper
