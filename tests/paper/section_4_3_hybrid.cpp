#include "tests/paper/equation.hpp"

/// Section 4.3: recursive Newton-Euler algorithm, hybrid representation. "i - 1" is the predecessor p of body
/// i, r_{i,i-1} = r_{i-1} - r_i, and X below is ^0X_i^i = Ad_{R_i} X_i; with more than one screw to a joint,
/// X q̇_i is the sum of its screws times their rates.
namespace axode::test::paper {
namespace {

/// The terms of the recursions for body i, evaluated from the definitions.
struct Step {
  Vec6 V_i, V_p, dV_i, dV_p, Xqd, Xqdd;
  Mat6 Ad_ip, ad_dr_ip;  ///< Ad_{r_{i,i-1}}, ad_{ṙ_{i,i-1}}
  Mat6 ad_dr_i, ad_dr_p, ad_w_i;

  Step(const Motion& m, int i) {
    const int p = m.predecessor(i);
    V_i = m.V<Hybrid>(i), V_p = m.V<Hybrid>(p), dV_i = m.dV<Hybrid>(i), dV_p = m.dV<Hybrid>(p);
    const Matrix X = m.J<Hybrid>(i, i);
    Xqd = X * m.qd(i), Xqdd = X * m.qdd(i);
    Ad_ip = Ad(now(m.r_of_t(i, p))), ad_dr_ip = ad_v(to_matrix(rate(m.r_of_t(i, p))));
    ad_dr_i = ad_v(linear(V_i)), ad_dr_p = ad_v(linear(V_p)), ad_w_i = ad_w(angular(V_i));
  }
};

// (Ad_{r_{i,i-1}})˙ = ad_{ṙ_{i,i-1}} = ad_{ṙ_{i-1}} - ad_{ṙ_i}
TEST(Paper, TranslationAdRate) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    const Mat6 left = rate(Ad(m.r_of_t(i, p)));
    const Step s(m, i);
    eq.holds(left, s.ad_dr_ip);
    eq.holds(left * s.V_p + s.ad_w_i * s.Xqd, m.bias<Hybrid>(i), s.V_i.squared_norm());
    const Vec3d dr_i = to_matrix(m.twist<Hybrid>(i).v), dr_p = to_matrix(m.twist<Hybrid>(p).v);
    eq.holds(left, ad_v(dr_p) - ad_v(dr_i));
  });
}

// V̇_i = Ad_{r_{i,i-1}} V̇_{i-1} + X q̈_i + ad_{ṙ_{i,i-1}} V_{i-1} + ad_{ω_i} X q̇_i, hybrid
TEST(Paper, RecVhdot1) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Step s(m, i);
    const Vec6 bias = s.ad_dr_ip * s.V_p + s.ad_w_i * s.Xqd;
    eq.holds(s.dV_i, s.Ad_ip * s.dV_p + s.Xqdd + bias);
    eq.holds(s.dV_i, s.Ad_ip * s.dV_p + s.Xqdd + m.bias<Hybrid>(i));
  });
}

// V̇_i = Ad_{r_{i,i-1}} V̇_{i-1} + X q̈_i + ad_{ṙ_{i-1}} V_{i-1} - ad_{ṙ_i} V_i + ad_{V_i} X q̇_i, hybrid
TEST(Paper, RecVhdot2) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Step s(m, i);
    const Vec6 bias = s.ad_dr_p * s.V_p - s.ad_dr_i * s.V_i + ad(s.V_i) * s.Xqd;
    eq.holds(m.twist_rate<Hybrid>(i), s.Ad_ip * s.dV_p + s.Xqdd + bias);
  });
}

// V̇_i = Ad_{r_{i,i-1}} V̇_{i-1} + X q̈_i + ad_{ṙ_{i,i-1}} V_i + (ad_{V_i} - ad_{ṙ_{i-1}}) X q̇_i, hybrid
TEST(Paper, RecVhdot3) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Step s(m, i);
    const Vec6 bias = s.ad_dr_ip * s.V_i + (ad(s.V_i) - s.ad_dr_p) * s.Xqd;
    eq.holds(m.twist_rate<Hybrid>(i), s.Ad_ip * s.dV_p + s.Xqdd + bias);
  });
}

// ad_{ṙ_i} (V_i - X q̇_i) = ad_{ṙ_i} V_{i-1}, ad_{ṙ_i} + ad_{ω_i} = ad_{V_i}, V_{i-1} = Ad_{r_{i,i-1}}⁻¹ (V_i
// - X q̇_i), ad_{ṙ_{i,i-1}} Ad_{r_{i,i-1}}⁻¹ = ad_{ṙ_{i,i-1}}, hybrid
TEST(Paper, RecVhdotHelperIdentities) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Step s(m, i);
    const Vec6 V_i = to_matrix(m.twist<Hybrid>(i)), V_p = to_matrix(m.twist<Hybrid>(m.predecessor(i)));
    eq.holds(s.ad_dr_i * (V_i - s.Xqd), s.ad_dr_i * V_p, V_i.squared_norm());
    eq.holds(s.ad_dr_i + s.ad_w_i, ad(V_i));
    eq.holds(V_i, s.Ad_ip * V_p + s.Xqd);
    eq.holds(s.ad_dr_ip * s.Ad_ip.inverse(), s.ad_dr_ip);
  });
}

