#include "tests/paper/equation.hpp"

/// Section 3.3: Newton-Euler equations, hybrid representation. Left sides come from point masses.
namespace axode::test::paper {
namespace {

/// M_c^h and M^h as the library computes them.
CentralInertia<> M_c_h(const Motion& m, int i) { return transform(m.pose(m.com(i)).R, M_c(m, i)); }
Inertia<> M_h(const Motion& m, int i) { return transform(m.pose(i).R, m.M(i)); }
MatrixOfT M_c_h_of_t(const Motion& m, int i) {
  const CentralInertia<Series> M{M_c(m, i).m, cast<Series>(Inertia<>(M_c(m, i))).Theta};
  return to_matrix(transform(m.C_of_t(m.com(i)).R, M));
}
MatrixOfT M_h_of_t(const Motion& m, int i) {
  return to_matrix(transform(m.C_of_t(i).R, cast<Series>(m.M(i))));
}
/// d_bc, from the origin of the body frame to the centre of mass, in the inertial frame.
Vec3<> d_bc(const Motion& m, int i) { return now(m.r_of_t(i, m.com(i))); }
Vec3d dd_bc(const Motion& m, int i) { return to_matrix(rate(m.r_of_t(i, m.com(i)))); }
/// ω^s and ω̇^s.
Vec3d w_s(const Motion& m, int i) { return angular(m.V<Spatial>(i)); }
Vec3d dw_s(const Motion& m, int i) { return angular(m.dV<Spatial>(i)); }

// V_c^h = Ad_R V_c^b with R = R_c. Printed: Ad_R⁻¹.
TEST(Paper, HybridComTwist) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int c = m.com(i);
    const Mat6 Ad_R = Ad(m.C(c).R);
    const Vec6 V_c_b = to_matrix(m.twist<BodyFixed>(c));
    eq.holds(m.V<Hybrid>(c), Ad_R * V_c_b);
    eq.holds(change<Hybrid>(m.pose(c), m.twist<BodyFixed>(c)), Ad_R * V_c_b);
    eq.fails(m.V<Hybrid>(c), Ad_R.inverse() * V_c_b);
  });
}

// M_c^h = Ad_R⁻ᵀ M_c^b Ad_R⁻¹ = diag(Θ_c^h, m I), Θ_c^h = R Θ_c Rᵀ with R = R_c
TEST(Paper, M0h) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int c = m.com(i);
    const Mat6 Ad_inv = Ad(m.C(c).R).inverse(), M_c_b = m.M(i, m.C_of_t(c));
    const Mat3 R = to_matrix(m.C(c).R), Theta_c = M_c_b.block(0, 0, 3, 3);
    eq.holds(M_c_h(m, i), m.M(i, m.frame<Hybrid>(c)));
    eq.holds(M_c_h(m, i), Ad_inv.transpose() * M_c_b * Ad_inv);
    eq.holds(M_c_h(m, i), block_diagonal(R * Theta_c * R.transpose(), m.M(i).m * identity(3)));
  });
}

// Π̇_c^h = W_c^h
TEST(Paper, HybridComMomentumBalance) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int c = m.com(i);
    eq.holds(rate(M_c_h_of_t(m, i) * m.V_of_t<Hybrid>(c)), m.W<Hybrid>(c));
  });
}

// Ṁ_c^h = -ad_ωᵀ M_c^h - M_c^h ad_ω, -ad_ωᵀ = ad_ω with ω = ω^s
TEST(Paper, HybridComInertiaRate) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 ad_ws = ad_w(w_s(m, i)), M = to_matrix(M_c_h(m, i));
    eq.holds(rate(M_c_h_of_t(m, i)), -(ad_ws.transpose() * M + M * ad_ws));
    eq.holds(rate(M_c_h_of_t(m, i)),
             inertia_rate(Twist<Spatial>{vec3(w_s(m, i)), {}}, Inertia<>(M_c_h(m, i))));
    eq.holds(-ad_ws.transpose(), ad_ws);
  });
}

// W_c^h = M_c^h V̇_c^h + ad_ω M_c^h (ω; 0) with ω = ω^s
TEST(Paper, NEh0) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int c = m.com(i);
    const Mat6 M = to_matrix(M_c_h(m, i));
    const Vec6 V = m.V<Hybrid>(c);
    eq.holds(m.W<Hybrid>(c), M * m.dV<Hybrid>(c) + ad_w(angular(V)) * M * angular_screw(V));
    eq.holds(m.W<Hybrid>(c), newton_euler(M_c_h(m, i), m.twist<Hybrid>(c), m.twist_rate<Hybrid>(c)));
  });
}

// Θ_c^h ω̇ + ω̃ Θ_c^h ω = t_c^h with ω = ω^s
TEST(Paper, NEhCOM) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int c = m.com(i);
    const Mat3 Theta = to_matrix(M_c_h(m, i).Theta);
    const Vec3d w = w_s(m, i), t = Theta * dw_s(m, i) + tilde(w) * Theta * w;
    const double size = m.W<Hybrid>(c).norm();  // t = 0 for a body that only slides
    eq.holds(angular(m.W<Hybrid>(c)), t, size);
    eq.holds(newton_euler(M_c_h(m, i), m.twist<Hybrid>(c), m.twist_rate<Hybrid>(c)).m, t, size);
  });
}

