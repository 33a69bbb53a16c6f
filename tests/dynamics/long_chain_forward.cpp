#include <array>

#include "tests/laws/law.hpp"

/// Long chains: all representations agree, and inverse dynamics of the computed accelerations gives the
/// forces back.
namespace axode::test {
namespace {

/// A chain of n links of 1 kg and, if not given otherwise, 20 cm. The hinge axes are x, y and z in turn. The
/// first hinge is `away` from the inertial origin, m.
Model chain(int n, double away, double length = 0.2) {
  ModelBuilder builder("chain");
  const Vec3<> axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int i = 0; i < n; ++i) {
    BodyDescription link{.name = "link " + std::to_string(i)};
    if (i > 0) link.predecessor = "link " + std::to_string(i - 1);
    link.joint = {.kind = JointKind::revolute, .axis = axes[i % 3]};
    link.geometry = InBodyFrame{{{}, i == 0 ? Vec3<>{away, 0, 0} : Vec3<>{0, 0, -length}}};
    link.inertia = MassProperties{.mass = 1, .com = {0.01, 0, -length / 2}, .Theta = {0.01, 0.01, 0.002}};
    builder.add(std::move(link));
  }
  return builder.build();
}

/// The relative residual ‖τ - ID(FD(τ))‖∞ / ‖τ‖∞ with τ = ID(a).
double residual(Trial t) {
  Ask ask = t.ask();
  ask.tau = t.inverse_dynamics();
  const auto [a, solvability] = t.answer("forward_dynamics", ask);
  EXPECT_TRUE(solvability.ok());
  std::vector<double> off = t.inverse_dynamics(t.state.v, a, {});
  for (std::size_t c = 0; c < off.size(); ++c) off[c] -= ask.tau[c];
  return largest(off) / largest(ask.tau);
}

/// The residuals in the representations body, spatial, hybrid and mixed. The joint angles are up to `bend`,
/// rad.
std::array<double, 4> residuals(int n, double bend, double away, std::uint64_t seed) {
  Random<double> random(seed);
  std::vector<double> q = random_numbers(random, n), v = random_numbers(random, n),
                      a = random_numbers(random, n);
  for (double& x : q) x *= bend;
  const Trial trial(scalars()[0], chain(n, away), {q, v, a});
  std::array<double, 4> all{};
  for (std::size_t r = 0; r < 4; ++r) all[r] = residual(trial.by(representations[r]));
  return all;
}

TEST(LongChain, AgreesInAllRepresentations) {
  const int n = 10'000;
  Random<double> random(1);
  std::vector<double> q = random_numbers(random, n), v = random_numbers(random, n),
                      a = random_numbers(random, n);
  for (double& x : q) x *= 0.01;
  for (double& x : v) x *= 0.01;
  Trial body(in(Representation::body, scalars()[0]), chain(n, 0, 0.01), {q, v, a});
  const std::vector<double> tau = body.inverse_dynamics();
  Comparison torque("torque", agreement<double>);
  for (const Representation other : {Representation::spatial, Representation::hybrid, Representation::mixed})
    torque.expect_equal(body.by(other).inverse_dynamics(), tau);
}

TEST(LongChain, ForwardDynamicsUndoesInverseDynamics) {
  for (const double bend : {0.001, 1.0})  // stretched out, and curled
    for (const int n : {10, 100, 1000}) {
      std::array<double, 4> worst{};
      for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const std::array<double, 4> found = residuals(n, bend, 0, seed);
        for (std::size_t r = 0; r < 4; ++r) worst[r] = std::max(worst[r], found[r]);
      }
      for (std::size_t r = 0; r < 4; ++r) {
        EXPECT_LE(worst[r], 1e-8) << name(representations[r]) << ", n = " << n << ", bend " << bend;
        RecordProperty(
            (bend < 1 ? "stretched " : "curled ") + std::to_string(n) + " " + name(representations[r]),
            to_text(worst[r]));
      }
    }
}

TEST(LongChain, NoRepresentationSuffersFarFromTheInertialOrigin) {
  for (const double away : {1e2, 1e4, 1e6}) {
    const std::array<double, 4> found = residuals(100, 1, away, 1);
    for (std::size_t r = 0; r < 4; ++r) {
      EXPECT_LE(found[r], 1e-12) << name(representations[r]) << ", " << away << " m away";
      RecordProperty(to_text(away) + " m away " + name(representations[r]), to_text(found[r]));
    }
  }
}

}  // namespace
}  // namespace axode::test
