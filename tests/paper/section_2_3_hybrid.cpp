#include "tests/paper/columns.hpp"

/// Section 2.3: accelerations and partial derivatives, hybrid representation. j < i means that joint j is on
/// the path to joint i; j - 1 is the predecessor of body j.
namespace axode::test::paper {
namespace {

Vec6 J_h(const Motion& m, int i, int j) { return m.J<Hybrid>(i, j); }
Vec6 wJ(const Motion& m, int i, int j) { return angular_screw(J_h(m, i, j)); }
Vec6 vJ(const Motion& m, int i, int j) { return J_h(m, i, j) - wJ(m, i, j); }
/// ^0X_j^j, the screw of joint j in inertial axes, measured at body j.
Vec6 X(const Motion& m, int j) { return Ad(m.C(j).R) * m.X(j); }

Vec3d r(const Motion& m, int i, int j) { return to_matrix(m.C(j).r - m.C(i).r); }  // r_{i,j}, from i to j
Vec3d dr(const Motion& m, int i) { return linear(m.V<Hybrid>(i)); }
Vec3d dr(const Motion& m, int i, int j) { return dr(m, j) - dr(m, i); }
Vec3d ddr(const Motion& m, int i, int j) { return m.ddr(j) - m.ddr(i); }
Mat6 ad_omega(const Motion& m, int j) { return ad_w(angular(m.V<Spatial>(j))); }
Mat6 ad_domega(const Motion& m, int j) { return ad_w(angular(m.dV<Spatial>(j))); }

// J_{i,k} = ωJ_{i,k} + vJ_{i,k}: the angular part is that of the spatial column, the linear part is ∂r_i/∂q_k
TEST(Paper, JhSplit) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    for (const int k : m.path(i)) {
      const Mat4 dC = relative_pose_partial(m, 0, i, k);
      const Vec6 linear_part = stack(Vec3d(), dC.block(0, 3, 3, 1));
      eq.holds(jacobian_of<Hybrid>(m, i).col(velocity(m, k)),
               angular_screw(m.J<Spatial>(i, k)) + linear_part);
    }
  });
}

// ∂J_{i,j}^h/∂q_k = ∂Ad_{R_i}/∂q_k J_{i,j}^b + Ad_{R_i} ∂J_{i,j}^b/∂q_k = ad_{ωJ_{i,k}} Ad_{R_i} J_{i,j}^b +
// Ad_{R_i} [J_{i,j}^b, J_{i,k}^b] = [ωJ_{i,k}, J_{i,j}] + [J_{i,j}, J_{i,k}] = [J_{i,j}, J_{i,k} - ωJ_{i,k}]
// for j <= k <= i
TEST(Paper, JhderDerivation) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Mat6 Ad_R = Ad(m.C(i).R);
    for (const int j : m.path(i))
      for (const int k : m.path(i)) {
        if (k < j) continue;
        const Vec6 left = library_partial<Hybrid>(m, i, j, k);
        const Vec6 J_b = m.J<BodyFixed>(i, j), J_b_k = m.J<BodyFixed>(i, k);
        const Mat3 dR = relative_pose_partial(m, 0, i, k).block(0, 0, 3, 3);
        const double size = J_h(m, i, j).norm();
        eq.holds(left, block_diagonal(dR, dR) * J_b + Ad_R * partial_of<BodyFixed>(m, i, j, {k}), size);
        eq.holds(left, ad(wJ(m, i, k)) * Ad_R * J_b + Ad_R * bracket(J_b, J_b_k), size);
        eq.holds(left, bracket(wJ(m, i, k), J_h(m, i, j)) + bracket(J_h(m, i, j), J_h(m, i, k)), size);
        eq.holds(left, bracket(J_h(m, i, j), J_h(m, i, k) - wJ(m, i, k)), size);
      }
  });
}

// ∂J_{i,j}/∂q_k = [J_{i,j}, vJ_{i,k}] = -ad_{vJ_{i,k}} J_{i,j} for j <= k <= i, [ωJ_{i,k}, J_{i,j}] for k <
// j; hybrid
TEST(Paper, Jhder) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Matrix library = partials_of<Hybrid>(m, i, 1);
    for (const int j : m.path(i))
      for (const int k : m.path(i)) {
        const Vec6 left = partial_of<Hybrid>(m, i, j, {k});
        const double size = J_h(m, i, j).norm();
        if (j <= k) {
          eq.holds(left, bracket(J_h(m, i, j), vJ(m, i, k)), size);
          eq.holds(left, -ad(vJ(m, i, k)) * J_h(m, i, j), size);
        } else {
          eq.holds(left, bracket(wJ(m, i, k), J_h(m, i, j)), size);
        }
        eq.holds(library.col(velocity(m, k) * m.model().nv() + velocity(m, j)), left, size);
      }
  });
}

