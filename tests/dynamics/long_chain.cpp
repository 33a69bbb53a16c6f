#include "tests/laws/law.hpp"

/// A mechanism may be very deep: nothing recurses on the stack.
namespace axode::test {
namespace {

constexpr int n = 10'000;

/// A hanging chain of equal links of 1 cm and 10 g, with hinges about x and y in turn.
Model chain() {
  ModelBuilder builder("chain");
  for (int i = 0; i < n; ++i) {
    BodyDescription link{.name = "link " + std::to_string(i)};
    if (i > 0) link.predecessor = "link " + std::to_string(i - 1);
    link.joint = {.kind = JointKind::revolute, .axis = i % 2 == 0 ? Vec3<>{1, 0, 0} : Vec3<>{0, 1, 0}};
    link.geometry = InBodyFrame{{{}, {0, 0, i == 0 ? 0 : -0.01}}};
    link.inertia = MassProperties{.mass = 0.01, .com = {0, 0, -0.005}, .Theta = {1e-7, 1e-7, 1e-7}};
    builder.add(std::move(link));
  }
  return builder.build();
}

TEST(LongChain, IsBuiltAndEvaluated) {
  const Model model = chain();
  ASSERT_EQ(model.n_bodies(), n);
  EXPECT_NEAR(model.total_mass(), 100, 1e-9);
  std::vector<double> zero(n);
  Trial hanging(scalars()[0], model, {zero, zero, zero});
  EXPECT_NEAR(hanging.poses()[n].r.z, -0.01 * (n - 1), 1e-9);
  EXPECT_LE(largest(hanging.by(Representation::body).inverse_dynamics()), 1e-9) << "it hangs straight down";
  const std::vector<Six> W = hanging.joint_wrenches();
  EXPECT_NEAR(W[0].b.z, 100 * 9.81, 1e-6) << "the first hinge carries all of it";
  EXPECT_NEAR(W[n - 1].b.z, 0.01 * 9.81, 1e-12) << "the last hinge carries its link";
}

TEST(LongChain, AgreesInAllRepresentations) {
  const Model model = chain();
  Random<double> random(1);
  std::vector<double> q = random_numbers(random, n), v = random_numbers(random, n),
                      a = random_numbers(random, n);
  for (double& x : q) x *= 0.01;
  for (double& x : v) x *= 0.01;
  Trial body(in(Representation::body, scalars()[0]), model, {q, v, a});
  const std::vector<double> tau = body.inverse_dynamics();
  Comparison torque("torque", agreement<double>);
  for (const Representation other : {Representation::spatial, Representation::hybrid, Representation::mixed})
    torque.expect_equal(body.by(other).inverse_dynamics(), tau);
}

}  // namespace
}  // namespace axode::test
