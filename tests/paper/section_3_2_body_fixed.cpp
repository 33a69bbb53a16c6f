#include "tests/paper/equation.hpp"

/// Section 3.2: Newton-Euler equations, body-fixed representation. Left sides come from point masses.
namespace axode::test::paper {
namespace {

// M_c^b = diag(Θ_c, m I), with ω̃_c^b = R_cᵀ Ṙ_c and v_c^b = R_cᵀ ṙ_c
TEST(Paper, Mbc) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int c = m.com(i);
    const Mat3 Theta_c = to_matrix(rotate(transpose(m.S_bc(i).R), inertia_about_com(m.M(i))));
    eq.holds(m.M(i, m.C_of_t(c)), block_diagonal(Theta_c, m.M(i).m * identity(3)));
    eq.holds(m.M(i, m.C_of_t(c)), M_c(m, i));

    const Mat3 Rt = to_matrix(m.C(c).R).transpose();
    const Mat3 dR = rate(to_matrix(m.C_of_t(c).R));
    eq.holds(tilde(m.twist<BodyFixed>(c).w), Rt * dR);
    eq.holds(m.twist<BodyFixed>(c).v, Rt * to_matrix(rate(m.C_of_t(c).r)));
  });
}

// M^b = Ad_S⁻ᵀ M_c^b Ad_S⁻¹ = [[Θ_b, m d̃], [-m d̃, m I]] with S = S_bc and Θ_b = R_bc Θ_c R_bcᵀ - m d̃²
TEST(Paper, Mb) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 M_b = m.M(i, m.C_of_t(i)), M_c = m.M(i, m.C_of_t(m.com(i))), Ad_inv = Ad(m.S_bc(i)).inverse();
    const double mass = M_c(3, 3);
    const Mat3 R = to_matrix(m.S_bc(i).R), d = tilde(m.S_bc(i).r), Theta_c = M_c.block(0, 0, 3, 3);
    const Mat3 Theta_b = R * Theta_c * R.transpose() - mass * d * d;
    eq.holds(M_b, m.M(i));
    eq.holds(M_b, Ad_inv.transpose() * M_c * Ad_inv);
    eq.holds(M_b, blocks(Theta_b, mass * d, -mass * d, mass * identity(3)));
    const Sym3<> Theta{Theta_c(0, 0), Theta_c(1, 1), Theta_c(2, 2),
                       Theta_c(0, 1), Theta_c(0, 2), Theta_c(1, 2)};
    eq.holds(M_b, inertia_from_com(mass, m.S_bc(i).r, Theta, m.S_bc(i).R));
  });
}

// W^b = Π̇^b - ad_Vᵀ Π^b = M^b V̇^b - ad_Vᵀ M^b V^b
TEST(Paper, NEb) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 M = to_matrix(m.M(i));
    const Vec6 V = m.V<BodyFixed>(i);
    eq.holds(m.W<BodyFixed>(i), rate(m.Pi_of_t<BodyFixed>(i)) - ad(V).transpose() * m.Pi<BodyFixed>(i));
    eq.holds(m.W<BodyFixed>(i), M * m.dV<BodyFixed>(i) - ad(V).transpose() * M * V);
    eq.holds(m.W<BodyFixed>(i), newton_euler(m.M(i), m.twist<BodyFixed>(i), m.twist_rate<BodyFixed>(i)));
  });
}

// Θ_b ω̇ + ω̃ Θ_b ω + m d̃_bc (v̇ + ω̃ v) = t^b, body-fixed. Printed: ... - m (v̇ + ω̃ v) d̃_bc, a column
// times a matrix, which means nothing; with the factors in the order that does, its sign is wrong.
TEST(Paper, NEbexp1) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat3 Theta = to_matrix(m.M(i).Theta), md = tilde(m.M(i).h);
    const Vec6 V = m.V<BodyFixed>(i), dV = m.dV<BodyFixed>(i), W = m.W<BodyFixed>(i);
    const Vec3d w = angular(V), dw = angular(dV);
    const Vec3d Euler = Theta * dw + tilde(w) * Theta * w, dv_wv = linear(dV) + tilde(w) * linear(V);
    eq.holds(angular(W), Euler + md * dv_wv);
    eq.holds(newton_euler(m.M(i), m.twist<BodyFixed>(i), m.twist_rate<BodyFixed>(i)).m, Euler + md * dv_wv);
    eq.fails(angular(W), Euler - md * dv_wv);
  });
}

// m (v̇ + ω̃ v + (ω̃̇ + ω̃ ω̃) d_bc) = f^b, body-fixed
TEST(Paper, NEbexp2) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Vec6 V = m.V<BodyFixed>(i), dV = m.dV<BodyFixed>(i);
    const Mat3 w = tilde(angular(V)), dw = tilde(angular(dV));
    const Vec3d d = to_matrix(m.S_bc(i).r), f = m.M(i).m * (linear(dV) + w * linear(V) + (dw + w * w) * d);
    eq.holds(linear(m.W<BodyFixed>(i)), f);
    eq.holds(newton_euler(m.M(i), m.twist<BodyFixed>(i), m.twist_rate<BodyFixed>(i)).f, f);
  });
}

// W_c^b = M_c^b V̇_c^b - ad_ωᵀ M_c^b V_c^b
TEST(Paper, NEb0) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int c = m.com(i);
    const Mat6 M = to_matrix(M_c(m, i));
    const Vec6 V = m.V<BodyFixed>(c);
    eq.holds(m.W<BodyFixed>(c), M * m.dV<BodyFixed>(c) - ad_w(angular(V)).transpose() * M * V);
    eq.holds(m.W<BodyFixed>(c), newton_euler(M_c(m, i), m.twist<BodyFixed>(c), m.twist_rate<BodyFixed>(c)));
  });
}

// Θ_c ω̇_c + ω̃_c Θ_c ω_c = t_c, body-fixed
TEST(Paper, NEb0exp1) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int c = m.com(i);
    const Mat3 Theta_c = to_matrix(M_c(m, i).Theta);
    const Vec3d w = angular(m.V<BodyFixed>(c)), dw = angular(m.dV<BodyFixed>(c));
    const Vec3d t = Theta_c * dw + tilde(w) * Theta_c * w;
    const double size = m.W<BodyFixed>(c).norm();  // t = 0 for a body that only slides
    eq.holds(angular(m.W<BodyFixed>(c)), t, size);
    eq.holds(newton_euler(M_c(m, i), m.twist<BodyFixed>(c), m.twist_rate<BodyFixed>(c)).m, t, size);
  });
}

// m (v̇_c + ω̃_c v_c) = f_c, body-fixed
TEST(Paper, NEb0exp2) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int c = m.com(i);
    const Vec6 V = m.V<BodyFixed>(c);
    const Vec3d f = m.M(i).m * (linear(m.dV<BodyFixed>(c)) + tilde(angular(V)) * linear(V));
    eq.holds(linear(m.W<BodyFixed>(c)), f);
    eq.holds(newton_euler(M_c(m, i), m.twist<BodyFixed>(c), m.twist_rate<BodyFixed>(c)).f, f);
  });
}

}  // namespace
}  // namespace axode::test::paper