// m r̈_c = f_c^h. Printed: m ṙ_c.
TEST(Paper, NEhCOM2) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int c = m.com(i);
    const Vec3d f = linear(m.W<Hybrid>(c));
    eq.holds(m.M(i).m * m.ddr(c), f);
    eq.holds(newton_euler(M_c_h(m, i), m.twist<Hybrid>(c), m.twist_rate<Hybrid>(c)).f, f);
    eq.fails(m.M(i).m * linear(m.V<Hybrid>(c)), f);
  });
}

// V^h = Ad_d V_c^h with d = d_bc
TEST(Paper, HybridTwistFromCom) {
  each_body([](Equation& eq, const Motion& m, int i) {
    eq.holds(m.twist<Hybrid>(i), Ad(d_bc(m, i)) * m.V<Hybrid>(m.com(i)));
  });
}

// M^h = Ad_d⁻ᵀ M_c^h Ad_d⁻¹ = [[Θ^h, m d̃], [-m d̃, m I]], Θ^h = Θ_c^h - m d̃² with d = d_bc
TEST(Paper, Mh) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 Ad_inv = Ad(d_bc(m, i)).inverse(), M_c_h = m.M(i, m.frame<Hybrid>(m.com(i)));
    const double mass = M_c_h(3, 3);
    const Mat3 Theta_c = M_c_h.block(0, 0, 3, 3), d = tilde(d_bc(m, i));
    eq.holds(M_h(m, i), m.M(i, m.frame<Hybrid>(i)));
    eq.holds(M_h(m, i), Ad_inv.transpose() * M_c_h * Ad_inv);
    eq.holds(M_h(m, i), blocks(Theta_c - mass * d * d, mass * d, -mass * d, mass * identity(3)));
  });
}

// W^h = Π̇^h - ad_ṙᵀ Π^h. Printed: W^h = Π̇^h, true at the centre of mass only.
TEST(Paper, Pihdot) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Vec6OfT Pi = M_h_of_t(m, i) * m.V_of_t<Hybrid>(i);
    const Mat6 ad_dr = ad_v(linear(m.V<Hybrid>(i)));
    eq.holds(m.W<Hybrid>(i), rate(Pi) - ad_dr.transpose() * now(Pi));
    eq.fails(m.W<Hybrid>(i), rate(Pi));
  });
}

// (Ad_d⁻¹)˙ = -ad_ḋ with d = d_bc
TEST(Paper, AdTranslationInverseRate) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const MatrixOfT Ad_inv = Ad(-m.r_of_t(i, m.com(i)));
    eq.holds(now(Ad_inv), Ad(d_bc(m, i)).inverse());
    eq.holds(rate(Ad_inv), -ad_v(dd_bc(m, i)));
  });
}

// -ad_ḋ = ad_ω Ad_d⁻¹ - Ad_d⁻¹ ad_ω with d = d_bc, ω = ω^s. Printed: the opposite sign.
TEST(Paper, AdTranslationInverseRateCommutator) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 ad_ws = ad_w(w_s(m, i)), Ad_inv = Ad(d_bc(m, i)).inverse(), dAd_inv = -ad_v(dd_bc(m, i));
    eq.holds(dAd_inv, ad_ws * Ad_inv - Ad_inv * ad_ws);
    eq.fails(dAd_inv, Ad_inv * ad_ws - ad_ws * Ad_inv);
  });
}

// W^h = M^h V̇^h + ad_ω M^h (ω; 0) with ω = ω^s
TEST(Paper, NEh) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 M = to_matrix(M_h(m, i));
    const Vec6 V = m.V<Hybrid>(i);
    eq.holds(m.W<Hybrid>(i), M * m.dV<Hybrid>(i) + ad_w(angular(V)) * M * angular_screw(V));
    eq.holds(m.W<Hybrid>(i), wrench(m.pose(i), m.M(i), m.twist<Hybrid>(i), m.twist_rate<Hybrid>(i)));
  });
}

// Θ^h ω̇ + ω̃ Θ^h ω + m d̃_bc r̈ = t^h with ω = ω^s
TEST(Paper, NEhexp1) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat3 Theta = to_matrix(M_h(m, i).Theta), d = tilde(d_bc(m, i));
    const Vec3d w = w_s(m, i);
    const Vec3d t = Theta * dw_s(m, i) + tilde(w) * Theta * w + m.M(i).m * d * m.ddr(i);
    eq.holds(angular(m.W<Hybrid>(i)), t);
    eq.holds(newton_euler(M_h(m, i), m.twist<Hybrid>(i), m.twist_rate<Hybrid>(i)).m, t);
  });
}

// m (r̈ + (ω̃̇ + ω̃ ω̃) d_bc) = f^h with ω = ω^s, f^h = f^s
TEST(Paper, NEhexp2) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat3 w = tilde(w_s(m, i)), dw = tilde(dw_s(m, i));
    const Vec3d f = m.M(i).m * (m.ddr(i) + (dw + w * w) * to_matrix(d_bc(m, i)));
    eq.holds(linear(m.W<Hybrid>(i)), f);
    eq.holds(newton_euler(M_h(m, i), m.twist<Hybrid>(i), m.twist_rate<Hybrid>(i)).f, f);
    eq.holds(linear(m.W<Spatial>(i)), f);
  });
}

}  // namespace
}  // namespace axode::test::paper
