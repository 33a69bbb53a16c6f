#include <limits>

#include "tests/paper/equation.hpp"

/// Appendix B: rigid body motions and the Lie group SE(3). The screws are twists, joint screws and joint
/// wrenches of the bodies.
namespace axode::test::paper {
namespace {

Screw<> V_s(const Motion& m, int i) { return screw(m.twist<Spatial>(i)); }

/// Calls check(equation, motion, i, j) for every pair of bodies.
template <class Check> void each_pair(const Check& check) {
  each_body([&](Equation& eq, const Motion& m, int i) {
    for (int j = 1; j <= m.n(); ++j)
      if (j != i) check(eq, m, i, j);
  });
}

// dX̂/dt = V̂_i^s X̂ - X̂ V̂_i^s = [V̂_i^s, X̂] for X = Ad_{C_i} ^iX with ^iX constant. Printed: V̂ X̂ - V̂
// X̂, which is 0.
TEST(Paper, BodyFixedScrewRate) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Screw<> iX{m.drawn(i).points[0].p, m.drawn(i).points[1].p};  // any constant screw
    const Screw<Series> iX_of_t{cast<Series>(iX.w), cast<Series>(iX.v)};
    const Mat4 left = rate(hat(Ad(m.C_of_t(i), iX_of_t)));
    const Screw<> X = Ad(m.pose(i), iX);
    const Mat4 V_hat = hat(V_s(m, i)), X_hat = hat(X);
    eq.holds(left, V_hat * X_hat - X_hat * V_hat);
    eq.holds(left, hat(ad(V_s(m, i), X)));
    eq.fails(left, V_hat * X_hat - V_hat * X_hat);
  });
}

// [X̂_1, X̂_2] = X̂_1 X̂_2 - X̂_2 X̂_1 = ad_{X_1}(X_2)
TEST(Paper, LieBracketSE3) {
  each_pair([](Equation& eq, const Motion& m, int i, int j) {
    const Screw<> X_1 = V_s(m, i), X_2 = V_s(m, j);
    eq.holds(hat(X_1) * hat(X_2) - hat(X_2) * hat(X_1), hat(ad(X_1, X_2)));
  });
}

// [X_1, X_2] = (ξ_1 × ξ_2, η_1 × ξ_2 + ξ_1 × η_2) = ad_{X_1} X_2 with X = (ξ, η)
TEST(Paper, ScrewProd) {
  each_pair([](Equation& eq, const Motion& m, int i, int j) {
    const Vec6 X_1 = to_matrix(V_s(m, i)), X_2 = to_matrix(V_s(m, j));
    const Vec3d xi_1 = angular(X_1), xi_2 = angular(X_2), eta_1 = linear(X_1), eta_2 = linear(X_2);
    const Vec6 product = stack(xi_1.cross(xi_2), eta_1.cross(xi_2) + xi_1.cross(eta_2));
    eq.holds(ad(V_s(m, i), V_s(m, j)), product);
    eq.holds(ad(m.twist<Spatial>(i), m.twist<Spatial>(j)), product);
    eq.holds(ad(V_s(m, i)) * X_2, product);
  });
}

// ad_X = [[ξ̃, 0], [η̃, ξ̃]] with X = (ξ, η); it is d/dt Ad_{exp(X t)} at t = 0
TEST(Paper, Adse3) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Screw<> X = V_s(m, i);
    const Mat3 xi = tilde(X.w), eta = tilde(X.v);
    eq.holds(ad(X), blocks(xi, Mat3(), eta, xi));
    const Series t({0, 1, 0});
    eq.holds(ad(X), rate(Ad(exp(t * Screw<Series>{cast<Series>(X.w), cast<Series>(X.v)}))));
  });
}

// [X_1, [X_2, X_3]] + [X_2, [X_3, X_1]] + [X_3, [X_1, X_2]] = 0
TEST(Paper, JacIdent) {
  each_pair([](Equation& eq, const Motion& m, int i, int j) {
    const Screw<> X_1 = V_s(m, i), X_2 = V_s(m, j), X_3 = Ad(m.pose(i), m.X_screw(i));
    eq.holds(ad(X_1, ad(X_2, X_3)), -(ad(X_2, ad(X_3, X_1)) + ad(X_3, ad(X_1, X_2))));
  });
}

// Ad_{C_i}⁻¹ Ẋ = ^iẊ + [V_i^b, ^iX] for X = Ad_{C_i} ^iX that moves; here the twist of another body
TEST(Paper, ScrewRateInMovingFrame) {
  each_pair([](Equation& eq, const Motion& m, int i, int j) {
    const Vec6OfT iX = Ad(inverse(m.C_of_t(i))) * m.V_of_t<Spatial>(j);
    const Vec6 left = Ad(m.pose(i)).inverse() * to_matrix(m.twist_rate<Spatial>(j));
    eq.holds(left, rate(iX) + ad(m.V<BodyFixed>(i)) * now(iX));
  });
}

