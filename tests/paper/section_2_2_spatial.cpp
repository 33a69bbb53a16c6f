#include <algorithm>

#include "tests/paper/columns.hpp"

/// Section 2.2: accelerations and partial derivatives, spatial representation. j < i means that joint j is on the path
/// to joint i.
namespace axode::test::paper {
namespace {

Vec6 J(const Motion& m, int j) { return m.J<Spatial>(j, j); }

// ∂J_j / ∂q_k = [J_k, J_j] for k < j, else 0; spatial
TEST(Paper, Jsder) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int j) {
    const Mat6X library = partials_of<Spatial>(m, j, 1);
    const std::vector<int> path = m.path(j);
    for (int k = 1; k <= m.n(); ++k) {
      const bool before = k < j && std::find(path.begin(), path.end(), k) != path.end();
      const Vec6 right = before ? bracket(J(m, k), J(m, j)) : Vec6::Zero().eval();
      const double size = J(m, k).norm() * J(m, j).norm();
      eq.holds(partial_of<Spatial>(m, j, j, std::array{k}), right, size);
      eq.holds(library.col(velocity(m, k) * m.model().nv() + velocity(m, j)), right, size);
    }
  });
}

// V̇_i = Σ_{j<=i} J_j q̈_j + Σ_{k<j<=i} [J_k, J_j] q̇_j q̇_k = Σ_{j<=i} (J_j q̈_j + [V_j, J_j] q̇_j), spatial
TEST(Paper, Vsdottemp) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    Vec6 first = Vec6::Zero(), second = Vec6::Zero();
    for (const int j : m.path(i)) {
      first += J(m, j) * m.qdd(j)[0];
      for (const int k : m.path(j))
        if (k < j) first += bracket(J(m, k), J(m, j)) * m.qd(j)[0] * m.qd(k)[0];
      second += J(m, j) * m.qdd(j)[0] + bracket(m.V<Spatial>(j), J(m, j)) * m.qd(j)[0];
    }
    eq.holds(m.dV<Spatial>(i), first);
    eq.holds(m.dV<Spatial>(i), second);
    eq.holds(m.twist_rate<Spatial>(i), first);
    eq.holds(m.twist_rate<Spatial>(i), second);
  });
}

}  // namespace
}  // namespace axode::test::paper
