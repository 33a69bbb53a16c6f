#include "tests/laws/law.hpp"

/// The generalised forces of a mechanism do not depend on the representation, and have the structure τ = M(q)
/// a + C(q, v) v + g(q) - Jᵀ W. Inverse dynamics leaves springs out, whose forces are to be subtracted. The
/// mechanisms have no loops, because these laws are about single terms; loops.cpp, invariance.cpp and
/// forward_dynamics.cpp have those about closed mechanisms.
namespace axode::test {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

class InverseDynamics : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, InverseDynamics, testing::ValuesIn(cases()), name_of);

TEST_P(InverseDynamics, AgreesWithTheOtherRepresentations) {
  Comparison torque("torque", GetParam().agreement());
  for_seeds(1000, [&](std::uint64_t seed) {
    const TreeRecipe recipe = elsewhere(seed);
    Trial trial(GetParam(), seed, recipe);
    const std::vector<double> tau = trial.inverse_dynamics();
    for (const Case& other : cases())
      if (other.single == trial.how.single && other.name != trial.how.name)
        torque.expect_equal(tau, trial.by(other).inverse_dynamics(), terms_far_away(trial, recipe.far));
  });
}

/// The mass matrix M(q), computed column by column with inverse dynamics.
MatrixXd columns_of_mass_matrix(Trial& trial) {
  const int n = trial.model.nv();
  const VectorXd at_rest = vector(trial.inverse_dynamics(trial.zero(), trial.zero(), {}));
  MatrixXd M(n, n);
  for (int k = 0; k < n; ++k) {
    std::vector<double> a = trial.zero();
    a[static_cast<std::size_t>(k)] = 1;
    M.col(k) = vector(trial.inverse_dynamics(trial.zero(), a, {})) - at_rest;
  }
  return M;
}

TEST_P(InverseDynamics, MassMatrixIsSymmetricAndNotNegative) {
  const double agreement = GetParam().agreement();
  Comparison symmetry("symmetry", agreement);
  for_seeds(100, [&](std::uint64_t seed) {
    const bool every_body_has_mass = seed % 2 == 0;
    TreeRecipe recipe =
        elsewhere(seed, {.couplings = !every_body_has_mass, .always_mass = every_body_has_mass});
    recipe.far = 0;  // the rounding of the inertia about a distant origin would hide that of the bodies
    Trial with_gravity(GetParam(), seed, recipe);
    if (with_gravity.model.nv() == 0) return;
    // Without gravity, whose forces would hide those of M in their rounding.
    Trial trial(GetParam(), ModelBuilder(with_gravity.model).gravity({}).build(), with_gravity.state);
    const MatrixXd M = columns_of_mass_matrix(trial);
    symmetry.expect_equal(M, MatrixXd(M.transpose()));
    EXPECT_GE(smallest_eigenvalue(M), -agreement * largest_entry(M));
    if (every_body_has_mass && !trial.how.single) {
      EXPECT_TRUE(is_positive_definite(M));
    }
  });
}

TEST_P(InverseDynamics, VelocityTermsAreQuadratic) {
  Comparison torque("torque", GetParam().agreement());
  for_seeds(250, [&](std::uint64_t seed) {
    const TreeRecipe recipe = elsewhere(seed);
    Trial trial(GetParam(), seed, recipe);
    const VectorXd rest = vector(trial.inverse_dynamics(trial.zero(), trial.zero(), {}));
    const auto velocity_terms = [&](double scale) {
      const std::vector<double> v = numbers(scale * vector(trial.state.v));
      return VectorXd((vector(trial.inverse_dynamics(v, trial.zero(), {})) - rest) / (scale * scale));
    };
    torque.expect_equal(velocity_terms(-2), velocity_terms(1),
                        std::max(largest(entries(rest)), terms_far_away(trial, recipe.far)));
  });
}

TEST_P(InverseDynamics, LoadsActThroughTheTransposedJacobian) {
  Comparison torque("torque", GetParam().agreement());
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const TreeRecipe recipe = elsewhere(seed);
    const MechanismAtAState drawn = mechanism_at_a_state(random, recipe);
    Trial trial(GetParam(), ModelBuilder(drawn.model).gravity({}).build(), drawn.state);
    if (trial.state.wrenches.empty()) return;
    const std::vector<double> drives =
        trial.inverse_dynamics(trial.zero(), trial.zero(), trial.state.loads());
    const std::vector<SE3<>> C = trial.poses();
    std::vector<double> power;
    for (std::size_t k = 0; k < drives.size(); ++k) {
      std::vector<double> v = trial.zero();
      v[k] = 1;
      const std::vector<Six> J = trial.twists(v);
      double sum = 0;
      for (const AppliedWrench<>& load : trial.state.wrenches) {
        const std::size_t f = static_cast<std::size_t>(load.frame);
        const Six J_f = changed_twist(load.representation, trial.how.representation, C[f], J[f]);
        sum -= dot(load.m, J_f.a) + dot(load.f, J_f.b);
      }
      power.push_back(sum);
    }
    torque.expect_equal(drives, power, terms_far_away(trial, recipe.far));
  });
}

TEST_P(InverseDynamics, DampingAndFrictionResistOnlyWhenAsked) {
  Comparison torque("torque", GetParam().agreement());
  for_seeds(100, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed, elsewhere(seed));
    if (seed % 3 == 0 && !trial.state.v.empty()) trial.state.v[0] = 0;
    const std::vector<double> without = trial.inverse_dynamics(trial.state.v, trial.state.a, {});
    const std::vector<double> with =
        trial.inverse_dynamics(trial.state.v, trial.state.a, {.joint_losses = true});
    std::vector<double> expected = without;
    for (const Joint& joint : trial.model.joints()) {
      const double ratio = joint.leader ? joint.leader->ratio : 1;
      for (std::size_t d = 0; d < joint.dof.size(); ++d) {
        const std::size_t k = static_cast<std::size_t>(joint.iv) + d;
        const double speed = ratio * trial.state.v[k], sign = speed > 0 ? 1 : speed < 0 ? -1 : 0;
        expected[k] += ratio * (joint.dof[d].damping * speed + joint.dof[d].friction * sign);
      }
    }
    torque.expect_equal(with, expected);
  });
}

class FloatInverseDynamics : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, FloatInverseDynamics, testing::ValuesIn(cases().begin() + 4, cases().end()),
                         name_of);

TEST_P(FloatInverseDynamics, AgreesWithDouble) {
  Comparison torque("torque", GetParam().agreement()), springs("springs", GetParam().agreement());
  for_seeds(1000, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const TreeRecipe recipe = elsewhere(seed);
    const MechanismAtAState drawn = mechanism_at_a_state(random, recipe);
    Trial in_float(GetParam(), drawn), exact(in_double(GetParam()), drawn);
    torque.expect_equal(in_float.inverse_dynamics(), exact.inverse_dynamics(),
                        terms_far_away(exact, recipe.far));
    const double size_of_terms = exact.call("elastic_energy")[0];  // of springs that balance each other
    springs.expect_equal(in_float.call("spring_forces"), exact.call("spring_forces"), size_of_terms);
  });
}

}  // namespace
}  // namespace axode::test