// V = (ω; 0) + (0; v), ad_ω = [[ω̃, 0], [0, ω̃]], ad_v = [[0, 0], [ṽ, 0]]: infinitesimal versions of Ad_R and
// Ad_r
TEST(Paper, AngularLinearParts) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Twist<Hybrid> V = m.twist<Hybrid>(i);
    const Mat6 ad_omega = ad(Screw<>{V.w, {}}), ad_dr = ad(Screw<>{{}, V.v});
    eq.holds(ad_omega, block_diagonal(tilde(V.w), tilde(V.w)));
    eq.holds(ad_dr, blocks(Mat3(), Mat3(), tilde(V.v), Mat3()));
    eq.holds(ad_omega + ad_dr, ad(Screw<>{V.w, V.v}));
    eq.holds(rate(Ad(m.C_of_t(i).R)), ad_omega * Ad(m.pose(i).R));
    eq.holds(rate(Ad(m.C_of_t(i).r)), ad_dr);
  });
}

// V = ω (e, p × e + h e) with h = vᵀω/ω²; W = (t, f) = f (p × e + h e, e) with h = tᵀf/f²
TEST(Paper, PitchOfTwistAndWrench) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Twist<Spatial> V = m.twist<Spatial>(i);
    const ScrewAxis<> axis = screw_axis(V);
    if (axis.h < std::numeric_limits<double>::infinity()) {
      const double w = norm(V.w);
      eq.holds(V, Screw<>{w * axis.e, w * (cross(axis.p, axis.e) + axis.h * axis.e)});
      eq.holds(axis.h, dot(V.v, V.w) / (w * w), norm(V.v) / w);
      eq.holds(V.v + cross(V.w, axis.p), axis.h * V.w, norm(V.v));  // points of the axis move along it
    } else {
      eq.holds(V, Screw<>{{}, norm(V.v) * axis.e});
    }
    eq.holds(V, screw(axis));

    const Wrench<Spatial> W = m.joint_wrench<Spatial>(i);
    const ScrewAxis<> central = screw_axis(W);
    const double f = norm(W.f);
    eq.holds(W.m, f * (cross(central.p, central.e) + central.h * central.e));
    eq.holds(W.f, f * central.e);
    eq.holds(central.h, dot(W.m, W.f) / (f * f), norm(W.m) / f);
  });
}

// ²W = Ad_Sᵀ ¹W with S = S_{1,2}, and ²Wᵀ ²V = ¹Wᵀ ¹V
TEST(Paper, WrenchTransform) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int c = m.com(i);
    const SE3<> S = m.S_bc(i);
    const auto W_1 = from_six<Wrench<BodyFixed>>(m.W<BodyFixed>(i));
    const auto W_2 = from_six<Wrench<BodyFixed>>(m.W<BodyFixed>(c));
    eq.holds(W_2, Ad(S).transpose() * to_matrix(W_1));
    eq.holds(W_1, Link<BodyFixed, double>{S}.up(W_2));
    eq.holds(W_2 | m.twist<BodyFixed>(c), W_1 | m.twist<BodyFixed>(i));
    eq.holds(m.W<BodyFixed>(i), Ad(m.C(i)).transpose() * m.W<Spatial>(i));
    eq.holds(m.W<BodyFixed>(i), coAd_inv(m.pose(i), from_six<Wrench<Spatial>>(m.W<Spatial>(i))));
  });
}

// X_1 ⊙ X_2 = ξ_1ᵀ η_2 + η_1ᵀ ξ_2: the power of a wrench written as a screw; 0 for two axes without pitch
// that meet or are parallel
TEST(Paper, ReciprocalProduct) {
  each_pair([](Equation& eq, const Motion& m, int i, int j) {
    const Wrench<Spatial> W = m.joint_wrench<Spatial>(i);
    const Screw<> force{W.f, W.m}, motion = V_s(m, j);
    eq.holds(reciprocal_product(force, motion), W | m.twist<Spatial>(j));
    eq.holds(reciprocal_product(force, motion), dot(force.w, motion.v) + dot(force.v, motion.w));

    const Vec3<> p = m.pose(i).r, q = m.pose(j).r, e_1 = m.pose(i).R.x, e_2 = m.pose(j).R.y;
    const Screw<> X_1 = screw(e_1, p), X_2 = screw(e_2, q);
    const double distance_and_angle = dot(p - q, cross(e_1, e_2));
    eq.holds(reciprocal_product(X_1, X_2), distance_and_angle);
    const Screw<> meets = screw(e_2, p), parallel = screw(e_1, q);
    eq.holds(reciprocal_product(X_1, meets), 0.0, norm(p));
    eq.holds(reciprocal_product(X_1, parallel), 0.0, norm(p) + norm(q));
  });
}

}  // namespace
}  // namespace axode::test::paper
