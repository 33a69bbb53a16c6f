#include "tests/paper/equation.hpp"

/// Section 3.5: Newton-Euler equations of body i, measured at the origin of frame j and resolved in frame k.
/// Each of these frames may be that of any body or of the ground. Left sides come from point masses.
namespace axode::test::paper {
namespace {

/// ^kV_i^j as the library computes it, and its rate.
Twist<InFrames> V_jk(const Motion& m, int i, int j, int k) {
  return change(m.frame_pair(j, k), m.twist<Spatial>(i));
}
TwistRate<InFrames> dV_jk(const Motion& m, int i, int j, int k) {
  return change(m.frame_pair(j, k), m.twist<Spatial>(i), m.twist_rate<Spatial>(i));
}
/// ^kM_i^j and ^kW_i^j as the library computes them.
Inertia<> M_jk(const Motion& m, int i, int j, int k) {
  return inertia_in_frames(m.frame_pair(j, k), m.pose(i), m.M(i));
}
Wrench<InFrames> W_jk(const Motion& m, int i, int j, int k) {
  return wrench(m.pose(i), m.M(i), m.frame_pair(j, k), V_jk(m, i, j, k), dV_jk(m, i, j, k));
}
/// M_i^s by definition.
Mat6 M_spatial(const Motion& m, int i) { return m.M(i, m.frame<Spatial>(i)); }
/// R_{j,k} = R_jᵀ R_k.
SO3<> R(const Motion& m, int j, int k) { return m.C(j, k).R; }

template <class Check> void each_body_in_frame(const Check& check) {
  each_body([&](Equation& eq, const Motion& m, int i) {
    for (int j = 0; j <= m.n(); ++j) check(eq, m, i, j);
  });
}

// Ad_{C_j}ᵀ Π̇_i^s = Ad_{C_j}ᵀ W_i^s
TEST(Paper, NEInFrameJ) {
  each_body_in_frame([](Equation& eq, const Motion& m, int i, int j) {
    const MatrixOfT M_s_of_t = to_matrix(transform(m.C_of_t(i), cast<Series>(m.M(i))));
    const Vec6 left = Ad(m.C(j)).transpose() * rate(M_s_of_t * m.V_of_t<Spatial>(i));
    eq.holds(left, Ad(m.C(j)).transpose() * m.W<Spatial>(i));
    eq.holds(left, m.W(i, m.C_of_t(j)));
    const Wrench<Spatial> W_s = wrench(m.pose(i), m.M(i), m.twist<Spatial>(i), m.twist_rate<Spatial>(i));
    eq.holds(left, change(m.frame_pair(j, j), W_s));
  });
}

// V_i^s = Ad_{C_j} ^jV_i and V̇_i^s = Ad_{C_j} ^jV̇_i + ad_{V_j^s} V_i^s
TEST(Paper, TwistInMovingFrameRate) {
  each_body_in_frame([](Equation& eq, const Motion& m, int i, int j) {
    const Vec6OfT jV = m.V_of_t(i, m.C_of_t(j));
    eq.holds(m.twist<Spatial>(i), Ad(m.C(j)) * now(jV));
    eq.holds(m.twist_rate<Spatial>(i), Ad(m.C(j)) * rate(jV) + ad(m.V<Spatial>(j)) * m.V<Spatial>(i));
    eq.holds(V_jk(m, i, j, j), now(jV));
    eq.holds(dV_jk(m, i, j, j), rate(jV));
  });
}

// ^jM_i (^jV̇_i + ad_{^jV_j} ^jV_i) - ad_{^jV_i}ᵀ ^jM_i ^jV_i = ^jW_i
TEST(Paper, NEij) {
  each_body_in_frame([](Equation& eq, const Motion& m, int i, int j) {
    const PoseOfT F_j = m.C_of_t(j);
    const Mat6 M = m.M(i, F_j);
    const Vec6OfT jV_i = m.V_of_t(i, F_j);
    const Vec6 V = now(jV_i), V_j = now(m.V_of_t(j, F_j));
    const Vec6 left = M * (rate(jV_i) + ad(V_j) * V) - ad(V).transpose() * M * V;
    eq.holds(left, m.W(i, F_j));
    eq.holds(left, W_jk(m, i, j, j));
  });
}

// ^jM_i = Ad_{C_j}ᵀ M_i^s Ad_{C_j}; the kinetic energy is ½ ^jVᵀ ^jM_i ^jV
TEST(Paper, InertiaInFrameJ) {
  each_body_in_frame([](Equation& eq, const Motion& m, int i, int j) {
    const Mat6 Ad_j = Ad(m.C(j)), M = Ad_j.transpose() * M_spatial(m, i) * Ad_j;
    const Vec6 V = now(m.V_of_t(i, m.C_of_t(j)));
    eq.holds(M_jk(m, i, j, j), M);
    eq.holds(m.M(i, m.C_of_t(j)), M);
    eq.holds(m.kinetic_energy(i), 0.5 * V.dot(M * V));
    eq.holds(m.kinetic_energy(i), 0.5 * ((M_jk(m, i, j, j) * V_jk(m, i, j, j)) | V_jk(m, i, j, j)));
  });
}

// Ad_{R_{j,k}}ᵀ Ad_{C_j}ᵀ Π̇_i^s = Ad_{R_{j,k}}ᵀ Ad_{C_j}ᵀ W_i^s
TEST(Paper, NEInFramesJK) {
  each_body_in_frames([](Equation& eq, const Motion& m, int i, int j, int k) {
    const Mat6 Ad_jk = Ad(m.C(j)) * Ad(R(m, j, k));
    const Vec6 left = Ad_jk.transpose() * rate(m.Pi_of_t<Spatial>(i));
    eq.holds(left, m.W(i, m.frame_jk(j, k)));
    eq.holds(left, Ad_jk.transpose() * m.W<Spatial>(i));
    const Wrench<Spatial> W_s = wrench(m.pose(i), m.M(i), m.twist<Spatial>(i), m.twist_rate<Spatial>(i));
    eq.holds(left, change(m.frame_pair(j, k), W_s));
  });
}

// ^jV̇_i^j = Ad_{R_{j,k}} ^kV̇_i^j + ad_{^j(ω_k - ω_j)} Ad_{R_{j,k}} ^kV_i^j. Printed: ad of ^jω_k, the
// absolute angular velocity of F_k instead of that relative to F_j.
TEST(Paper, TwistRateChangeOfResolvingFrame) {
  each_body_in_frames([](Equation& eq, const Motion& m, int i, int j, int k) {
    const Vec6OfT kV = m.V_of_t(i, m.frame_jk(j, k));
    const Mat6 Ad_jk = Ad(R(m, j, k));
    const Vec3d w_j = angular(now(m.V_of_t(j, m.C_of_t(j)))), w_k = angular(now(m.V_of_t(k, m.C_of_t(j))));
    const Vec6 left = rate(m.V_of_t(i, m.C_of_t(j)));
    eq.holds(left, Ad_jk * rate(kV) + ad_w(w_k - w_j) * Ad_jk * now(kV));
    eq.holds(dV_jk(m, i, j, j), Ad_jk * rate(kV) + ad_w(w_k - w_j) * Ad_jk * now(kV));
    eq.holds(dV_jk(m, i, j, k), rate(kV));
    eq.fails(left, Ad_jk * rate(kV) + ad_w(w_k) * Ad_jk * now(kV));
  });
}

// M (^kV̇_i^j + (ad_{^kV_j^j} + ad_{^k(ω_k - ω_j)}) ^kV_i^j) - ad_{^kV_i^j}ᵀ M ^kV_i^j = ^kW_i^j with M =
// ^kM_i^j. Printed: ad of ^kω_k, the absolute angular velocity of F_k instead of that relative to F_j.
TEST(Paper, NEJKBoxed) {
  each_body_in_frames([](Equation& eq, const Motion& m, int i, int j, int k) {
    const PoseOfT F = m.frame_jk(j, k);
    const Mat6 M = m.M(i, F);
    const Vec6OfT kV_i = m.V_of_t(i, F);
    const Vec6 V = now(kV_i), V_j = now(m.V_of_t(j, F)), V_k = now(m.V_of_t(k, F));
    const auto side = [&](const Vec3d& w) -> Vec6 {
      return M * (rate(kV_i) + (ad(V_j) + ad_w(w)) * V) - ad(V).transpose() * M * V;
    };
    eq.holds(side(angular(V_k) - angular(V_j)), m.W(i, F));
    eq.holds(side(angular(V_k) - angular(V_j)), W_jk(m, i, j, k));
    eq.fails(side(angular(V_k)), m.W(i, F));
  });
}

// ^kM_i^j = Ad_Rᵀ ^jM_i Ad_R = Ad_Rᵀ Ad_{C_j}ᵀ M_i^s Ad_{C_j} Ad_R with R = R_{j,k}. Printed: R = R_{k,j}.
TEST(Paper, InertiaMeasuredAtJResolvedInK) {
  each_body_in_frames([](Equation& eq, const Motion& m, int i, int j, int k) {
    const Mat6 jM = m.M(i, m.C_of_t(j)), Ad_R = Ad(R(m, j, k)), Ad_C_R = Ad(m.C(j)) * Ad_R;
    eq.holds(M_jk(m, i, j, k), m.M(i, m.frame_jk(j, k)));
    eq.holds(M_jk(m, i, j, k), Ad_R.transpose() * jM * Ad_R);
    eq.holds(M_jk(m, i, j, k), Ad_C_R.transpose() * M_spatial(m, i) * Ad_C_R);
    const Mat6 Ad_printed = Ad(R(m, k, j));
    eq.fails(M_jk(m, i, j, k), Ad_printed.transpose() * jM * Ad_printed);
  });
}

}  // namespace
}  // namespace axode::test::paper
