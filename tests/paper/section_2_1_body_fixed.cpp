#include <algorithm>

#include "tests/paper/columns.hpp"

/// Section 2.1: accelerations and partial derivatives, body-fixed representation. j < i means that joint j is
/// on the path to joint i.
namespace axode::test::paper {
namespace {

Vec6 J_b(const Motion& m, int i, int j) { return m.J<BodyFixed>(i, j); }
Mat4 J_hat(const Motion& m, int i, int j) { return hat(from_six(J_b(m, i, j))); }
Mat4 C_of(const Motion& m, int i, int j) { return to_matrix(m.C(i, j)); }  // C_i⁻¹ C_j
Mat4 A_of(const Motion& m, int i) { return to_matrix(m.body(i).A); }
Mat4 Y_hat(const Motion& m, int i) { return hat(m.drawn(i).Y); }
/// A_i⁻¹ Ŷ_i A_i
Mat4 X_by_Y(const Motion& m, int i) { return A_of(m, i).inverse() * Y_hat(m, i) * A_of(m, i); }

/// check(j, k) for all j < k <= i.
template <class Check> void each_pair_before(const Motion& m, int i, const Check& check) {
  for (const int j : m.path(i))
    for (const int k : m.path(i))
      if (j < k) check(j, k);
}

// V̇_i = Σ_{j<=i} J_{i,j} q̈_j + Σ_{j<=i} Σ_{k<=i} ∂J_{i,j}/∂q_k q̇_j q̇_k, body-fixed
TEST(Paper, AccelerationByPartials) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Matrix library = partials_of<BodyFixed>(m, i, 1);
    Vec6 right, by_library;
    for (const int j : m.path(i)) {
      right += J_b(m, i, j) * m.qdd(j)[0], by_library += J_b(m, i, j) * m.qdd(j)[0];
      for (const int k : m.path(i)) {
        const double rates = m.qd(j)[0] * m.qd(k)[0];
        right += partial_of<BodyFixed>(m, i, j, {k}) * rates;
        by_library += library.col(velocity(m, k) * m.model().nv() + velocity(m, j)) * rates;
      }
    }
    eq.holds(m.dV<BodyFixed>(i), right);
    eq.holds(m.dV<BodyFixed>(i), by_library);
  });
}

// ∂Ĵ_{i,j}/∂q_k = ∂(C_i⁻¹ C_j)/∂q_k A_j⁻¹ Ŷ_j A_j C_j⁻¹ C_i + C_i⁻¹ C_j A_j⁻¹ Ŷ_j A_j ∂(C_j⁻¹ C_i)/∂q_k
TEST(Paper, DerTemp) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    each_pair_before(m, i, [&](int j, int k) {
      const Mat4 left = hat(from_six(library_partial<BodyFixed>(m, i, j, k)));
      const Mat4 first = relative_pose_partial(m, i, j, k) * X_by_Y(m, j),
                 second = C_of(m, i, j) * X_by_Y(m, j) * relative_pose_partial(m, j, i, k);
      eq.holds(left, first * C_of(m, j, i) + second);
      eq.fails(left, first * C_of(m, i, j) + second);
    });
  });
}

/// exp(-Ŷ_i q_i) ... exp(-Ŷ_{j+1} q_{j+1}), along the path.
Mat4 product_back(const Motion& m, int i, int j) {
  Mat4 product = identity(4);
  for (int k = i; k != j; k = m.predecessor(k)) product *= to_matrix(exp(-m.q(k) * m.drawn(k).Y));
  return product;
}

// C_i⁻¹ C_j = A_i⁻¹ exp(-Ŷ_i q_i) ... exp(-Ŷ_{j+1} q_{j+1}) A_j, its partial
// = -A_i⁻¹ exp(-Ŷ_i q_i) ... exp(-Ŷ_{k+1} q_{k+1}) Ŷ_k exp(-Ŷ_k q_k) ... exp(-Ŷ_{j+1} q_{j+1}) A_j for j < k
// <= i
TEST(Paper, RelativePosePartial) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    each_pair_before(m, i, [&](int j, int k) {
      eq.holds(C_of(m, i, j), A_of(m, i).inverse() * product_back(m, i, j) * A_of(m, j));
      eq.holds(relative_pose_partial(m, i, j, k), -A_of(m, i).inverse() * product_back(m, i, k) *
                                                      Y_hat(m, k) * product_back(m, k, j) * A_of(m, j));
    });
  });
}

