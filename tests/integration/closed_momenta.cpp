#include "axode/constraints/loops.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/integration/motions.hpp"
#include "tests/support/refused_arguments.hpp"

/// Schemes in (q, p) for mechanisms with loops: their orders, reversibility, energies without drift, and
/// momenta that stay to rounding.
namespace axode::test {
namespace closed_momenta {
namespace {

/// A four-bar whose frame is not fixed to the ground but moves freely.
Description floating(const Vec3<>& g) {
  Description d = four_bar();
  d.name = "floating four-bar", d.gravity = g;
  d.bodies[0].predecessor = "trunk", d.loops[0].between[1] = "trunk";
  BodyDescription trunk{.name = "trunk", .joint = {.kind = JointKind::free}};
  trunk.inertia = MassProperties{.mass = 3, .com = {0.1, 0.2, 0.3}, .Theta = {1, 1.2, 1.4, 0.1, 0, 0.2}};
  d.bodies.insert(d.bodies.begin(), trunk);
  return d;
}
double most_open(const Trajectory& motion) {
  LoopWorkspace<double> workspace(motion.model());
  Numbers r(static_cast<std::size_t>(motion.model().loops().residuals)),
      A(static_cast<std::size_t>(motion.model().loops().rows) * last_v(motion).size());
  double most = 0;
  for (std::size_t k = 0; k < motion.size(); ++k) {
    loop_residual<double>(motion.model(), workspace, motion.q(k), r);
    loop_jacobian<double>(motion.model(), workspace, motion.q(k), A);
    for (const double open : r) most = std::max(most, std::abs(open));
    for (std::size_t row = 0; row * motion.v(k).size() < A.size(); ++row) {
      double slip = 0;
      for (std::size_t c = 0; c < motion.v(k).size(); ++c)
        slip += A[row * motion.v(k).size() + c] * motion.v(k)[c];
      most = std::max(most, std::abs(slip));
    }
  }
  return most;
}
TEST(ConservingSchemesWithLoops, HaveTheirOrders) {
  const std::pair<Description, int> mechanisms[]{
      {four_bar(), 10}, {bricard(), 10}, {gough(), 20}, {floating({0, -9.81, 0}), 4}};
  for (const auto& [description, steps_of_6] : mechanisms) {
    SCOPED_TRACE(description.name);
    const Closed at(description);
    const SimulationOptions options = driven_and_damped();
    const auto expect_order = [&](int order, double until, int n, const auto& run) {
      const Trajectory exact =
          simulate(at.model, at.at.q, at.at.v, until, {.relative = 1e-12, .absolute = 1e-13}, options);
      SCOPED_TRACE(order);
      const auto error = [&](int steps) {
        const Trajectory motion = run(until, until / steps);
        EXPECT_TRUE(motion.complete) << motion.stop_reason;
        EXPECT_LE(most_open(motion), 1e-11);
        return apart(at.model, last_q(exact), last_q(motion));
      };
      const double coarse = error(n), fine = error(2 * n);
      EXPECT_NEAR(std::log2(coarse / fine), order, 0.35);
    };
    const auto conserving = [&](int order, double until, int n) {
      expect_order(order, until, n, [&](double t, double h) {
        return simulate_symplectic(at.model, at.at.q, at.at.v, t, h, order, options);
      });
    };
    conserving(2, 0.1, 40), conserving(4, 0.1, 10), conserving(6, 0.4, steps_of_6);
    expect_order(4, 0.1, 10, [&](double t, double h) {
      return simulate_momenta(at.model, at.at.q, at.at.v, t, h, runge_kutta(4), options);
    });
  }
}

TEST(ConservingSchemesWithLoops, GoBackTheWayTheyCame) {
  for (const Description& description : {four_bar(), bricard(), floating({})})
    for (const int order : {2, 4}) {
      const Closed at(description);
      expect_way_back(at.model, at.at.q, at.at.v, 1e-10, 0.01,
                      [&](Span q, Span v) { return simulate_symplectic(at.model, q, v, 0.3, 2e-3, order); });
    }
}

TEST(ConservingSchemesWithLoops, KeepTheEnergyInABand) {
  const Closed at(bricard());
  const Trajectory motion = simulate_symplectic(at.model, at.at.q, at.at.v, 40, 2e-2);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_LE(energy_error(motion, 40), 1.5 * energy_error(motion, 10));
}

TEST(ConservingSchemesWithLoops, KeepTheMomentumOfWhatFloatsToRounding) {
  for (const Vec3<>& g : {Vec3<>{}, Vec3<>{0.3, -0.2, -9.81}}) {
    const Closed at(floating(g));
    Workspace<> workspace(at.model);
    const auto error = [&](const Trajectory& motion) {
      const Momentum<Hybrid> before = centroidal_momentum(at.model, workspace, motion.q(0), motion.v(0)),
                             after = centroidal_momentum(at.model, workspace, last_q(motion), last_v(motion));
      const Vec3<> weight = (at.model.total_mass() * motion.t().back()) * g;
      return (norm(after.l - before.l) + norm(after.p - before.p - weight)) / (1 + norm(weight));
    };
    EXPECT_LE(error(simulate_symplectic(at.model, at.at.q, at.at.v, 4, 2e-2)), 1e-13);
    EXPECT_LE(error(simulate_momenta(at.model, at.at.q, at.at.v, 4, 2e-2)), 1e-13);
    EXPECT_GT(error(simulate_fixed(at.model, at.at.q, at.at.v, 4, 2e-2)), 1e-12);
  }
}

/// A chain with one joint cut and replaced by a loop moves as the chain does.
TEST(ConservingSchemesWithLoops, CutJointsMoveAsTheTreeDoes) {
  Description tree{.name = "chain", .gravity = {0, -9.81, 0}, .bodies = {}, .frames = {}};
  const Vec3<> P[]{{0, 0, 0}, {1, 0, 0}, {1.5, 0.5, 0.3}, {2, 0, 1}};
  tree.bodies.push_back(bar("one", "ground", JointKind::revolute, {0, 0, 1}, P[0], P[1]));
  tree.bodies.push_back(bar("two", "one", JointKind::spherical, {}, P[1], P[2]));
  tree.bodies.push_back(bar("three", "two", JointKind::revolute, {0, 1, 0.5}, P[2], P[3]));
  Description cut = tree;
  cut.bodies[1].predecessor = "ground", cut.bodies[1].joint = {.kind = JointKind::free};
  cut.loops.push_back(
      {.name = "ball", .between = {"one", "two"}, .kind = LoopKind::spherical, .point = P[1]});
  const Model whole = ModelBuilder(tree).build(), parts = ModelBuilder(cut).build();
  const double h = 5e-3, until = 0.2;
  const auto hand = [&](const Model& model, double step) {
    const Trajectory motion = simulate_symplectic(model, neutral(model),
                                                  Numbers(static_cast<std::size_t>(model.nv())), until, step);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    Workspace<> workspace(model);
    std::vector<SE3<>> C(static_cast<std::size_t>(model.n_frames()));
    poses<double>(model, workspace, last_q(motion), C);
    return C[static_cast<std::size_t>(model.frame_index("three"))].r;
  };
  const Vec3<> end = hand(whole, h / 20);
  const double coarse = norm(hand(parts, h) - end), fine = norm(hand(parts, h / 2) - end);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.15);
  EXPECT_LE(coarse, 1e-2);
}

TEST(ConservingSchemesWithLoops, TakeWhatRollsOnMomentaAlone) {
  const Closed at(wheel(false, {1, 0, -9.81}));
  const Trajectory exact = simulate(at.model, at.at.q, at.at.v, 0.5, {.relative = 1e-11, .absolute = 1e-12});
  const auto error = [&](double step) {
    const Trajectory motion = simulate_momenta(at.model, at.at.q, at.at.v, 0.5, step);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_LE(most_open(motion), 1e-11);
    return apart(at.model, last_q(exact), last_q(motion));
  };
  EXPECT_NEAR(std::log2(error(0.02) / error(0.01)), 4, 0.35);
  EXPECT_EQ(
      message_of([&] { (void)simulate_symplectic(at.model, at.at.q, at.at.v, 0.5, 0.01); }),
      "loop \"contact\" is of kind \"rolling\", which method \"midpoint\" does not support; use rattle in "
      "absolute coordinates or an explicit method");
}

}  // namespace
}  // namespace closed_momenta
}  // namespace axode::test
