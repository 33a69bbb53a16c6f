#include <algorithm>

#include "axode/derivatives/term_derivatives.hpp"
#include "axode/dynamics/closed_form/closed_form.hpp"
#include "axode/dynamics/momentum/momentum_form.hpp"
#include "tests/paper/energy.hpp"

/// Section 5.2: Lagrange's equations, with the matrices of the whole system in body-fixed representation.
namespace axode::test::paper {
namespace {

/// The matrices M, A, X, a, b and J of the paper.
struct SystemOfLagrange {
  Matrix M, A, X, a, b, J;
  Matrix qd, qdd, V;

  explicit SystemOfLagrange(const Motion& m)
      : M(block_diagonal_of(m, [&](int i) { return to_matrix(m.M(i)); })),
        a(a_matrix(m.model(), m.v())),
        b(b_matrix(m.model(), to_eigen_vector(system_V<BodyFixed>(m)))),
        J(system_jacobian<BodyFixed>(m)),
        qd(as_vector(m.v())),
        qdd(as_vector(m.a())),
        V(system_V<BodyFixed>(m)) {
    const SystemMatrices s = system_matrices<BodyFixed>(m.model(), m.q());
    A = s.A, X = s.X;
  }
};
using CheckOfSystem = std::function<void(Equation&, const Motion&, const SystemOfLagrange&)>;
void each_system_of_lagrange(const CheckOfSystem& check) {
  each_system_with_one_screw_joints(
      [&](Equation& eq, const Motion& m) { check(eq, m, SystemOfLagrange(m)); });
}

Matrix mass_matrix_by_recursion(const Motion& m) {
  Workspace<> workspace(m.model());
  Matrix M(m.model().nv(), m.model().nv());
  mass_matrix(m.model(), workspace, m.q(), M.entries());
  return M;
}
Matrix coriolis_matrix_by_recursion(const Motion& m) {
  Workspace<> workspace(m.model());
  Matrix Ct(m.model().nv(), m.model().nv());  // row by row: transposed
  coriolis_matrix(m.model(), workspace, m.q(), m.v(), CoriolisForm::paper, Ct.entries());
  return Ct.transpose();
}
/// C q̇ by definition: d/dt ∂T/∂q̇ - ∂T/∂q - M q̈.
Matrix coriolis_forces_of(const Motion& m) {
  return conjugate_momenta(m).dp - energy_gradient(m) - mass_matrix_of(m) * as_vector(m.a());
}

// d/dt (∂T/∂q̇)ᵀ - (∂T/∂q)ᵀ = M q̈ + C q̇ = Q
TEST(Paper, LE) {
  each_system_of_lagrange([](Equation& eq, const Motion& m, const SystemOfLagrange& s) {
    const Matrix left = conjugate_momenta(m).dp - energy_gradient(m);
    eq.holds(left, mass_matrix_by_recursion(m) * s.qdd + coriolis_matrix_by_recursion(m) * s.qd);
    eq.holds(left, generalised_forces(m));
    eq.holds(drive_forces(m),
             closed_form::lagrange_equations(m.model(), m.q(), m.v(), m.a(), {.wrenches = m.loads()}));
  });
}

// M = Jᵀ M J; T = V^T M V / 2 = q̇ᵀ M q̇ / 2
TEST(Paper, MLE) {
  each_system_of_lagrange([](Equation& eq, const Motion& m, const SystemOfLagrange& s) {
    const Matrix M = mass_matrix_of(m);
    eq.holds(M, s.J.transpose() * s.M * s.J);
    eq.holds(M, mass_matrix_by_recursion(m));
    eq.holds(M, closed_form::mass_matrix(m.model(), m.q()));
    double T = 0;
    for (int i = 1; i <= m.n(); ++i) T += m.kinetic_energy(i);
    eq.holds(T, 0.5 * s.V.dot(s.M * s.V));
    eq.holds(T, 0.5 * s.qd.dot(M * s.qd));
    Workspace<> workspace(m.model());
    eq.holds(T, kinetic_energy(m.model(), workspace, m.q(), m.v()));
  });
}

// (∂T/∂q̇)ᵀ = Jᵀ M V
TEST(Paper, ConjugateMomentum) {
  each_system_of_lagrange([](Equation& eq, const Motion& m, const SystemOfLagrange& s) {
    const Matrix p = conjugate_momenta(m).p;
    eq.holds(p, s.J.transpose() * s.M * s.V);
    Workspace<> workspace(m.model());
    std::vector<double> library(m.v().size());
    momenta(m.model(), workspace, m.q(), m.v(), library);
    eq.holds(p, as_vector(library));
  });
}

// d/dt (∂T/∂q̇)ᵀ = M q̈ - Jᵀ ((M A a)ᵀ + M A a) J q̇
TEST(Paper, ConjugateMomentumRate) {
  each_system_of_lagrange([](Equation& eq, const Motion& m, const SystemOfLagrange& s) {
    const Matrix MAa = s.M * s.A * s.a;
    eq.holds(conjugate_momenta(m).dp,
             mass_matrix_of(m) * s.qdd - s.J.transpose() * (MAa.transpose() + MAa) * s.J * s.qd);
    Workspace<> workspace(m.model());
    std::vector<double> v(m.v().size()), dp = v;
    const Solvability solved = momentum_form(m.model(), workspace, m.q(), conjugate_momenta(m).p.entries(),
                                             drive_forces(m).entries(), v, dp, {.wrenches = m.loads()});
    EXPECT_TRUE(solved.ok());
    eq.holds(conjugate_momenta(m).p, mass_matrix_of(m) * as_vector(v));
    eq.holds(conjugate_momenta(m).dp, as_vector(dp), drive_forces(m).norm());
  });
}

// (∂T/∂q)ᵀ = (M A b X)ᵀ J q̇
TEST(Paper, KineticEnergyGradient) {
  each_system_of_lagrange([](Equation& eq, const Motion& m, const SystemOfLagrange& s) {
    eq.holds(energy_gradient(m), (s.M * s.A * s.b * s.X).transpose() * s.J * s.qd);
    Workspace<> workspace(m.model());
    std::vector<double> by_q(m.v().size()), by_v = by_q;
    kinetic_energy_gradient(m.model(), workspace, m.q(), m.v(), {by_q, by_v});
    eq.holds(energy_gradient(m), as_vector(by_q));
    eq.holds(conjugate_momenta(m).p, as_vector(by_v));
  });
}

// b(V) = diag(ad_{V_1}, ..., ad_{V_n}), body-fixed
TEST(Paper, Bb) {
  each_system([](Equation& eq, const Motion& m) {
    eq.holds(b_matrix(m.model(), to_eigen_vector(system_V<BodyFixed>(m))),
             block_diagonal_of(m, [&](int i) { return ad(to_matrix(m.twist<BodyFixed>(i))); }));
  });
}

// C = -Jᵀ ((M A a)ᵀ + M A a) J - (M A b X)ᵀ J = -(a J + b X)ᵀ Aᵀ M J - Jᵀ M A a J
TEST(Paper, CMatTmp) {
  each_system_of_lagrange([](Equation& eq, const Motion& m, const SystemOfLagrange& s) {
    const Matrix MAa = s.M * s.A * s.a;
    const Matrix first =
        -s.J.transpose() * (MAa.transpose() + MAa) * s.J - (s.M * s.A * s.b * s.X).transpose() * s.J;
    const Matrix second = -(s.a * s.J + s.b * s.X).transpose() * s.A.transpose() * s.M * s.J -
                          s.J.transpose() * s.M * s.A * s.a * s.J;
    eq.holds(coriolis_forces_of(m), first * s.qd);
    eq.holds(coriolis_matrix_by_recursion(m), first);
    eq.holds(coriolis_matrix_by_recursion(m), second);
    eq.holds(closed_form::coriolis_matrix(m.model(), m.q(), m.v(), CoriolisForm::paper), first);
  });
}

// C = -Jᵀ (M A a + bᵀ M) J
TEST(Paper, CMat) {
  each_system_of_lagrange([](Equation& eq, const Motion& m, const SystemOfLagrange& s) {
    const Matrix C = -s.J.transpose() * (s.M * s.A * s.a + s.b.transpose() * s.M) * s.J;
    eq.holds(coriolis_forces_of(m), C * s.qd);
    eq.holds(coriolis_matrix_by_recursion(m), C);
    eq.holds(closed_form::coriolis_matrix(m.model(), m.q(), m.v(), CoriolisForm::paper), C);
  });
}

std::vector<double> library_symbols(const Motion& m) {
  Workspace<> workspace(m.model());
  std::vector<double> Gamma(m.v().size() * m.v().size() * m.v().size());
  christoffel(m.model(), workspace, m.q(), Gamma);
  return Gamma;
}

// Σ_j M_ij q̈_j + Σ_jk Γ_ijk q̇_j q̇_k = Q_i
TEST(Paper, EOMComponents) {
  each_system_of_lagrange([](Equation& eq, const Motion& m, const SystemOfLagrange&) {
    const Matrix M = mass_matrix_of(m);
    const Matrix Q = generalised_forces(m);
    const int n = m.model().nv();
    for (const std::vector<double>& Gamma : {christoffel_symbols_of(m), library_symbols(m)})
      for (int i = 0; i < n; ++i) {
        double sum = 0;
        for (int j = 0; j < n; ++j) {
          sum += M(i, j) * m.a()[j];
          for (int k = 0; k < n; ++k) sum += Gamma[(i * n + j) * n + k] * m.v()[j] * m.v()[k];
        }
        eq.holds(sum, Q[i], Q.norm());
      }
  });
}

/// Calls check(Γ_ijk by definition, Γ_ijk of the library, i, j, k) for the joints of all symbols with j <= k,
/// and returns the size of the symbols.
template <class Check>
void each_symbol(const Motion& m, const std::vector<double>& library, const Check& check) {
  const std::vector<double> Gamma = christoffel_symbols_of(m);
  const int n = m.model().nv();
  const double size = as_vector(Gamma).largest_entry();
  for (int i = 1; i <= m.n(); ++i)
    for (int j = 1; j <= m.n(); ++j)
      for (int k = j; k <= m.n(); ++k) {
        const int at = (velocity(m, i) * n + velocity(m, j)) * n + velocity(m, k);
        check(Gamma[at], library[at], i, j, k, size);
      }
}
/// The bodies that have i, j and k on their path.
std::vector<int> behind(const Motion& m, int i, int j, int k) {
  std::vector<int> bodies;
  for (int l = std::max({i, j, k}); l <= m.n(); ++l) {
    const std::vector<int> path = m.path(l);
    const auto on_path = [&](int x) { return std::find(path.begin(), path.end(), x) != path.end(); };
    if (on_path(i) && on_path(j) && on_path(k)) bodies.push_back(l);
  }
  return bodies;
}

// Γ_ijk = (1/2) Σ_l (J_{l,k}ᵀ M_l ad_{J_{l,i}} J_{l,j} + J_{l,j}ᵀ M_l ad_{J_{l,i}} J_{l,k} + J_{l,i}ᵀ M_l
// ad_{J_{l,s}} J_{l,r}) for any i and j <= k, with r = k, s = j, over the bodies l that have i, j and k on
// their path
TEST(Paper, Gamma) {
  each_system_of_lagrange([](Equation& eq, const Motion& m, const SystemOfLagrange&) {
    const auto J = [&](int l, int j) -> Vec6 { return m.J<BodyFixed>(l, j); };
    each_symbol(m, library_symbols(m), [&](double left, double library, int i, int j, int k, double size) {
      const auto sum = [&](int r, int s) {
        double x = 0;
        for (const int l : behind(m, i, j, k)) {
          const Mat6 M = to_matrix(m.M(l));
          x +=
              0.5 * (J(l, k).dot(M * bracket(J(l, i), J(l, j))) + J(l, j).dot(M * bracket(J(l, i), J(l, k))) +
                     J(l, i).dot(M * bracket(J(l, s), J(l, r))));
        }
        return x;
      };
      eq.holds(left, sum(k, j), size);
      eq.holds(left, library, size);
      const bool in_printed_range = (i < j && j <= k) || (j <= i && i < k);
      if (in_printed_range && std::abs(left) > 1e-3 * size)
        eq.fails(left, sum(std::max(i, j), std::min(i, j)));
    });
  });
}

// Γ_ijk = Σ_l tr(Ĵ_{l,i} P_l (Ĵ_{l,j} Ĵ_{l,k})ᵀ) for j <= k, P_l = [[ϑ_l, m c], [m cᵀ, m]], over the same
// bodies l
TEST(Paper, GammaBinet) {
  each_system_of_lagrange([](Equation& eq, const Motion& m, const SystemOfLagrange&) {
    const auto J = [&](int l, int j) -> Vec6 { return m.J<BodyFixed>(l, j); };
    const auto J_hat = [&](int l, int j) -> Mat4 { return hat(from_six(J(l, j))); };
    const std::vector<double> library = closed_form::christoffel(m.model(), m.q());
    each_symbol(m, library, [&](double left, double by_library, int i, int j, int k, double size) {
      double right = 0, printed = 0;
      for (const int l : behind(m, i, j, k)) {
        const Inertia<>& M = m.M(l);
        const Mat3 Theta = to_matrix(M.Theta), binet = 0.5 * Theta.trace() * identity(3) - Theta;
        const Vec3d mc = to_matrix(M.h);
        const Mat4 P = blocks(binet, mc, mc.transpose(), M.m);
        right += (J_hat(l, i) * P * (J_hat(l, j) * J_hat(l, k)).transpose()).trace();
        const Vec3d c = (1 / M.m) * mc;
        const Mat6 M_check_c =
            block_diagonal(to_matrix(binet_tensor(inertia_about_com(M))), M.m * identity(3));
        const Mat6 M_check = Ad(Vec3d(-c)).transpose() * M_check_c * Ad(Vec3d(-c));
        printed += 0.5 * J(l, j).dot(M_check * ad(angular_screw(J(l, k))) * J(l, i));
      }
      eq.holds(left, right, size);
      eq.holds(left, by_library, size);
      if (std::abs(left) > 1e-3 * size) eq.fails(left, printed);
    });
  });
}

}  // namespace
}  // namespace axode::test::paper