// ∂(C_i⁻¹ C_j)/∂q_k = -C_i⁻¹ C_k A_k⁻¹ Ŷ_k A_k C_k⁻¹ C_j = -C_i⁻¹ C_k A_k⁻¹ Ŷ_k A_k C_k⁻¹ C_i C_i⁻¹ C_j for j
// < k <= i
TEST(Paper, RelativePosePartialContracted) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    each_pair_before(m, i, [&](int j, int k) {
      const Mat4 left = relative_pose_partial(m, i, j, k);
      eq.holds(left, -C_of(m, i, k) * X_by_Y(m, k) * C_of(m, k, j));
      eq.holds(left, -C_of(m, i, k) * X_by_Y(m, k) * C_of(m, k, i) * C_of(m, i, j));
    });
  });
}

// ∂(C_i⁻¹ C_j)/∂q_k = -Ĵ_{i,k} C_i⁻¹ C_j for j < k <= i, 0 for k <= j
TEST(Paper, RelativePosePartialFinal) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    each_pair_before(m, i, [&](int j, int k) {
      eq.holds(relative_pose_partial(m, i, j, k), -J_hat(m, i, k) * C_of(m, i, j));
      eq.holds(relative_pose_partial(m, i, k, j), Mat4(), 1);
    });
    for (const int j : m.path(i)) {
      eq.holds(relative_pose_partial(m, i, j, j), Mat4(), 1);
      eq.fails(relative_pose_partial(m, i, j, j), -J_hat(m, i, j) * C_of(m, i, j));
    }
  });
}

// ∂(C_j⁻¹ C_i)/∂q_k = C_j⁻¹ C_i Ĵ_{i,k} for j < k <= i
TEST(Paper, InverseRelativePosePartial) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    each_pair_before(m, i, [&](int j, int k) {
      eq.holds(relative_pose_partial(m, j, i, k), C_of(m, j, i) * J_hat(m, i, k));
      eq.fails(relative_pose_partial(m, j, i, k), C_of(m, j, i) * J_hat(m, i, j));
    });
  });
}

// ∂Ĵ_{i,j}/∂q_k = Ĵ_{i,j} Ĵ_{i,k} - Ĵ_{i,k} Ĵ_{i,j} for j < k <= i
TEST(Paper, DJhatCommutator) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    each_pair_before(m, i, [&](int j, int k) {
      const Mat4 left = hat(from_six(library_partial<BodyFixed>(m, i, j, k)));
      eq.holds(left, J_hat(m, i, j) * J_hat(m, i, k) - J_hat(m, i, k) * J_hat(m, i, j), 1);
    });
  });
}

// ∂J_{i,j} / ∂q_k = [J_{i,j}, J_{i,k}] for j < k <= i, else 0; body-fixed
TEST(Paper, Der1) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Matrix library = partials_of<BodyFixed>(m, i, 1);
    for (const int j : m.path(i))
      for (int k = 1; k <= m.n(); ++k) {
        const Vec6 J_k = J_b(m, i, k);  // 0 unless k <= i
        const Vec6 right = j < k ? bracket(J_b(m, i, j), J_k) : Vec6();
        const double size = J_b(m, i, j).norm();
        eq.holds(partial_of<BodyFixed>(m, i, j, {k}), right, size);
        eq.holds(library.col(velocity(m, k) * m.model().nv() + velocity(m, j)), right, size);
      }
  });
}

// V̇_i = Σ_{j<=i} J_{i,j} q̈_j + Σ_{j<k<=i} [J_{i,j}, J_{i,k}] q̇_j q̇_k, body-fixed
TEST(Paper, Vbdot) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    Vec6 right;
    for (const int j : m.path(i)) {
      right += J_b(m, i, j) * m.qdd(j)[0];
      for (const int k : m.path(i))
        if (j < k) right += bracket(J_b(m, i, j), J_b(m, i, k)) * m.qd(j)[0] * m.qd(k)[0];
    }
    eq.holds(m.dV<BodyFixed>(i), right);
    eq.holds(m.twist_rate<BodyFixed>(i), right);
  });
}

// V̇_i = J_i q̈ + J̇_i q̇, body-fixed
TEST(Paper, AccelerationByJacobianRate) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Matrix qd = as_vector(m.v()), qdd = as_vector(m.a());
    eq.holds(m.dV<BodyFixed>(i), jacobian_of<BodyFixed>(m, i) * qdd + jacobian_rate<BodyFixed>(m, i) * qd);
  });
}

// ∂J_{i,j}/∂q_k = [J_{i,j}, J_{i,k}] = Ad_{C_{i,k}} [J_{k,j}, X_k] = -Ad_{C_{i,k}} ad_{X_k} J_{k,j} for j < k
// <= i
TEST(Paper, DJbij) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    each_pair_before(m, i, [&](int j, int k) {
      const Vec6 left = partial_of<BodyFixed>(m, i, j, {k}), X_k = m.X(k);
      const double size = J_b(m, i, j).norm();
      eq.holds(left, library_partial<BodyFixed>(m, i, j, k), size);
      eq.holds(left, bracket(J_b(m, i, j), J_b(m, i, k)), size);
      eq.holds(left, Ad(m.C(i, k)) * bracket(J_b(m, k, j), X_k), size);
      eq.holds(left, -Ad(m.C(i, k)) * ad(X_k) * J_b(m, k, j), size);
    });
  });
}

