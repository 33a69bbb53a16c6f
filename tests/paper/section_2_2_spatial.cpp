#include <algorithm>

#include "tests/paper/columns.hpp"

/// Section 2.2: accelerations and partial derivatives, spatial representation. j < i means that joint j is on
/// the path to joint i.
namespace axode::test::paper {
namespace {

Vec6 J_s(const Motion& m, int j) { return m.J<Spatial>(j, j); }

// ∂J_j / ∂q_k = [J_k, J_j] for k < j, else 0; spatial
TEST(Paper, Jsder) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int j) {
    const Matrix library = partials_of<Spatial>(m, j, 1);
    const std::vector<int> path = m.path(j);
    for (int k = 1; k <= m.n(); ++k) {
      const bool before = k < j && std::find(path.begin(), path.end(), k) != path.end();
      const Vec6 right = before ? bracket(J_s(m, k), J_s(m, j)) : Vec6();
      const double size = J_s(m, k).norm() * J_s(m, j).norm();
      eq.holds(partial_of<Spatial>(m, j, j, {k}), right, size);
      eq.holds(library.col(velocity(m, k) * m.model().nv() + velocity(m, j)), right, size);
    }
  });
}

// V̇_i = Σ_{j<=i} J_j q̈_j + Σ_{k<j<=i} [J_k, J_j] q̇_j q̇_k = Σ_{j<=i} (J_j q̈_j + [V_j, J_j] q̇_j), spatial
TEST(Paper, Vsdottemp) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    Vec6 first, second;
    for (const int j : m.path(i)) {
      first += J_s(m, j) * m.qdd(j)[0];
      for (const int k : m.path(j))
        if (k < j) first += bracket(J_s(m, k), J_s(m, j)) * m.qd(j)[0] * m.qd(k)[0];
      second += J_s(m, j) * m.qdd(j)[0] + bracket(m.V<Spatial>(j), J_s(m, j)) * m.qd(j)[0];
    }
    eq.holds(m.dV<Spatial>(i), first);
    eq.holds(m.dV<Spatial>(i), second);
    eq.holds(m.twist_rate<Spatial>(i), first);
    eq.holds(m.twist_rate<Spatial>(i), second);
  });
}

// J̇_j = Σ_{k<=j} [J_k, J_j] q̇_k = [Σ_{k<=j} J_k q̇_k, J_j] = [V_j, J_j], spatial
TEST(Paper, TimeDerJs) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int j) {
    Vec6 first, inner, printed;
    for (const int k : m.path(j)) {
      first += bracket(J_s(m, k), J_s(m, j)) * m.qd(k)[0];
      inner += J_s(m, k) * m.qd(k)[0];
      printed += J_s(m, k);
    }
    const Vec6 left = dJ<Spatial>(m, j, j);
    const double size = J_s(m, j).norm();
    eq.holds(left, first, size);
    eq.holds(left, bracket(inner, J_s(m, j)), size);
    eq.holds(left, bracket(m.V<Spatial>(j), J_s(m, j)), size);
    eq.holds(left, library_dJ<Spatial>(m, j, j), size);
    eq.fails(left, bracket(printed, J_s(m, j)) * m.qd(j)[0]);  // q̇_k with a free index k, read as q̇_j
  });
}

// V̇ = J q̈ + L b diag(J_1, ..., J_n) q̇ of all bodies, spatial; L has identities where A has blocks
TEST(Paper, VsdotMat) {
  each_system([](Equation& eq, const Motion& m) {
    const MatricesOfSystem s = system_matrices<Spatial>(m.model(), m.q());
    const Matrix b = b_matrix(m.model(), to_eigen_vector(system_V<Spatial>(m)));
    Matrix diagonal(6 * m.n(), m.model().nv());
    for (int i = 1; i <= m.n(); ++i) diagonal.set_block(6 * (i - 1), velocity(m, i), m.J<Spatial>(i, i));
    const Matrix right =
        system_jacobian<Spatial>(m) * as_vector(m.a()) + s.A * b * diagonal * as_vector(m.v());
    eq.holds(s.X, diagonal);
    eq.holds(system_dV<Spatial>(m), right);
    eq.holds(system_acceleration<Spatial>(m.model(), m.q(), m.v(), m.a()), right);
  });
}

// b(V) = diag(ad_{V_1}, ..., ad_{V_n}), spatial
TEST(Paper, Bs) {
  each_system([](Equation& eq, const Motion& m) {
    eq.holds(b_matrix(m.model(), to_eigen_vector(system_V<Spatial>(m))),
             block_diagonal_of(m, [&](int i) { return ad(to_matrix(m.twist<Spatial>(i))); }));
  });
}

