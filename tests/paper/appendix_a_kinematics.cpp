#include "tests/paper/equation.hpp"

/// Appendix A: summary of basic kinematic relations. "i - 1" is the predecessor p of body i. If a joint has
/// several screws, X_i q̇_i is the sum of its screws times their rates.
namespace axode::test::paper {
namespace {

// C_i = [[R_i, r_i], [0, 1]]
TEST(Paper, PoseMatrix) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const SE3<> C = m.pose(i);
    const Mat4 matrix = blocks(C.R, C.r, Matrix(1, 3), 1.0);
    Mat4 product = identity(4);
    for (const int j : m.path(i)) product = product * to_matrix(m.C(m.predecessor(j), j));
    eq.holds(to_matrix(C), matrix);
    eq.holds(to_matrix(C), product);
    const Vec3<> p = m.drawn(i).points[0].p;
    eq.holds(matrix * stack(p, 1.0), stack(C * p, 1.0));
  });
}

// C_{i-1,i} = S_{i-1,i} exp(Z_i q_i) S_{i,i}⁻¹ = B_i exp(X_i q_i), B_i = S_{i-1,i} S_{i,i}⁻¹ = C_{i-1,i}(0)
TEST(Paper, RelConf) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Body& b = m.body(i);
    const JointFrames at = m.joint_frames(i);
    const SE3<> C_pi = inverse(m.pose(b.predecessor)) * m.pose(i);
    eq.holds(C_pi, at.S_prev * exp(m.q(i) * at.Z) * inverse(at.S_self));
    eq.holds(C_pi, b.B * exp(m.q(i) * m.X_screw(i)));
    eq.holds(b.B, at.S_prev * inverse(at.S_self));
    eq.holds(b.B, b.S_prev * inverse(b.S_self));
    eq.holds(b.B, inverse(m.pose_at_zero(b.predecessor)) * m.pose_at_zero(i));
  });
}

// C_i = B_1 exp(X_1 q_1) B_2 exp(X_2 q_2) ... B_i exp(X_i q_i)
TEST(Paper, POEX) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    SE3<> C;
    for (const int j : m.path(i)) C = C * m.body(j).B * exp(m.q(j) * m.X_screw(j));
    eq.holds(m.pose(i), C);
    eq.holds(poses_by_body_screws(m.model(), m.q().data())[i], C);
  });
}

// C_i = exp(Y_1 q_1) exp(Y_2 q_2) ... exp(Y_i q_i) A_i
TEST(Paper, POEY) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    SE3<> product;
    for (const int j : m.path(i)) product = product * exp(m.q(j) * m.drawn(j).Y);
    eq.holds(m.pose(i), product * m.body(i).A);
    eq.holds(poses_by_spatial_screws(m.model(), m.q().data())[i], product * m.body(i).A);
  });
}

// Y_i = Ad_{A_i} X_i, X_i = Ad_{S_{i,i}} Z_i; A_i = C_i(0)
TEST(Paper, XY) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    eq.holds(m.drawn(i).Y, Ad(m.body(i).A) * m.X(i));
    eq.holds(m.X(i), Ad(m.joint_frames(i).S_self) * to_matrix(m.joint_frames(i).Z));
    eq.holds(m.body(i).A, m.pose_at_zero(i));
  });
}

// Ad_C = [[R, 0], [r̃ R, R]]; as 4×4 matrices (Ad_C X)^ = C X̂ C⁻¹
TEST(Paper, Ad) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const SE3<> C = m.pose(i);
    const Mat3 R = to_matrix(C.R);
    eq.holds(Ad(C), blocks(R, Mat3(), tilde(C.r) * R, R));
    const Screw<> X = m.X_screw(i);
    eq.holds(hat(axode::Ad(C, X)), to_matrix(C) * hat(X) * to_matrix(C).inverse());
  });
}

// Ad_R = diag(R, R), Ad_r = [[I, 0], [r̃, I]], Ad_C = Ad_r Ad_R
TEST(Paper, AdRr) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const SE3<> C = m.pose(i);
    const Mat3 R = to_matrix(C.R), I = identity(3);
    eq.holds(Ad(C.R), block_diagonal(R, R));
    eq.holds(Ad(C.r), blocks(I, Mat3(), tilde(C.r), I));
    eq.holds(Ad(C), Ad(C.r) * Ad(C.R));
    eq.holds(Ad(C.R), Ad(SE3<>{C.R, {}}));
    eq.holds(Ad(C.r), Ad(SE3<>{{}, C.r}));
  });
}

// V̂^b = [[ω̃^b, v^b], [0, 0]] = C⁻¹ Ċ, V̂^s = [[ω̃^s, v^s], [0, 0]] = Ċ C⁻¹ with ω̃^b = Rᵀ Ṙ, v^b = Rᵀ ṙ,
// ω̃^s = Ṙ Rᵀ, v^s = ṙ + r × ω^s; V^h = (ω^s, ṙ), V^m = (ω^b, ṙ)
TEST(Paper, TwistDefinitions) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat3 R = to_matrix(m.C(i).R), dR = rate(to_matrix(m.C_of_t(i).R));
    const Vec3d r = to_matrix(m.C(i).r), dr = to_matrix(rate(m.C_of_t(i).r));
    const Twist<BodyFixed> V_b = m.twist<BodyFixed>(i);
    const Twist<Spatial> V_s = m.twist<Spatial>(i);
    eq.holds(V_b, m.V<BodyFixed>(i));
    eq.holds(tilde(V_b.w), R.transpose() * dR);
    eq.holds(V_b.v, R.transpose() * dr);
    eq.holds(V_s, m.V<Spatial>(i));
    eq.holds(tilde(V_s.w), dR * R.transpose());
    eq.holds(V_s.v, dr + r.cross(to_matrix(V_s.w)));
    eq.holds(m.twist<Hybrid>(i), stack(to_matrix(V_s.w), dr));
    eq.holds(m.twist<Mixed>(i), stack(to_matrix(V_b.w), dr));
  });
}