// J̇_{i,j} = Σ_{j<k<=i} [J_{i,j}, J_{i,k}] q̇_k = -Σ_{j<k<=i} Ad_{C_{i,k}} ad_{X_k} J_{k,j} q̇_k, body-fixed
TEST(Paper, JbijDot) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    for (const int j : m.path(i)) {
      Vec6 first, second;
      for (const int k : m.path(i))
        if (j < k) {
          first += bracket(J_b(m, i, j), J_b(m, i, k)) * m.qd(k)[0];
          second -= Ad(m.C(i, k)) * ad(Vec6(m.X(k))) * J_b(m, k, j) * m.qd(k)[0];
        }
      const Vec6 left = dJ<BodyFixed>(m, i, j);
      const double size = J_b(m, i, j).norm();
      eq.holds(left, first, size);
      eq.holds(left, second, size);
      eq.holds(left, library_dJ<BodyFixed>(m, i, j), size);
    }
  });
}

// J̇ = -A a A X = -A a J of all bodies, body-fixed
TEST(Paper, JbDotMatrix) {
  each_system_with_one_screw_joints([](Equation& eq, const Motion& m) {
    const MatricesOfSystem s = system_matrices<BodyFixed>(m.model(), m.q());
    const Matrix a = a_matrix(m.model(), m.v()), J_all = system_jacobian<BodyFixed>(m);
    Matrix left(J_all.rows(), J_all.cols());
    for (int i = 1; i <= m.n(); ++i)
      for (const int j : m.path(i)) left.set_block(6 * (i - 1), velocity(m, j), dJ<BodyFixed>(m, i, j));
    eq.holds(left, -(s.A * a * s.A * s.X));
    eq.holds(left, -(s.A * a * J_all));
  });
}

// a(q̇) = diag(q̇_1 ad_{X_1}, ..., q̇_n ad_{X_n}), body-fixed
TEST(Paper, Ab) {
  each_system([](Equation& eq, const Motion& m) {
    eq.holds(a_matrix(m.model(), m.v()), block_diagonal_of(m, [&](int i) { return ad(m.Xqd(i)); }));
  });
}

// V̇ = J q̈ - A a J q̇ = J q̈ - A a V of all bodies, body-fixed
TEST(Paper, VbdotMat) {
  each_system_with_one_screw_joints([](Equation& eq, const Motion& m) {
    const MatricesOfSystem s = system_matrices<BodyFixed>(m.model(), m.q());
    const Matrix a = a_matrix(m.model(), m.v()), J_all = system_jacobian<BodyFixed>(m);
    eq.holds(system_dV<BodyFixed>(m), J_all * as_vector(m.a()) - s.A * a * J_all * as_vector(m.v()));
    eq.holds(system_dV<BodyFixed>(m), J_all * as_vector(m.a()) - s.A * a * system_V<BodyFixed>(m));
    eq.holds(system_dV<BodyFixed>(m), system_acceleration<BodyFixed>(m.model(), m.q(), m.v(), m.a()));
  });
}

// q̈ = (Xᵀ X)⁻¹ Xᵀ ((I - D) V̇ + a V) of all bodies, body-fixed
TEST(Paper, Solqddot1) {
  each_system_with_one_screw_joints([](Equation& eq, const Motion& m) {
    const MatricesOfSystem s = system_matrices<BodyFixed>(m.model(), m.q());
    const Matrix a = a_matrix(m.model(), m.v()), X = s.X, XtX = X.transpose() * X;
    const Matrix V = system_V<BodyFixed>(m), dV = system_dV<BodyFixed>(m);
    eq.holds(as_vector(m.a()), XtX.inverse() * X.transpose() * (dV - s.D * dV + a * V));
    eq.holds(as_vector(m.a()), joint_accelerations_of(m));
  });
}

// q̈_i = X_iᵀ (V̇_i - Ad_{C_{i,i-1}} V̇_{i-1} + q̇_i [X_i, V_i]) / ‖X_i‖², body-fixed
TEST(Paper, SolqddotComponents) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const int p = m.predecessor(i);
    const Vec6 X = m.X(i);
    const Vec6 moved =
        m.dV<BodyFixed>(i) - Ad(m.C(i, p)) * m.dV<BodyFixed>(p) + m.qd(i)[0] * bracket(X, m.V<BodyFixed>(i));
    eq.holds(m.qdd(i)[0], X.dot(moved) / X.squared_norm());
    eq.holds(m.qdd(i)[0], joint_accelerations_of(m)[velocity(m, i)]);
  });
}

