#include <algorithm>

#include "axode/dynamics/closed_form/closed_form.hpp"
#include "axode/dynamics/momentum/spatial_momentum_form.hpp"
#include "tests/paper/energy.hpp"

/// Section 5.1: the projected Newton-Euler equations of all bodies, and the general form of the equations of
/// motion.
namespace axode::test::paper {
namespace {

/// The drive forces by projection of the Newton-Euler equations, with the loads of the motion.
Matrix by_projection(const Motion& m) {
  return closed_form::projection_equations<BodyFixed>(m.model(), m.q(), m.v(), m.a(),
                                                      {.wrenches = m.loads()});
}

// M q̈ + C q̇ = Q
TEST(Paper, EOM) {
  each_system([](Equation& eq, const Motion& m) {
    const int n = m.model().nv();
    Workspace<> workspace(m.model());
    Matrix M(n, n), C(n, n);  // row by row: transposed
    mass_matrix(m.model(), workspace, m.q(), M.entries());
    coriolis_matrix(m.model(), workspace, m.q(), m.v(), CoriolisForm::christoffel, C.entries());
    eq.holds(M * as_vector(m.a()) + C.transpose() * as_vector(m.v()), generalised_forces(m));
  });
}

// M_i V̇_i - ad_{V_i}ᵀ M_i V_i - W_i^app - W_i^c = 0 for each body, body-fixed; what the joints transmit is
// W^c and the drive
TEST(Paper, NEBodyWithConstraintWrench) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 M = to_matrix(m.M(i));
    const Vec6 V = m.V<BodyFixed>(i);
    Vec6 joints = to_matrix(m.joint_wrench<BodyFixed>(i));
    for (const int k : m.children(i))
      joints -= Ad(m.C(k, i)).transpose() * to_matrix(m.joint_wrench<BodyFixed>(k));
    const Vec6 inertia = M * m.dV<BodyFixed>(i) - ad(V).transpose() * M * V;
    eq.holds(inertia - m.W_app<BodyFixed>(i), joints);
    eq.holds(inertia, m.W<BodyFixed>(i));
    const Vec6 drive_and_reaction = to_matrix(m.joint_wrench<BodyFixed>(i));
    eq.holds(m.X(i).transpose() * drive_and_reaction, m.joint_force<BodyFixed>(i), drive_and_reaction.norm());
  });
}

/// The drive wrenches of joint i and of the joints behind it, on body i.
Vec6 drive_wrench(const Motion& m, int i) {
  const auto own = [&](int k) -> Vec6 {  // in the span of the joint's own screws
    const Matrix X = m.X(k);
    return X * (X.transpose() * X).inverse() * m.joint_force<BodyFixed>(k);
  };
  Vec6 W = own(i);
  for (const int k : m.children(i)) W -= Ad(m.C(k, i)).transpose() * own(k);
  return W;
}

// Jᵀ (M_1 V̇_1 - ad_{V_1}ᵀ M_1 V_1 - W_1^app; ...; M_n V̇_n - ad_{V_n}ᵀ M_n V_n - W_n^app) = 0, body-fixed;
// W^app with the drives
TEST(Paper, PE) {
  each_system([](Equation& eq, const Motion& m) {
    const Matrix Jt = system_jacobian<BodyFixed>(m).transpose();
    const Matrix bodies = stacked(m, [&](int i) -> Vec6 {
      const Mat6 M = to_matrix(m.M(i));
      const Vec6 V = m.V<BodyFixed>(i);
      return M * m.dV<BodyFixed>(i) - ad(V).transpose() * M * V - m.W_app<BodyFixed>(i);
    });
    const Matrix drives = stacked(m, [&](int i) { return drive_wrench(m, i); });
    eq.holds(Jt * (bodies - drives), Matrix(Jt.rows(), 1), (Jt * drives).norm());
    eq.holds(Jt * bodies, by_projection(m));
  });
}

// Jᵀ (Π̇_1 - W_1^app; ...; Π̇_n - W_n^app) = 0, spatial; W^app with the drives
TEST(Paper, PEsLine1) {
  each_system([](Equation& eq, const Motion& m) {
    const Matrix Jt = system_jacobian<Spatial>(m).transpose();
    const Matrix bodies =
        stacked(m, [&](int i) -> Vec6 { return rate(m.Pi_of_t<Spatial>(i)) - m.W_app<Spatial>(i); });
    const Matrix drives =
        stacked(m, [&](int i) -> Vec6 { return Ad(inverse(m.C(i))).transpose() * drive_wrench(m, i); });
    eq.holds(Jt * (bodies - drives), Matrix(Jt.rows(), 1), (Jt * drives).norm());
    eq.holds(Jt * bodies,
             closed_form::momentum_balance(m.model(), m.q(), m.v(), m.a(), {.wrenches = m.loads()}));
  });
}

/// The joint velocities v and the rates Π̇ of all bodies that the library computes from Π and the drive
/// forces.
struct MomentumState {
  std::vector<double> v;
  std::vector<Wrench<Spatial>> dPi;
};
MomentumState rates_by_spatial_momenta(const Motion& m) {
  MomentumState rates{m.v(), std::vector<Wrench<Spatial>>(static_cast<std::size_t>(m.n()))};
  std::ranges::fill(rates.v, 0);
  std::vector<Momentum<Spatial>> Pi;
  for (int i = 1; i <= m.n(); ++i) Pi.push_back(from_six<Momentum<Spatial>>(m.Pi<Spatial>(i)));
  Workspace<> workspace(m.model());
  const Solvability solved = spatial_momentum_form(m.model(), workspace, m.q(), Pi, drive_forces(m).entries(),
                                                   rates.v, rates.dPi, {.wrenches = m.loads()});
  EXPECT_TRUE(solved.ok());
  return rates;
}

// M_i [J_1 ... J_i 0 ...] q̇ = Π_i for i = 1, ..., n, spatial
TEST(Paper, PEsLine2) {
  each_body([](Equation& eq, const Motion& m, int i) {
    const Mat6 M = to_matrix(transform(m.C(i), m.M(i)));
    Matrix J_i(6, m.model().nv());
    for (const int j : m.path(i)) J_i.set_block(0, velocity(m, j), m.J<Spatial>(j, j));
    eq.holds(M * J_i * as_vector(m.v()), m.Pi<Spatial>(i));
    const MomentumState rates = rates_by_spatial_momenta(m);
    const Matrix of_all = stacked(m, [&](int k) -> Vec6 { return rate(m.Pi_of_t<Spatial>(k)); });
    eq.holds(M * J_i * as_vector(rates.v), m.Pi<Spatial>(i));
    eq.holds(rates.dPi[i - 1], rate(m.Pi_of_t<Spatial>(i)), of_all.norm());
    eq.fails(M * m.J<Spatial>(i, i) * m.qd(i), m.Pi<Spatial>(i));  // with the screw J_i of joint i alone
  });
}

}  // namespace
}  // namespace axode::test::paper
