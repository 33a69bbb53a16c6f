#include "tests/paper/equation.hpp"

/// Section 3.4: Newton-Euler equations, mixed representation. Left sides come from point masses.
namespace axode::test::paper {
namespace {

/// The mixed wrench, at the origin of frame f, that gives its body the motion that it has, as the library
/// computes it.
template <class InertiaOfBody> Wrench<Mixed> W_m(const Motion& m, int f, const InertiaOfBody& M) {
  return newton_euler(M, m.pose(f).R, m.twist<Mixed>(f), m.twist_rate<Mixed>(f));
}

// Rᵀ r̈ = v̇^b + ω̃^b v^b. Printed: r̈, without the rotation.
TEST(Paper, OriginAccelerationFromBodyTwist) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Vec6 V = m.V<BodyFixed>(i);
    const Vec3d dv_wv = linear(m.dV<BodyFixed>(i)) + tilde(angular(V)) * linear(V);
    const Mat3 Rt = to_matrix(m.C(i).R).transpose();
    eq.holds(Rt * m.ddr(i), dv_wv);
    eq.holds(Rt * to_matrix(m.twist_rate<Mixed>(i).v), dv_wv);
    const auto V_b = m.twist<BodyFixed>(i);
    const auto dV_b = m.twist_rate<BodyFixed>(i);
    eq.holds(Rt * to_matrix(change<Hybrid>(m.pose(i), V_b, dV_b).v), dv_wv);
    eq.holds(Rt * to_matrix(change<Mixed>(m.pose(i), V_b, dV_b).v), dv_wv);
    eq.fails(m.ddr(i), dv_wv);
  });
}

// Θ_b ω̇ + ω̃ Θ_b ω + m d̃_bc Rᵀ r̈ = t^b with ω = ω^b
TEST(Paper, NEmRot) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat3 Theta = to_matrix(m.M(i).Theta), d = tilde(m.S_bc(i).r), Rt = to_matrix(m.C(i).R).transpose();
    const Vec3d w = angular(m.V<Mixed>(i)), dw = angular(m.dV<Mixed>(i));
    const Vec3d t = Theta * dw + tilde(w) * Theta * w + m.M(i).m * d * Rt * m.ddr(i);
    eq.holds(angular(m.W<Mixed>(i)), t);
    eq.holds(W_m(m, i, m.M(i)).m, t);
  });
}

// m (r̈ + R (ω̃̇ + ω̃ ω̃) d_bc) = f^h with ω = ω^b
TEST(Paper, NEmTrans) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat3 w = tilde(angular(m.V<Mixed>(i))), dw = tilde(angular(m.dV<Mixed>(i))),
               R = to_matrix(m.C(i).R);
    const Vec3d f = m.M(i).m * (m.ddr(i) + R * (dw + w * w) * to_matrix(m.S_bc(i).r));
    eq.holds(linear(m.W<Hybrid>(i)), f);
    eq.holds(W_m(m, i, m.M(i)).f, f);
  });
}

// Θ_c ω̇_c + ω̃_c Θ_c ω_c = t_c^b and m r̈_c = f_c^h
TEST(Paper, NEcmixed) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int c = m.com(i);
    const CentralInertia<> M = M_c(m, i);
    const Mat3 Theta = to_matrix(M.Theta);
    const Vec3d w = angular(m.V<Mixed>(c)), t = Theta * angular(m.dV<Mixed>(c)) + tilde(w) * Theta * w;
    const double size = m.W<Mixed>(c).norm();  // t = 0 for a body that only slides
    eq.holds(angular(m.W<Mixed>(c)), t, size);
    eq.holds(W_m(m, c, M).m, t, size);
    eq.holds(linear(m.W<Mixed>(c)), M.m * m.ddr(c));
    eq.holds(W_m(m, c, M).f, M.m * m.ddr(c));
  });
}

}  // namespace
}  // namespace axode::test::paper
