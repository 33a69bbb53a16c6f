#include "tests/laws/law.hpp"

/// Forward dynamics is the inverse of inverse dynamics, in every representation and with every load. A mass
/// matrix that cannot be inverted is reported, and no other one is. Both functions leave springs out.
namespace axode::test {
namespace {

class ForwardDynamics : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, ForwardDynamics, testing::ValuesIn(cases_with_fast()), name_of);

TEST_P(ForwardDynamics, UndoesInverseDynamics) {
  const double agreement = GetParam().agreement();
  Comparison torque("torque", agreement);
  // Loops are solved to the accuracy that their conditions allow, so that they are compared in double alone.
  Comparison with_loops("torque with loops", 1e-8);
  int solved = 0, singular = 0, closed = 0;
  for_seeds(1000, [&](std::uint64_t seed) {
    const bool loops = !GetParam().single && seed % 20 == 1;
    TreeRecipe recipe = elsewhere(seed, {.friction = seed % 2 == 0, .loops = loops ? 1.0 : 0.0});
    if (recipe.far > 0) recipe.far = GetParam().single ? 0 : 5e3;
    Trial trial(GetParam(), seed, recipe);
    Ask ask = trial.ask();
    ask.loads.joint_losses =
        seed % 2 == 0 && !loops;  // no drive can make up for the losses of passive joints
    ask.tau = trial.inverse_dynamics(ask.v, ask.a, ask.loads);
    const auto [a, solvability] = trial.answer("forward_dynamics", ask);
    if (loops) {
      ++closed;
      ASSERT_TRUE(solvability.ok());
      with_loops.expect_equal(trial.inverse_dynamics(ask.v, a, ask.loads), ask.tau);
    } else if (solvability.ok()) {
      ++solved;
      torque.expect_equal(trial.inverse_dynamics(ask.v, a, ask.loads), ask.tau);
    } else {
      ++singular;
      EXPECT_LE(definiteness(trial.mass_matrix()), agreement / 10);
      EXPECT_TRUE(std::all_of(a.begin(), a.end(), [](double x) { return std::isnan(x); }));
    }
  });
  EXPECT_GE(solved, (solved + singular) / 10);
  EXPECT_GE(singular, (solved + singular) / 10);
  EXPECT_EQ(closed > 0, !GetParam().single);
}

}  // namespace
}  // namespace axode::test