// ∂²J_i/∂q_k∂q_j = [J_k, [J_j, J_i]] for k < j < i, [J_j, [J_k, J_i]] for j <= k < i, spatial
TEST(Paper, Jsder2) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Matrix library = partials_of<Spatial>(m, i, 2);
    const int nv = m.model().nv();
    for (const int k : m.path(i))
      for (const int j : m.path(i)) {
        Vec6 right;
        if (k < j && j < i) right = bracket(J_s(m, k), bracket(J_s(m, j), J_s(m, i)));
        if (j <= k && k < i) right = bracket(J_s(m, j), bracket(J_s(m, k), J_s(m, i)));
        const double size = J_s(m, i).norm();
        eq.holds(partial_of<Spatial>(m, i, i, {k, j}), right, size);
        eq.holds(library.col((velocity(m, j) * nv + velocity(m, k)) * nv + velocity(m, i)), right, size);
      }
  });
}

/// Σ_{k<=j} J_k q̈_k.
Vec6 accelerated(const Motion& m, int j) {
  Vec6 sum;
  for (const int k : m.path(j)) sum += J_s(m, k) * m.qdd(k)[0];
  return sum;
}

// V̈_i = Σ_{j<=i} (J_j q⃛_j + 2 [V_j, J_j] q̈_j + Σ_{k<=j} [J_k q̈_k, J_j] q̇_j + [V_{j-1} + V_j - V_i, [V_j,
// J_j]] q̇_j), spatial
TEST(Paper, VsddotForm1) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const auto V = [&](int j) { return m.V<Spatial>(j); };
    Vec6 right;
    for (const int j : m.path(i)) {
      const Vec6 J_j = J_s(m, j), dJ_j = bracket(V(j), J_j);
      right += J_j * qddd(j) + 2 * dJ_j * m.qdd(j)[0] + bracket(accelerated(m, j), J_j) * m.qd(j)[0] +
               bracket(V(m.predecessor(j)) + V(j) - V(i), dJ_j) * m.qd(j)[0];
    }
    eq.holds(ddV<Spatial>(m, i), right);
    eq.holds(jerk<Spatial>(m, i), right);
  });
}

// V̈_i = Σ_{j<=i} (J_j q⃛_j + [[V_j, J_j], V_i - 2 V_j] q̇_j + [Σ_{k<=j} J_k q̈_k + [V_j, J_j] q̇_j, J_j]
// q̇_j + 2 [V_j, J_j] q̈_j)
TEST(Paper, VsddotForm2) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const auto V = [&](int j) { return m.V<Spatial>(j); };
    Vec6 right;
    for (const int j : m.path(i)) {
      const Vec6 J_j = J_s(m, j), dJ_j = bracket(V(j), J_j);
      right += J_j * qddd(j) + bracket(dJ_j, V(i) - 2 * V(j)) * m.qd(j)[0] +
               bracket(accelerated(m, j) + dJ_j * m.qd(j)[0], J_j) * m.qd(j)[0] + 2 * dJ_j * m.qdd(j)[0];
    }
    eq.holds(ddV<Spatial>(m, i), right);
    eq.holds(jerk<Spatial>(m, i), right);
  });
}

/// [J_βν, ... [J_β1, J_i]] for βν <= ... <= β1 < i, else 0; β is α from the outermost to the innermost joint.
Vec6 nested(const Motion& m, int i, std::vector<int> alpha) {
  std::sort(alpha.rbegin(), alpha.rend());
  Vec6 product = J_s(m, i);
  for (const int beta : alpha) product = beta >= i ? Vec6() : bracket(J_s(m, beta), product);
  return product;
}

// ∂^ν J_i/∂q_α1...∂q_αν = [J_βν, ... [J_β1, J_i]] = ad_{J_βν} ... ad_{J_β1} J_i = [J_βν, ∂^(ν-1)
// J_i/∂q_β1...∂q_β(ν-1)] for βν <= ... <= β1 < i, else 0; spatial
TEST(Paper, Nthorder) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Matrix library = partials_of<Spatial>(m, i, 3);
    const int nv = m.model().nv();
    const double size = J_s(m, i).norm();
    for (const int a : m.path(i)) {
      eq.holds(partial_of<Spatial>(m, i, i, {a}), nested(m, i, {a}), size);
      for (const int b : m.path(i)) {
        eq.holds(partial_of<Spatial>(m, i, i, {a, b}), nested(m, i, {a, b}), size);
        for (const int c : m.path(i)) {
          const Vec6 left = partial_of<Spatial>(m, i, i, {a, b, c});
          eq.holds(left, nested(m, i, {a, b, c}), size);
          const int at = ((velocity(m, c) * nv + velocity(m, b)) * nv + velocity(m, a)) * nv + velocity(m, i);
          eq.holds(library.col(at), left, size);
          if (c <= b && b <= a && a < i) {
            eq.holds(left, ad(J_s(m, c)) * ad(J_s(m, b)) * ad(J_s(m, a)) * J_s(m, i), size);
            eq.holds(left, bracket(J_s(m, c), partial_of<Spatial>(m, i, i, {a, b})), size);
          }
        }
      }
    }
  });
}

}  // namespace
}  // namespace axode::test::paper