// V^h = diag(R, R) V^b = Ad_R V^b
TEST(Paper, VhVb) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat3 R = to_matrix(m.pose(i).R);
    eq.holds(m.V<Hybrid>(i), block_diagonal(R, R) * m.V<BodyFixed>(i));
    eq.holds(m.V<Hybrid>(i), Ad(m.pose(i).R) * m.V<BodyFixed>(i));
    eq.holds(m.V<Hybrid>(i), change<Hybrid>(m.pose(i), m.twist<BodyFixed>(i)));
  });
}

// V^s = Ad_C V^b = Ad_C Ad_R⁻¹ V^h = Ad_r V^h
TEST(Paper, VsVb) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const SE3<> C = m.pose(i);
    eq.holds(m.V<Spatial>(i), Ad(C) * m.V<BodyFixed>(i));
    eq.holds(m.V<Spatial>(i), Ad(C) * Ad(C.R).inverse() * m.V<Hybrid>(i));
    eq.holds(m.V<Spatial>(i), Ad(C.r) * m.V<Hybrid>(i));
    eq.holds(m.V<Spatial>(i), change<Spatial>(C, m.twist<BodyFixed>(i)));
    eq.holds(m.V<Spatial>(i), change<Spatial>(C, m.twist<Hybrid>(i)));
  });
}

// V^m = diag(I, R) V^b = diag(Rᵀ, I) V^h = [[Rᵀ, 0], [-r̃, I]] V^s
TEST(Paper, Vmbhs) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat3 R = to_matrix(m.pose(i).R), I = identity(3);
    const Vec6 V_m = m.V<Mixed>(i);
    eq.holds(V_m, block_diagonal(I, R) * m.V<BodyFixed>(i));
    eq.holds(V_m, block_diagonal(R.transpose(), I) * m.V<Hybrid>(i));
    eq.holds(V_m, blocks(R.transpose(), Mat3(), -tilde(m.pose(i).r), I) * m.V<Spatial>(i));
    eq.holds(V_m, change<Mixed>(m.pose(i), m.twist<BodyFixed>(i)));
    eq.holds(V_m, change<Mixed>(m.pose(i), m.twist<Hybrid>(i)));
    eq.holds(V_m, change<Mixed>(m.pose(i), m.twist<Spatial>(i)));
  });
}

// J_j^s = Ad_{r_j} ^0X_j^j. Printed: Y_j = Ad_{r_i} ^0X_j^j, constant on the left and moving on the right.
TEST(Paper, YsXhFirst) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int j) {
    const Vec6 X = Ad(m.pose(j).R) * m.X(j);  // ^0X_j^j
    eq.holds(m.J<Spatial>(j, j), Ad(m.pose(j).r) * X);
    eq.holds(m.joint_screw(j), Ad(m.pose(j).r) * X);
    eq.fails(m.drawn(j).Y, Ad(m.pose(j).r) * X);
  });
}

// ^0X_j^j = Ad_{R_j} X_j
TEST(Paper, YsXhSecond) {
  each_body([](Equation& eq, const Motion& m, int j) {
    eq.holds(m.J<Hybrid>(j, j), Ad(m.pose(j).R) * m.X(j));
    eq.holds(m.J<Hybrid>(j, j) * m.qd(j), m.push_Xqd<Hybrid>(j));
  });
}

/// The recursion of twists as the library computes it, with its table of representations.
template <class Rep> Twist<Rep> twist_from_predecessor(const Motion& m, int i) {
  return m.link<Rep>(i).down(m.twist<Rep>(m.predecessor(i))) + m.push_Xqd<Rep>(i);
}

// V_i^b = Ad_{C_{i,i-1}} V_{i-1}^b + X_i q̇_i
TEST(Paper, VbRec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    eq.holds(m.V<BodyFixed>(i), Ad(inverse(m.pose(i)) * m.pose(p)) * m.V<BodyFixed>(p) + m.Xqd(i));
    eq.holds(m.V<BodyFixed>(i), twist_from_predecessor<BodyFixed>(m, i));
  });
}

// V_i^s = V_{i-1}^s + J_i^s q̇_i
TEST(Paper, Vsrec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    eq.holds(m.V<Spatial>(i), m.V<Spatial>(m.predecessor(i)) + Ad(m.pose(i)) * m.Xqd(i));
    eq.holds(m.V<Spatial>(i), twist_from_predecessor<Spatial>(m, i));
  });
}

// V_i^h = Ad_{r_{i,i-1}} V_{i-1}^h + ^0X_i^i q̇_i
TEST(Paper, VhRec) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    const Vec3<> r_ip = m.pose(p).r - m.pose(i).r;
    eq.holds(m.V<Hybrid>(i), Ad(r_ip) * m.V<Hybrid>(p) + Ad(m.pose(i).R) * m.Xqd(i));
    eq.holds(m.V<Hybrid>(i), twist_from_predecessor<Hybrid>(m, i));
  });
}

}  // namespace
}  // namespace axode::test::paper
