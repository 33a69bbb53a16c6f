#include "tests/laws/law.hpp"

/// Forward dynamics is the inverse of inverse dynamics, in every representation and with every load. A mass
/// matrix that cannot be inverted is reported, and no other one is.
namespace axode::test {
namespace {

class ForwardDynamics : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, ForwardDynamics, testing::ValuesIn(cases_with_fast()), name_of);

TEST_P(ForwardDynamics, UndoesInverseDynamics) {
  const double agreement = GetParam().agreement();
  Comparison torque("torque", agreement);
  int solved = 0, singular = 0;
  for_seeds(2000, [&](std::uint64_t seed) {
    const bool far = !GetParam().single && seed % 4 == 1;
    Trial trial(GetParam(), Random<double>(seed), {.friction = seed % 2 == 0, .far = far ? 5e3 : 0});
    Ask ask = trial.ask();
    ask.loads.joint_losses = seed % 2 == 0;
    ask.tau = trial.inverse_dynamics(ask.v, ask.a, ask.loads);
    const auto [a, solvability] = trial.answer("forward_dynamics", ask);
    if (solvability.ok()) {
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
}

}  // namespace
}  // namespace axode::test