/// [...[[J_{i,j}, J_{i,β1}], J_{i,β2}], ...] for j < β1 <= β2 <= ..., else 0; β is the ordered α.
Vec6 nested(const Motion& m, int i, int j, std::vector<int> alpha) {
  std::sort(alpha.begin(), alpha.end());
  Vec6 product = J_b(m, i, j);
  for (const int beta : alpha) product = beta <= j ? Vec6() : bracket(product, J_b(m, i, beta));
  return product;
}

// ∂²J_{i,j}/∂q_k∂q_r = [[J_{i,j}, J_{i,k}], J_{i,r}] for j < k <= r <= i, [[J_{i,j}, J_{i,r}], J_{i,k}] for j
// < r < k <= i, else 0; body-fixed
TEST(Paper, Der2Jb) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Matrix library = partials_of<BodyFixed>(m, i, 2);
    const int nv = m.model().nv();
    for (const int j : m.path(i))
      for (int k = 1; k <= m.n(); ++k)
        for (int r = 1; r <= m.n(); ++r) {
          const Vec6 J_ij = J_b(m, i, j), J_ik = J_b(m, i, k), J_ir = J_b(m, i, r);  // 0 off the path
          Vec6 right;
          if (j < k && k <= r) right = bracket(bracket(J_ij, J_ik), J_ir);
          if (j < r && r < k) right = bracket(bracket(J_ij, J_ir), J_ik);
          const double size = J_ij.norm();
          eq.holds(partial_of<BodyFixed>(m, i, j, {k, r}), right, size);
          eq.holds(library.col((velocity(m, r) * nv + velocity(m, k)) * nv + velocity(m, j)), right, size);
        }
  });
}

// V̈_i = Σ_{j<=i} J_{i,j} q⃛_j + 2 Σ_{j<k<=i} [J_{i,j}, J_{i,k}] q̈_j q̇_k + Σ_{j<k<=i} [J_{i,j}, J_{i,k}]
// q̇_j q̈_k
//       + 2 Σ_{j<k<r<=i} [[J_{i,j}, J_{i,k}], J_{i,r}] q̇_j q̇_k q̇_r + Σ_{j<k<=i} [[J_{i,j}, J_{i,k}], J_{i,k}] q̇_j q̇_k²
TEST(Paper, Vbddot) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    Vec6 common, cubic, diagonal;
    for (const int j : m.path(i)) common += J_b(m, i, j) * qddd(j);
    each_pair_before(m, i, [&](int j, int k) {
      const Vec6 J_jk = bracket(J_b(m, i, j), J_b(m, i, k));
      common += J_jk * (2 * m.qdd(j)[0] * m.qd(k)[0] + m.qd(j)[0] * m.qdd(k)[0]);
      for (const int r : m.path(i))
        if (k < r) cubic += 2 * bracket(J_jk, J_b(m, i, r)) * m.qd(j)[0] * m.qd(k)[0] * m.qd(r)[0];
      diagonal += bracket(J_jk, J_b(m, i, k)) * m.qd(j)[0] * m.qd(k)[0] * m.qd(k)[0];
    });
    eq.holds(ddV<BodyFixed>(m, i), common + cubic + diagonal);
    eq.holds(jerk<BodyFixed>(m, i), ddV<BodyFixed>(m, i));
    eq.fails(ddV<BodyFixed>(m, i), common + cubic + 2 * diagonal);
  });
}

// ∂^ν J_{i,j}/∂q_α1...∂q_αν = [...[[J_{i,j}, J_{i,β1}], J_{i,β2}], ..., J_{i,βν}] for j < β1 <= ... <= βν <=
// i, else 0
TEST(Paper, NthorderBody) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Matrix library = partials_of<BodyFixed>(m, i, 3);
    const int nv = m.model().nv();
    for (const int j : m.path(i)) {
      const double size = J_b(m, i, j).norm();
      for (const int a : m.path(i)) {
        eq.holds(partial_of<BodyFixed>(m, i, j, {a}), nested(m, i, j, {a}), size);
        for (const int b : m.path(i)) {
          eq.holds(partial_of<BodyFixed>(m, i, j, {a, b}), nested(m, i, j, {a, b}), size);
          for (const int c : m.path(i)) {
            const Vec6 right = nested(m, i, j, {a, b, c});
            eq.holds(partial_of<BodyFixed>(m, i, j, {a, b, c}), right, size);
            const int at =
                ((velocity(m, c) * nv + velocity(m, b)) * nv + velocity(m, a)) * nv + velocity(m, j);
            eq.holds(library.col(at), right, size);
          }
        }
      }
    }
  });
}

}  // namespace
}  // namespace axode::test::paper
