#include "axode/constraints.hpp"
#include "axode/dynamics/mass_matrix/mass_matrix.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/laws/law.hpp"

/// Functions of mechanisms with loops in which nothing can move, because there is no joint or because the
/// loops lock all joints.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;

/// Calls all functions, and expects that no velocity is free.
void expect_rest(const Model& model) {
  const auto nv = static_cast<std::size_t>(model.nv()), m = static_cast<std::size_t>(model.loops().rows);
  LoopWorkspace<double> loops(model);
  const Numbers q = neutral(model), rest(nv);
  Numbers a(nv), tau(nv), lambda(m), A(m * nv), gamma(m),
      r(static_cast<std::size_t>(model.loops().residuals)), R(r.size() * nv), product(nv);
  std::array<Numbers, 3> by{Numbers(nv * nv), Numbers(nv * nv), Numbers(nv * nv)};
  loop_residual(model, loops, q, r);
  loop_jacobian(model, loops, q, A);
  loop_residual_jacobian(model, loops, q, R);
  loop_hessian_product(model, loops, q, r, rest, product);
  loop_bias(model, loops, q, rest, gamma);
  EXPECT_TRUE(forward_dynamics(model, loops, q, rest, tau, a, lambda).ok());
  for (const double x : a) EXPECT_NEAR(x, 0, 1e-9);
  EXPECT_TRUE(forward_dynamics_derivatives(model, loops, q, rest, tau, {by[0], by[1], by[2]}).ok());
  EXPECT_LT(inverse_dynamics(model, loops, q, rest, rest, tau, lambda), 1e-9);
  std::vector<Wrench<BodyFixed>> W(static_cast<std::size_t>(model.n_bodies())),
      closing(model.loops().all.size());
  EXPECT_LT(joint_wrenches<BodyFixed>(model, loops, q, rest, rest, W), 1e-9);
  loop_wrenches<BodyFixed>(model, loops, q, lambda, closing);
  EXPECT_TRUE(impact(model, loops, q, rest, 0.5, a, lambda).ok());
  EXPECT_EQ(assemble(model, q, rest).status, AssemblyStatus::closed);
  EXPECT_EQ(loop_mobility(model, q).degrees_of_freedom, 0);
  EXPECT_EQ(equilibrium(model, q).status, EquilibriumStatus::solved);
  EXPECT_EQ(joint_state(model, std::vector<SE3<>>(W.size() + 1), std::vector<Twist<BodyFixed>>(W.size() + 1))
                .q.size(),
            q.size());

  const IndependentEquations equations = independent_equations(model, q, rest);
  EXPECT_TRUE(equations.velocities.empty());
  EXPECT_EQ(equations.M.size() + equations.h.size() + equations.N.size(), 0);
  EXPECT_EQ(equations.c.size(), model.nv());
  const IndependentLinearization small = independent_linearization(model, q, rest, rest);
  EXPECT_TRUE(small.velocities.empty());
  EXPECT_TRUE(small.solvability.ok());
  EXPECT_EQ(small.A.size() + small.B.size(), 0);
}

TEST(NothingMovesWithLoops, BecauseThereIsNoJoint) {
  expect_rest(
      ModelBuilder(Description{.name = "table",
                               .bodies = {{.name = "table",
                                           .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}}}}})
          .build());
}

TEST(NothingMovesWithLoops, BecauseLoopsLockIt) {
  const Vec3<> z{0, 0, 1};
  expect_rest(ModelBuilder(ring({{0, 0, 0}, {1, 1, 0}, {2, 0, 0}}, {z, z, z})).build());
}

}  // namespace
}  // namespace axode::test
