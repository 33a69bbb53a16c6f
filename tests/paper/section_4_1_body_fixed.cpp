#include "tests/paper/columns.hpp"

/// Section 4.1: recursive Newton-Euler algorithm, body-fixed representation. "i - 1" is the predecessor p of
/// body i; with more than one screw to a joint, X_i q̇_i is the sum of its screws times their rates.
namespace axode::test::paper {
namespace {

// (Ad_{C_{i,i-1}})˙ V_{i-1} = [Ad_{C_{i,i-1}} V_{i-1}, X_i q̇_i], body-fixed
TEST(Paper, RelativeAdRate) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    const Vec6 V_p = to_matrix(m.twist<BodyFixed>(p));
    eq.holds(rate(Ad(m.C_of_t(i, p))) * V_p, ad(Ad(m.C(i, p)) * V_p) * m.Xqd(i));
    eq.holds(rate(Ad(m.C_of_t(i, p))) * V_p, m.bias<BodyFixed>(i), m.V<BodyFixed>(i).squared_norm());
  });
}

// V̇_i = Ad_{C_{i,i-1}} V̇_{i-1} + [Ad_{C_{i,i-1}} V_{i-1}, X_i q̇_i] + X_i q̈_i, body-fixed
TEST(Paper, ArecVbi) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    const Mat6 Ad_ip = Ad(m.C(i, p));
    const Vec6 right = Ad_ip * m.dV<BodyFixed>(p) + ad(Ad_ip * m.V<BodyFixed>(p)) * m.Xqd(i) + m.Xqdd(i);
    eq.holds(m.dV<BodyFixed>(i), right);
    eq.holds(m.twist_rate<BodyFixed>(i), right);
  });
}

// V̇_i = Ad_{C_{i,i-1}} V̇_{i-1} + [Ad_{C_{i,i-1}} V_{i-1}, V_i] + X_i q̈_i, body-fixed
TEST(Paper, BrecVbi) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    const Mat6 Ad_ip = Ad(m.C(i, p));
    const Vec6 bracket = ad(Ad_ip * m.V<BodyFixed>(p)) * m.V<BodyFixed>(i);
    eq.holds(m.dV<BodyFixed>(i), Ad_ip * m.dV<BodyFixed>(p) + bracket + m.Xqdd(i));
    eq.holds(m.twist_rate<BodyFixed>(i), Ad_ip * m.dV<BodyFixed>(p) + bracket + m.Xqdd(i));
  });
}

// V̇_i = Ad_{C_{i,i-1}} V̇_{i-1} + [V_i, X_i q̇_i] + X_i q̈_i, body-fixed
TEST(Paper, CrecVbi) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    const Vec6 others = Ad(m.C(i, p)) * m.dV<BodyFixed>(p) + m.Xqdd(i);
    eq.holds(m.dV<BodyFixed>(i), others + ad(m.V<BodyFixed>(i)) * m.Xqd(i));
    eq.holds(m.dV<BodyFixed>(i), others + m.bias<BodyFixed>(i));
  });
}

// q̈_i = X_iᵀ (V̇_i - Ad_{C_{i,i-1}} V̇_{i-1} + [V_i, Ad_{C_{i,i-1}} V_{i-1}]) / ‖X_i‖², body-fixed. Printed:
// V_i instead of V̇_i.
TEST(Paper, RemAfterCrecVbi) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    const Mat6 Ad_ip = Ad(m.C(i, p));
    const Vec6 X = m.X(i), V_i = to_matrix(m.twist<BodyFixed>(i)), V_p = to_matrix(m.twist<BodyFixed>(p));
    const Vec6 dV_i = to_matrix(m.twist_rate<BodyFixed>(i)), dV_p = to_matrix(m.twist_rate<BodyFixed>(p));
    const auto side = [&](const Vec6& first) {
      return X.dot(first - Ad_ip * dV_p + ad(V_i) * Ad_ip * V_p) / X.squared_norm();
    };
    eq.holds(m.qdd(i), side(dV_i));
    eq.holds(m.qdd(i), joint_accelerations_of(m)[velocity(m, i)]);
    eq.fails(m.qdd(i), side(V_i));
  });
}

// C_i = C_{i-1} B_i exp(X_i q_i) = exp(Y_1 q_1) ... exp(Y_i q_i) A_i
TEST(Paper, AVbRec2) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    eq.holds(m.pose(i), m.C(m.predecessor(i)) * m.body(i).B * exp(m.q(i) * m.X_screw(i)));
    eq.holds(m.pose(i), m.product_of_Y(i) * m.body(i).A);
  });
}

// V_i = Ad_{C_{i,i-1}} V_{i-1} + X_i q̇_i, body-fixed
TEST(Paper, BVbRec2) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    eq.holds(m.twist<BodyFixed>(i), Ad(m.C(i, p)) * m.V<BodyFixed>(p) + m.Xqd(i));
  });
}

// V̇_i = Ad_{C_{i,i-1}} V̇_{i-1} - q̇_i ad_{X_i} V_i + X_i q̈_i, body-fixed
TEST(Paper, CVbRec2) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    const Vec6 bracket = ad(m.Xqd(i)) * m.V<BodyFixed>(i);
    eq.holds(m.twist_rate<BodyFixed>(i), Ad(m.C(i, p)) * m.dV<BodyFixed>(p) - bracket + m.Xqdd(i));
  });
}

// For i = n..1: W_i = Σ_{children k} Ad_{C_{k,i}}ᵀ W_k + M_i V̇_i - ad_{V_i}ᵀ M_i V_i - W_i^app, body-fixed.
// Printed: from i = n - 1, with body i + 1 as the only successor and with + W_i^app.
TEST(Paper, AWbRec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const auto Ad_T_W = [&](int k) -> Vec6 {
      return Ad(m.C(k, i)).transpose() * to_matrix(m.joint_wrench<BodyFixed>(k));
    };
    const Mat6 M = to_matrix(m.M(i));
    const Vec6 V = m.V<BodyFixed>(i), own = M * m.dV<BodyFixed>(i) - ad(V).transpose() * M * V;
    Vec6 right = own - m.W_app<BodyFixed>(i);
    for (const int k : m.children(i)) right += Ad_T_W(k);
    eq.holds(m.joint_wrench<BodyFixed>(i), right);
    eq.holds(m.transmitted<BodyFixed>(i), right);
    if (i < m.n()) eq.fails(m.transmitted<BodyFixed>(i), Ad_T_W(i + 1) + own + m.W_app<BodyFixed>(i));
  });
}

// Q_i = X_iᵀ W_i, body-fixed
TEST(Paper, BWbRec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Matrix X = m.X(i);
    const Vec6 W = to_matrix(m.joint_wrench<BodyFixed>(i));
    const double size = X.norm() * W.norm();
    eq.holds(m.joint_force<BodyFixed>(i), X.transpose() * W, size);
    eq.holds(m.joint_force<BodyFixed>(i), X.transpose() * m.transmitted<BodyFixed>(i), size);
  });
}

}  // namespace
}  // namespace axode::test::paper