/// vΔV_{j-1,i}, the linear part of V_i - Ad_{r_{i,j-1}} V_{j-1}.
Vec6 vDeltaV(const Motion& m, int j, int i) {
  const int p = m.predecessor(j);
  const Vec6 Delta = m.V<Hybrid>(i) - Ad(r(m, i, p)) * m.V<Hybrid>(p);
  return Delta - angular_screw(Delta);
}

// J̇_{i,j} = Σ_{j<=k<=i} [J_{i,j}, vJ_{i,k}] q̇_k + Σ_{k<j} [ωJ_{i,k}, J_{i,j}] q̇_k = [J_{i,j}, vΔV_{j-1,i}]
// + ad_{ω_{j-1}} J_{i,j}
TEST(Paper, JhdotViaDeltaV) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    for (const int j : m.path(i)) {
      Vec6 right, printed;
      for (const int k : m.path(i)) {
        right +=
            (j <= k ? bracket(J_h(m, i, j), vJ(m, i, k)) : bracket(wJ(m, i, k), J_h(m, i, j))) * m.qd(k)[0];
        if (k <= j) printed += bracket(J_h(m, i, j), vJ(m, i, k)) * m.qd(k)[0];
      }
      const Vec6 left = dJ<Hybrid>(m, i, j), by_DeltaV = bracket(J_h(m, i, j), vDeltaV(m, j, i));
      const double size = J_h(m, i, j).norm();
      eq.holds(left, right, size);
      eq.holds(left, by_DeltaV + ad_omega(m, m.predecessor(j)) * J_h(m, i, j), size);
      eq.holds(left, library_dJ<Hybrid>(m, i, j), size);
      eq.fails(left, printed);
      eq.fails(left, by_DeltaV);
    }
  });
}

// J̇_{i,j} = (ad_{ṙ_{i,j}} + Ad_{r_{i,j}} ad_{ω_j}) ^0X_j^j, hybrid
TEST(Paper, JhdotLine1) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    for (const int j : m.path(i)) {
      const Vec6 left = dJ<Hybrid>(m, i, j);
      const auto right = [&](int to) -> Vec6 {
        return (ad_v(dr(m, i, j)) + Ad(r(m, i, to)) * ad_omega(m, j)) * X(m, j);
      };
      eq.holds(left, right(j), X(m, j).norm());
      eq.holds(library_dJ<Hybrid>(m, i, j), right(j), X(m, j).norm());
      eq.fails(left, right(m.predecessor(j)));
    }
  });
}

// J̇_{i,j} = Ad_{r_{i,j}} (ad_{ṙ_{i,j}} + ad_{ω_j}) ^0X_j^j, hybrid
TEST(Paper, JhdotLine2a) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    for (const int j : m.path(i)) {
      const Vec6 left = dJ<Hybrid>(m, i, j), X_dot = (ad_v(dr(m, i, j)) + ad_omega(m, j)) * X(m, j);
      eq.holds(left, Ad(r(m, i, j)) * X_dot, X(m, j).norm());
      eq.holds(library_dJ<Hybrid>(m, i, j), Ad(r(m, i, j)) * X_dot, X(m, j).norm());
      eq.fails(left, Ad(r(m, i, m.predecessor(j))) * X_dot);
    }
  });
}

// J̇_{i,j} = Ad_{r_{i,j}} (ad_{V_j^h} - ad_{ṙ_i}) ^0X_j^j, hybrid
TEST(Paper, JhdotLine2b) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    for (const int j : m.path(i)) {
      const Vec6 left = dJ<Hybrid>(m, i, j);
      const Vec6 right = Ad(r(m, i, j)) * (ad(m.V<Hybrid>(j)) - ad_v(dr(m, i))) * X(m, j);
      eq.holds(left, right, X(m, j).norm());
      eq.holds(library_dJ<Hybrid>(m, i, j), right, X(m, j).norm());
      eq.fails(left, Ad(r(m, i, m.predecessor(j))) * (ad(m.V<Spatial>(j)) - ad_v(dr(m, i))) * X(m, j));
    }
  });
}

// V̇_i = Σ_{j<=i} J_{i,j} q̈_j + Σ_{j<=k<=i} [J_{i,j}, vJ_{i,k}] q̇_j q̇_k + Σ_{k<j<=i} [ωJ_{i,k}, J_{i,j}]
// q̇_j q̇_k, hybrid
TEST(Paper, VhdotLine1a) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    Vec6 printed, missing;
    for (const int j : m.path(i)) {
      printed += J_h(m, i, j) * m.qdd(j)[0];
      for (const int k : m.path(i)) {
        const double rates = m.qd(j)[0] * m.qd(k)[0];
        if (j <= k) printed += bracket(J_h(m, i, j), vJ(m, i, k)) * rates;
        if (k < j) missing += bracket(wJ(m, i, k), J_h(m, i, j)) * rates;
      }
    }
    eq.holds(m.dV<Hybrid>(i), printed + missing);
    eq.holds(m.twist_rate<Hybrid>(i), printed + missing);
    eq.fails(m.dV<Hybrid>(i), printed);
  });
}

