#include "tests/paper/equation.hpp"

/// Section 3.1: Newton-Euler equations, spatial representation. Left sides come from point masses.
namespace axode::test::paper {
namespace {

/// M^s as the library computes it.
Mat6 M_s(const Motion& m, int i) { return to_matrix(transform(m.pose(i), m.M(i))); }
MatrixOfT M_s_of_t(const Motion& m, int i) { return to_matrix(transform(m.C_of_t(i), cast<Series>(m.M(i)))); }

// M^s = Ad_C⁻ᵀ M^b Ad_C⁻¹
TEST(Paper, Ms) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 Ad_inv = Ad(m.C(i)).inverse();
    eq.holds(M_s(m, i), Ad_inv.transpose() * to_matrix(m.M(i)) * Ad_inv);
    eq.holds(m.M(i, m.frame<Spatial>(i)), M_s(m, i));
  });
}

// Π^s = M^s V^s = Ad_C⁻ᵀ M^b Ad_C⁻¹ V^s = Ad_C⁻ᵀ Π^b
TEST(Paper, Pis) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 Ad_inv = Ad(m.C(i)).inverse();
    const Vec6 V_s = m.V<Spatial>(i);
    const Momentum<BodyFixed> Pi_b = m.M(i) * m.twist<BodyFixed>(i);
    eq.holds(m.Pi<Spatial>(i), transform(m.pose(i), m.M(i)) * m.twist<Spatial>(i));
    eq.holds(m.Pi<Spatial>(i), Ad_inv.transpose() * to_matrix(m.M(i)) * Ad_inv * V_s);
    eq.holds(m.Pi<Spatial>(i), Ad_inv.transpose() * to_matrix(Pi_b));
    eq.holds(m.Pi<Spatial>(i), change<Spatial>(m.pose(i), Pi_b));
  });
}

// Π̇^s = W^s
TEST(Paper, Pisdot) {
  each_body([](Equation& eq, const Motion& m, int i) {
    eq.holds(rate(M_s_of_t(m, i) * m.V_of_t<Spatial>(i)), m.W<Spatial>(i));
  });
}

// Ṁ^s = -ad_Vᵀ M^s - M^s ad_V with V = V^s
TEST(Paper, Msdot) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 ad_V = ad(m.V<Spatial>(i)), M = M_s(m, i);
    eq.holds(rate(M_s_of_t(m, i)), -(ad_V.transpose() * M + M * ad_V));
    eq.holds(rate(M_s_of_t(m, i)), inertia_rate(m.twist<Spatial>(i), transform(m.pose(i), m.M(i))));
  });
}

// W^s = M^s V̇^s - ad_Vᵀ M^s V^s
TEST(Paper, NEs) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 M = M_s(m, i);
    const Vec6 V = m.V<Spatial>(i);
    eq.holds(m.W<Spatial>(i), M * m.dV<Spatial>(i) - ad(V).transpose() * M * V);
    eq.holds(m.W<Spatial>(i), wrench(m.pose(i), m.M(i), m.twist<Spatial>(i), m.twist_rate<Spatial>(i)));
  });
}

// With C^s = -ad_Vᵀ M^s: Ṁ^s - 2 C^s = ad_Vᵀ M^s - M^s ad_V is skew symmetric
TEST(Paper, RemSkew) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 ad_V = ad(m.V<Spatial>(i)), M = M_s(m, i), C_s = -(ad_V.transpose() * M);
    const Mat6 N = rate(M_s_of_t(m, i)) - 2 * C_s,
               by_library =
                   to_matrix(inertia_rate(m.twist<Spatial>(i), transform(m.pose(i), m.M(i)))) - 2 * C_s;
    eq.holds(N, ad_V.transpose() * M - M * ad_V);
    eq.holds(N, -N.transpose());
    eq.holds(by_library, -by_library.transpose());
  });
}

}  // namespace
}  // namespace axode::test::paper
