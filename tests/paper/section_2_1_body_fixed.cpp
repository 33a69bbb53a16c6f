#include "tests/paper/columns.hpp"

/// Section 2.1: accelerations and partial derivatives, body-fixed representation. j < i means that joint j is on the
/// path to joint i.
namespace axode::test::paper {
namespace {

Vec6 J(const Motion& m, int i, int j) { return m.J<BodyFixed>(i, j); }

// ∂J_{i,j} / ∂q_k = [J_{i,j}, J_{i,k}] for j < k <= i, else 0; body-fixed
TEST(Paper, Der1) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    const Mat6X library = partials_of<BodyFixed>(m, i, 1);
    for (const int j : m.path(i))
      for (int k = 1; k <= m.n(); ++k) {
        const Vec6 J_k = J(m, i, k);  // 0 unless k <= i
        const Vec6 right = j < k ? bracket(J(m, i, j), J_k) : Vec6::Zero().eval();
        const double size = J(m, i, j).norm();
        eq.holds(partial_of<BodyFixed>(m, i, j, std::array{k}), right, size);
        eq.holds(library.col(velocity(m, k) * m.model().nv() + velocity(m, j)), right, size);
      }
  });
}

// V̇_i = Σ_{j<=i} J_{i,j} q̈_j + Σ_{j<k<=i} [J_{i,j}, J_{i,k}] q̇_j q̇_k, body-fixed
TEST(Paper, Vbdot) {
  each_body_with_one_screw([](Equation& eq, const Motion& m, int i) {
    Vec6 right = Vec6::Zero();
    for (const int j : m.path(i)) {
      right += J(m, i, j) * m.qdd(j)[0];
      for (const int k : m.path(i))
        if (j < k) right += bracket(J(m, i, j), J(m, i, k)) * m.qd(j)[0] * m.qd(k)[0];
    }
    eq.holds(m.dV<BodyFixed>(i), right);
    eq.holds(m.twist_rate<BodyFixed>(i), right);
  });
}

// V̇_i = J_i q̈ + J̇_i q̇, body-fixed
TEST(Paper, AccelerationByJacobianRate) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Eigen::Map<const Eigen::VectorXd> qd(m.v().data(), m.model().nv()), qdd(m.a().data(), m.model().nv());
    eq.holds(m.dV<BodyFixed>(i), jacobian_of<BodyFixed>(m, i) * qdd + jacobian_rate<BodyFixed>(m, i) * qd);
  });
}

}  // namespace
}  // namespace axode::test::paper