// V̇_i = Σ_{j<=i} (J_{i,j} q̈_j + [J_{i,j}, vΔV_{j-1,i}] q̇_j + ad_{ω_{j-1}} J_{i,j} q̇_j), hybrid
TEST(Paper, VhdotLine1b) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    Vec6 printed, missing;
    for (const int j : m.path(i)) {
      printed += J_h(m, i, j) * m.qdd(j)[0] + bracket(J_h(m, i, j), vDeltaV(m, j, i)) * m.qd(j)[0];
      missing += ad_omega(m, m.predecessor(j)) * J_h(m, i, j) * m.qd(j)[0];
    }
    eq.holds(m.dV<Hybrid>(i), printed + missing);
    eq.fails(m.dV<Hybrid>(i), printed);
  });
}

// V̇_i = Σ_{j<=i} (J_{i,j} q̈_j + (ad_{ṙ_{i,j}} + Ad_{r_{i,j}} ad_{ω_j}) ^0X_j^j q̇_j), hybrid
TEST(Paper, VhdotLine2) {
  each_body([](Equation& eq, const Motion& m, int i) {
    Vec6 right;
    for (const int j : m.path(i)) {
      const Vec6 Xqd = Ad(m.C(j).R) * m.Xqd(j);
      right += m.J<Hybrid>(i, j) * m.qdd(j) + (ad_v(dr(m, i, j)) + Ad(r(m, i, j)) * ad_omega(m, j)) * Xqd;
    }
    eq.holds(m.dV<Hybrid>(i), right);
    eq.holds(m.twist_rate<Hybrid>(i), right);
  });
}

// J̈_{i,j} = (ad_{r̈_{i,j}} + 2 ad_{ṙ_{i,j}} ad_{ω_j} + Ad_{r_{i,j}} (ad_{ω̇_j} + ad_{ω_j} ad_{ω_j}))
// ^0X_j^j, hybrid
TEST(Paper, Jhddot) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const HigherOrderMotion<> motion = jerk_motion(m);
    std::vector<TwistRate<Hybrid>> library(m.v().size());
    motion.jacobian_derivative<Hybrid>(i, 2, library);
    for (const int j : m.path(i)) {
      const Mat6 turned = ad_domega(m, j) + ad_omega(m, j) * ad_omega(m, j);
      const Vec6 right =
          (ad_v(ddr(m, i, j)) + 2 * ad_v(dr(m, i, j)) * ad_omega(m, j) + Ad(r(m, i, j)) * turned) * X(m, j);
      eq.holds(ddJ<Hybrid>(m, i, j), right, X(m, j).norm());
      eq.holds(library[velocity(m, j)], right, X(m, j).norm());
    }
  });
}

// V̈_i = Σ_{j<=i} (J_{i,j} q⃛_j + (2 (ad_{ṙ_{i,j}} + Ad_{r_{i,j}} ad_{ω_j}) q̈_j + (ad_{r̈_{i,j}} + 2
// ad_{ṙ_{i,j}} ad_{ω_j} + Ad_{r_{i,j}} (ad_{ω̇_j} + ad_{ω_j} ad_{ω_j})) q̇_j) ^0X_j^j), hybrid
TEST(Paper, Vhddot) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    Vec6 right, printed;
    for (const int j : m.path(i)) {
      const double qd = m.qd(j)[0], qdd = m.qdd(j)[0];
      const Mat6 ad_dr = ad_v(dr(m, i, j)), ad_w_j = ad_omega(m, j), Ad_r = Ad(r(m, i, j));
      const Mat6 linear_part = ad_v(ddr(m, i, j)) + 2 * ad_dr * ad_w_j,
                 turned = ad_domega(m, j) + ad_w_j * ad_w_j;
      right += J_h(m, i, j) * qddd(j) +
               (2 * (ad_dr + Ad_r * ad_w_j) * qdd + (linear_part + Ad_r * turned) * qd) * X(m, j);
      printed += J_h(m, i, j) * qddd(j) +
                 (2 * ad_dr * qdd + linear_part * qd + Ad_r * (2 * ad_w_j * qdd + turned) * qd) * X(m, j);
    }
    eq.holds(ddV<Hybrid>(m, i), right);
    eq.holds(jerk<Hybrid>(m, i), right);
    eq.fails(ddV<Hybrid>(m, i), printed);  // with its brackets balanced where they stand
  });
}

}  // namespace
}  // namespace axode::test::paper