// C_i = C_{i-1} B_i exp(X_i q_i) = exp(Y_1 q_1) ... exp(Y_i q_i) A_i; the hybrid recursion carries R_i and
// r_i - r_{i-1}
TEST(Paper, AVhRec2) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const SE3<> C_p = m.pose(m.predecessor(i));
    const SE3<> C = {m.link<Hybrid>(i).R, C_p.r + m.link<Hybrid>(i).r_pi};
    eq.holds(C, C_p * m.body(i).B * exp(m.q(i) * m.X_screw(i)));
    eq.holds(C, m.product_of_Y(i) * m.body(i).A);
  });
}

// ^0X_i^i = Ad_{R_i} X_i = Ad_{-r_i} J_i^s = Ad_{R_i} Ad_{S_{i,i}} Z_i. Printed: Ad_{-r_i} Y_i in the middle.
TEST(Paper, BVhRec2) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Vec6 X = m.J<Hybrid>(i, i), Y = to_matrix(m.drawn(i).Y);
    const SE3<> C = m.pose(i);
    eq.holds(X, Ad(C.R) * m.X(i));
    eq.holds(X, Ad(-C.r) * m.J<Spatial>(i, i));
    eq.holds(X, Ad(-C.r) * Ad(C * inverse(m.body(i).A)) * Y);
    eq.holds(X, Ad(C.R) * Ad(m.joint_frames(i).S_self) * to_matrix(m.joint_frames(i).Z));
    eq.holds(m.push_Xqd<Hybrid>(i), X * m.qd(i));
    eq.fails(X, Ad(-C.r) * Y);
  });
}

// V_i = Ad_{r_{i,i-1}} V_{i-1} + X q̇_i, hybrid
TEST(Paper, CVhRec2) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Step s(m, i);
    eq.holds(m.twist<Hybrid>(i), s.Ad_ip * s.V_p + s.Xqd);
  });
}

// V̇_i = Ad_{r_{i,i-1}} V̇_{i-1} + ad_{ṙ_{i,i-1}} V_{i-1} + ad_{ω_i} X q̇_i + X q̈_i, hybrid
TEST(Paper, DVhRec2) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Step s(m, i);
    eq.holds(m.twist_rate<Hybrid>(i), s.Ad_ip * s.dV_p + s.ad_dr_ip * s.V_p + s.ad_w_i * s.Xqd + s.Xqdd);
  });
}

// M_i^h = Ad_{R_i}⁻ᵀ M_i^b Ad_{R_i}⁻¹
TEST(Paper, AWhRec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 Ad_inv = Ad(m.pose(i).R).inverse(), right = Ad_inv.transpose() * to_matrix(m.M(i)) * Ad_inv;
    eq.holds(transform(m.link<Hybrid>(i).R, m.M(i)), right);
    eq.holds(m.M(i, m.frame<Hybrid>(i)), right);
  });
}

// For i = n..1: W_i = Σ_{children k} Ad_{r_{k,i}}ᵀ W_k + M_i V̇_i + ad_{ω_i} M_i (ω_i; 0) - W_i^app, hybrid.
// Printed: from i = n - 1, with body i + 1 as the only successor and with + W_i^app.
TEST(Paper, BWhRec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const auto Ad_T_W = [&](int k) -> Vec6 {
      return Ad(now(m.r_of_t(k, i))).transpose() * to_matrix(m.joint_wrench<Hybrid>(k));
    };
    const Mat6 M = m.M(i, m.frame<Hybrid>(i));
    const Vec6 V = m.V<Hybrid>(i), own = M * m.dV<Hybrid>(i) + ad_w(angular(V)) * M * angular_screw(V);
    Vec6 right = own - m.W_app<Hybrid>(i);
    for (const int k : m.children(i)) right += Ad_T_W(k);
    eq.holds(m.joint_wrench<Hybrid>(i), right);
    eq.holds(m.transmitted<Hybrid>(i), right);
    if (i < m.n()) eq.fails(m.transmitted<Hybrid>(i), Ad_T_W(i + 1) + own + m.W_app<Hybrid>(i));
  });
}

// Q_i = Xᵀ W_i, hybrid
TEST(Paper, CWhRec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Matrix X = m.J<Hybrid>(i, i);
    const Vec6 W = to_matrix(m.joint_wrench<Hybrid>(i));
    const double size = X.norm() * W.norm();
    eq.holds(m.joint_force<Hybrid>(i), X.transpose() * W, size);
    eq.holds(m.joint_force<Hybrid>(i), X.transpose() * m.transmitted<Hybrid>(i), size);
  });
}

}  // namespace
}  // namespace axode::test::paper
