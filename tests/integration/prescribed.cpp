#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <numbers>

#include "axode/constraints.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/methods.hpp"
#include "axode/io.hpp"
#include "tests/integration/motions.hpp"

/// Joints and rods that follow functions of time: their forces, their power, and where they cannot be
/// followed.
namespace axode::test {
namespace {

using Eigen::VectorXd;
using testing::HasSubstr;
using testing::ThrowsMessage;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A wave with the value s and the rate ds at 0.
MotionFunction wave(double s, double ds, double curvature, double frequency = 3) {
  return MotionFunction([=](double t) {
    const double w = frequency, sine = std::sin(w * t), cosine = std::cos(w * t), c = curvature;
    return MotionValue{s + ds * sine / w + c * (1 - cosine), ds * cosine + c * w * sine,
                       -ds * w * sine + c * w * w * cosine, -ds * w * w * cosine - c * w * w * w * sine};
  });
}
/// Waves that some joints of one velocity follow from a state on, at least one if there is such a joint.
std::vector<PrescribedMotion> waves(const Model& model, const State<double>& state, Random<double>& random) {
  std::vector<PrescribedMotion> motions;
  for (const Joint& joint : model.joints()) {
    if (joint.nv != 1 || (!motions.empty() && random.number(0, 1) < 0.5)) continue;
    motions.push_back(
        {joint.name, wave(state.q[static_cast<std::size_t>(joint.iq)],
                          state.v[static_cast<std::size_t>(joint.iv)], random.number(-0.2, 0.2))});
  }
  return motions;
}

/// M_ff a_f = τ_f - h_f - M_fp s'', and the forces are M a + h - τ of the joints p.
TEST(PrescribedMotions, OfTreesTakeTheForcesThatThePartitionOfTheMassMatrixGives) {
  int tested = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    const Mover mover(seed);
    const Model& model = mover.model;
    Random<double> random(seed);
    const std::vector<PrescribedMotion> motions = waves(model, mover.state, random);
    const Eigen::Index nv = model.nv();
    if (motions.empty()) continue;
    ++tested;
    VectorXd tau(nv), h(nv), a = VectorXd::Zero(nv);
    for (double& x : tau) x = random.number(-1, 1);
    Matrix M(nv, nv);
    Workspace<> workspace(model);
    mass_matrix(model, workspace, mover.state.q, as_span(M));
    inverse_dynamics(model, workspace, mover.state.q, mover.state.v, as_span(a), as_span(h));
    std::vector<int> held, free;
    for (int c = 0; c < nv; ++c) free.push_back(c);
    for (const PrescribedMotion& motion : motions) {
      const int c = model.joint(model.joint_index(motion.of)).iv;
      held.push_back(c);
      std::erase(free, c);
      a[c] = motion.function(0).dds;
    }
    const Matrix M_ff = M(free, free);
    const VectorXd known = tau - h - M * a;
    if (!free.empty()) {
      const VectorXd a_free = M_ff.ldlt().solve(VectorXd(known(free)));
      a(free) = a_free;
    }
    const VectorXd forces = (M * a + h - tau)(held);
    const DynamicsAtTime found =
        forward_dynamics_at(model, 0, mover.state.q, mover.state.v, as_span(tau), {}, motions);
    ASSERT_TRUE(found.solvability.ok());
    const double size = 1 + a.norm(), size_of_forces = 1 + forces.norm() + h.norm();
    EXPECT_LT((as_eigen(Span(found.a)) - a).norm(), 1e-9 * size);
    EXPECT_LT((as_eigen(Span(found.motion_forces)) - forces).norm(), 1e-9 * size_of_forces);
  }
  EXPECT_GT(tested, 30);
}

/// A method of integration with the coordinates in which it is tested, and its order.
struct WayToFollow {
  std::string_view method;
  Coordinates coordinates = Coordinates::relative;
  double order = 0;

  Trajectory run(const Model& model, Span q, Span v, double until, double step,
                 SimulationOptions options = {}) const {
    options.coordinates = coordinates;
    const auto row = std::ranges::find(methods, method, [](const auto& it) { return it.first; });
    return row->second.simulate({.model = model,
                                 .q = q,
                                 .v = v,
                                 .until = until,
                                 .step = row->second.adapts ? 0 : step,
                                 .tolerances = {.relative = 1e-11, .absolute = 1e-12},
                                 .spectral_radius = 0.8,
                                 .options = options});
  }
};
constexpr WayToFollow ways_to_follow[]{{"dopri5"},
                                       {"rk4", Coordinates::relative, 4},
                                       {"euler", Coordinates::relative, 1},
                                       {"generalized_alpha", Coordinates::relative, 2},
                                       {"midpoint", Coordinates::relative, 2},
                                       {"suzuki4", Coordinates::relative, 4},
                                       {"kahan_li6", Coordinates::relative, 6},
                                       {"rk4_momenta", Coordinates::relative, 4},
                                       {"contact", Coordinates::relative, 2},
                                       {"contact_exact"},
                                       {"dopri5", Coordinates::absolute},
                                       {"rk4", Coordinates::absolute, 4},
                                       {"rk4", Coordinates::absolute_SO3xR3, 4},
                                       {"rattle", Coordinates::absolute, 2},
                                       {"rattle", Coordinates::absolute_SO3xR3, 2},
                                       {"rattle_suzuki4", Coordinates::absolute, 4},
                                       {"rattle_kahan_li6", Coordinates::absolute_SO3xR3, 6},
                                       {"half_explicit", Coordinates::absolute, 3},
                                       {"generalized_alpha", Coordinates::absolute, 2},
                                       {"generalized_alpha_index3", Coordinates::absolute, 2}};

/// The sum of force times rate of all motions.
double power_at(const Trajectory& motion, const std::vector<PrescribedMotion>& motions, double t) {
  const Model& model = motion.model();
  Numbers q(static_cast<std::size_t>(model.nq())), v(static_cast<std::size_t>(model.nv())), tau(v);
  motion.at(t, q, v);
  Workspace<> workspace(model, cut_tree);
  spring_forces<double>(model, workspace, q, v, tau);
  const DynamicsAtTime found = forward_dynamics_at(model, t, q, v, tau, {}, motions);
  double power = 0;
  for (std::size_t k = 0; k < motions.size(); ++k)
    power += found.motion_forces[k] * motions[k].function(t).ds;
  return power;
}
double energy_at(const Trajectory& motion, std::size_t k) {
  Workspace<> workspace(motion.model(), cut_tree);
  return kinetic_energy<double>(motion.model(), workspace, motion.q(k), motion.v(k)) +
         potential_energy<double>(motion.model(), workspace, motion.q(k)) +
         elastic_energy<double>(motion.model(), workspace, motion.q(k));
}

TEST(PrescribedMotions, AreFollowedAndTheirPowerIsTheChangeOfTheEnergy) {
  int tested = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    const Mover mover(seed);
    Random<double> random(seed);
    SimulationOptions options;
    options.motions = waves(mover.model, mover.state, random);
    if (options.motions.empty()) continue;
    ++tested;
    const double end = 0.2;
    // The orders of methods are tested below.
    const WayToFollow& way =
        seed % 3 == 0   ? ways_to_follow[0]
        : seed % 3 == 1 ? *std::ranges::find(ways_to_follow, "kahan_li6", &WayToFollow::method)
                        : *std::ranges::find(ways_to_follow, "rattle_kahan_li6", &WayToFollow::method);
    SCOPED_TRACE(way.method);
    const Trajectory motion = way.run(mover.model, mover.state.q, mover.state.v, end, 1e-3, options);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    for (std::size_t k = 0; k < motion.size(); ++k)
      for (const PrescribedMotion& it : options.motions) {
        const Joint& joint = mover.model.joint(mover.model.joint_index(it.of));
        const MotionValue s = it.function(motion.t()[k]);
        EXPECT_NEAR(motion.q(k)[static_cast<std::size_t>(joint.iq)], s.s, 1e-12 * (1 + std::abs(s.s)));
        EXPECT_NEAR(motion.v(k)[static_cast<std::size_t>(joint.iv)], s.ds, 1e-11 * (1 + std::abs(s.ds)));
      }
    double work = 0, most = 0;  // by Gauss' rule of three points in parts of each step
    for (std::size_t k = 1; k < motion.size(); ++k)
      for (int part = 0; part < 2; ++part) {
        const double h = (motion.t()[k] - motion.t()[k - 1]) / 2,
                     middle = motion.t()[k - 1] + (part + 0.5) * h, x = std::sqrt(0.15) * h;
        const double outer = power_at(motion, options.motions, middle - x) +
                             power_at(motion, options.motions, middle + x),
                     inner = power_at(motion, options.motions, middle);
        work += h / 18 * (5 * outer + 8 * inner);
        most = std::max(most, std::abs(inner));
      }
    const double gained = energy_at(motion, motion.size() - 1) - energy_at(motion, 0);
    EXPECT_NEAR(gained, work, 1e-7 * (most * end + std::abs(energy_at(motion, 0))));
  }
  EXPECT_GT(tested, 6);
}

TEST(PrescribedMotions, LeaveTheMomentaOfAFloatingMechanismAsTheyAre) {
  const Model model = test_tree({});
  const State<double> state = test_state(model);
  const Joint& door = model.joint(model.joint_index("door joint"));
  SimulationOptions options;
  options.motions = {{door.name, wave(state.q[static_cast<std::size_t>(door.iq)],
                                      state.v[static_cast<std::size_t>(door.iv)], 0.3)}};
  Workspace<> workspace(model);
  const auto momentum = [&](Span q, Span v) {
    const auto& [l, p] = spatial_momentum<double>(model, workspace, q, v);
    return Eigen::Vector<double, 6>{l.x, l.y, l.z, p.x, p.y, p.z};
  };
  for (const char* method : {"midpoint", "kahan_li6", "rk4_momenta", "contact"}) {
    const WayToFollow& way =
        *std::ranges::find(ways_to_follow, std::string_view(method), &WayToFollow::method);
    const Trajectory motion = way.run(model, state.q, state.v, 2, 0.02, options);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    const auto before = momentum(state.q, state.v);
    EXPECT_LE((momentum(last_q(motion), last_v(motion)) - before).norm(), 1e-12 * before.norm()) << method;
  }
}

/// A slider-crank with a crank of 0.1 m and a rod of 0.4 m.
Description slider_crank() {
  const auto solid = [](double x) {
    return MassProperties{.mass = 0.5,
                          .com = {x, 0, 0},
                          .Theta = {0.01, 0.01, 0.01, 0, 0, 0},
                          .in = GivenIn::construction_frame};
  };
  return {.name = "slider-crank",
          .gravity = {0, -9.81, 0},
          .bodies = {{.name = "crank",
                      .joint = {.name = "turn", .kind = JointKind::revolute},
                      .inertia = solid(0.05)},
                     {.name = "rod",
                      .predecessor = "crank",
                      .joint = {.name = "knee", .kind = JointKind::revolute, .point = {0.1, 0, 0}},
                      .inertia = solid(0.3)},
                     {.name = "slider",
                      .joint = {.name = "slide", .kind = JointKind::prismatic, .axis = {1, 0, 0}},
                      .inertia = solid(0.5)}},
          .loops = {{.name = "pin", .between = {"rod", "slider"}, .point = {0.5, 0, 0}}}};
}
Model built(Description d) { return ModelBuilder(std::move(d)).build(); }

/// The slider-crank with the crank at an angle.
AssemblyResult bent(const Model& model, double angle) {
  Numbers q = neutral(model), rest(static_cast<std::size_t>(model.nv()));
  q[0] = angle, q[1] = -std::asin(0.25 * std::sin(angle)) - angle;
  const std::vector<int> held{0};
  AssemblyResult found = assemble(built(slider_crank()), q, rest, {.held = held});
  EXPECT_EQ(found.status, AssemblyStatus::closed);
  return found;
}

TEST(PrescribedMotions, ThatCannotBeFollowedEndAtTheFoldAndNameIt) {
  Description d = slider_crank();
  const double start = bent(built(d), 1).q[2];  // the slider moves out at 0.1 m/s and is stretched at 0
  d.motions = {{.of = "slide", .kind = MotionDescription::Kind::polynomial, .coefficients = {start, 0.1}}};
  const Model model = built(d);
  const AssemblyResult first = assemble(model, bent(model, 1).q, bent(model, 1).v);
  ASSERT_EQ(first.status, AssemblyStatus::closed);
  const double fold = -start / 0.1;
  const Trajectory motion = simulate(model, first.q, first.v, 2 * fold);
  EXPECT_FALSE(motion.complete);
  EXPECT_NEAR(motion.t().back(), fold, 1e-3);
  EXPECT_THAT(motion.stop_reason,
              HasSubstr("the motion of \"slide\" would need speeds and forces without bound"));
  EXPECT_THAT(motion.stop_reason, HasSubstr("\"turn\" and \"knee\" would move without it"));
  for (const WayToFollow& way : ways_to_follow) {
    SCOPED_TRACE(std::string(way.method) + " in coordinates " + std::string(to_string(way.coordinates)));
    const Trajectory ended = way.run(model, first.q, first.v, 2 * fold, fold / 200);
    EXPECT_FALSE(ended.complete);
    EXPECT_NEAR(ended.t().back(), fold, fold / 100);
    EXPECT_THAT(ended.stop_reason,
                HasSubstr("the motion of \"slide\" would need speeds and forces without bound"));
  }

  const KinematicMotion still = kinematic_motion(model, first.q, Numbers{0, fold / 2, 2 * fold});
  EXPECT_FALSE(still.complete);
  EXPECT_NEAR(still.reached, fold, 1e-8);
  EXPECT_EQ(still.t.size(), 3U);
  EXPECT_THAT(still.stop_reason,
              HasSubstr("the motion of \"slide\" would need speeds and forces without bound"));
}

/// Far from 0 a step of time may be below the resolution of the time.
TEST(PrescribedMotions, ThatCannotBeFollowedEndAtAnyTime) {
  Description d = slider_crank();
  const double start = bent(built(d), 1).q[2], begin = 1e6;
  const Model tree = built(d);
  const std::vector<PrescribedMotion> out{{"slide", MotionFunction([=](double t) {
                                             return MotionValue{start + 1e3 * (t - begin), 1e3, 0, 0};
                                           })}};
  const Numbers times{begin, begin + 1e-3};
  const KinematicMotion motion = kinematic_motion(tree, bent(tree, 1).q, times, out);
  EXPECT_FALSE(motion.complete);
  EXPECT_LT(motion.reached, times[1]);
  int asked = 0;
  const KinematicMotion ended =
      kinematic_motion(tree, bent(tree, 1).q, times, out, [&] { return ++asked < 2; });
  EXPECT_EQ(asked, 2);
  EXPECT_EQ(ended.stop_reason, "it was interrupted");
}

TEST(PrescribedMotions, ThatContradictEachOtherEndTheMotion) {
  Description d = slider_crank();
  const AssemblyResult start = bent(built(d), 1);
  for (const double acceleration : {1.0, 1e160, 1e300}) {  // squares above 1e154 are not representable
    d.motions = {{.of = "turn", .coefficients = {start.q[0], 0, acceleration}},
                 {.of = "slide", .coefficients = {start.q[2]}}};
    const Trajectory motion = simulate(built(d), start.q, start.v, 1);
    EXPECT_FALSE(motion.complete);
    EXPECT_THAT(motion.stop_reason,
                HasSubstr("the loops and the other motions do not allow the prescribed motion of \""))
        << acceleration;
  }
  d.motions[0].coefficients = {start.q[0]};  // both rest
  const Trajectory rests = simulate(built(d), start.q, start.v, 0.1);
  EXPECT_TRUE(rests.complete) << rests.stop_reason;
  EXPECT_EQ(rests.q(rests.size() - 1)[0], rests.q(0)[0]);
}

TEST(PrescribedMotions, EndStepsWhereTheirThirdDerivativesJump) {
  Description d = slider_crank();
  d.motions = {{.of = "turn",
                .kind = MotionDescription::Kind::ramp,
                .from = 0.5,
                .to = 2.5,
                .start = 0.1,
                .end = 0.437}};
  const Model model = built(d);
  const AssemblyResult start = assemble(model, bent(model, 0.5).q, bent(model, 0.5).v);
  const auto run = [&](double step) {
    return simulate_fixed(model, start.q, start.v, 0.5, step, runge_kutta(4));
  };
  const Trajectory adapted = simulate(model, start.q, start.v, 0.5, {.relative = 1e-12, .absolute = 1e-13});
  const auto end = [](const Trajectory& motion) { return motion.q(motion.size() - 1)[0]; };
  EXPECT_NEAR(end(adapted), 2.5, 1e-12);
  for (const Trajectory& motion : {adapted, run(0.03)})
    for (const double jump : {0.1, 0.437})
      EXPECT_TRUE(std::ranges::find(motion.t(), jump) != motion.t().end()) << jump;
}

TEST(PrescribedMotions, HaveTheOrderOfTheMethod) {
  Description d = slider_crank();
  d.bodies.push_back({.name = "bob",
                      .predecessor = "slider",
                      .joint = {.name = "swing", .kind = JointKind::revolute, .point = {0.5, 0, 0}},
                      .inertia = MassProperties{.mass = 0.3,
                                                .com = {0.5, -0.2, 0},
                                                .Theta = {0.001, 0.001, 0.001, 0, 0, 0},
                                                .in = GivenIn::construction_frame}});
  d.motions = {{.of = "turn",
                .kind = MotionDescription::Kind::ramp,
                .from = 0.5,
                .to = 4.5,
                .start = 0.1,
                .end = 0.437}};
  const Model model = built(d);
  Numbers q = bent(built(slider_crank()), 0.5).q;
  q.push_back(0);
  const AssemblyResult start = assemble(model, q, Numbers(4));
  const Trajectory exact = simulate(model, start.q, start.v, 0.5, {.relative = 1e-12, .absolute = 1e-13});
  for (const WayToFollow& way : ways_to_follow) {
    SCOPED_TRACE(std::string(way.method) + " in coordinates " + std::string(to_string(way.coordinates)));
    const auto error = [&](double step) {
      const Trajectory motion = way.run(model, start.q, start.v, 0.5, step);
      EXPECT_TRUE(motion.complete) << motion.stop_reason;
      return apart(model, last_q(motion), last_q(exact)) +
             (as_eigen(last_v(motion)) - as_eigen(last_v(exact))).norm();
    };
    const double step = way.order > 4 ? 0.02 : 0.0025;
    if (way.order == 0)
      EXPECT_LT(error(0), 1e-7);
    else
      EXPECT_NEAR(std::log2(error(step) / error(step / 2)), way.order, 0.4) << error(step);
  }
}

TEST(PrescribedMotions, OfSamplesFollowTheirSpline) {
  Description d = slider_crank();
  const auto s = [](double t) { return 1 + 0.4 * std::sin(2 * t); };
  MotionDescription sampled{.of = "turn", .kind = MotionDescription::Kind::samples};
  for (int k = 0; k <= 60; ++k) sampled.times.push_back(0.02 * k), sampled.values.push_back(s(0.02 * k));
  MotionDescription harmonic{.of = "turn",
                             .kind = MotionDescription::Kind::harmonic,
                             .offset = 1,
                             .amplitude = 0.4,
                             .frequency = 1 / std::numbers::pi};
  const auto end_of = [&](const MotionDescription& motion) {
    d.motions = {motion};
    const Model model = built(d);
    const AssemblyResult start = assemble(model, bent(model, 1).q, bent(model, 1).v);
    return simulate(model, start.q, start.v, 1, {.relative = 1e-10, .absolute = 1e-11});
  };
  const Trajectory one = end_of(sampled), other = end_of(harmonic);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(one.q(one.size() - 1)[c], other.q(other.size() - 1)[c], 1e-8);
    EXPECT_NEAR(one.v(one.size() - 1)[c], other.v(other.size() - 1)[c], 1e-7);
  }
  d.motions = {sampled};
  const Model model = built(d);
  const AssemblyResult start = assemble(model, bent(model, 1).q, bent(model, 1).v);
  EXPECT_THAT([&] { return simulate(model, start.q, start.v, 3); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("is known from 0 s to 1.2 s")));
}

TEST(PrescribedMotions, AreRefusedWhereTheyAreNotCountedAndWhereTheyCannotStart) {
  Description d = slider_crank();
  const AssemblyResult start = bent(built(d), 1);
  d.motions = {{.of = "turn", .coefficients = {1, 2}}};
  const Model model = built(d);
  const auto refuses = [](const std::string& part) {
    return ThrowsMessage<std::invalid_argument>(HasSubstr(part));
  };
  EXPECT_THAT([&] { return simulate(model, start.q, start.v, 1); },
              refuses("v does not keep loop \"motion of turn\" closed"));
  EXPECT_THAT([&] { return equilibrium(model, start.q); },
              refuses("equilibrium does not count prescribed motions"));
  SimulationOptions second;
  second.motions = {{"turn", wave(1, 0, 0)}};
  EXPECT_THAT([&] { return simulate(model, start.q, start.v, 1, {}, second); },
              refuses("\"turn\" has two motions"));
  const MotionFunction samples(
      {.of = "turn", .kind = MotionDescription::Kind::samples, .times = {0, 1, 2}, .values = {1, 1, 1}});
  for (const double t : {-1.0, 3.0, std::nan("")})
    EXPECT_THROW(static_cast<void>(forward_dynamics_at(built(slider_crank()), t, start.q, start.v, Numbers(3),
                                                       {}, std::vector{PrescribedMotion{"turn", samples}})),
                 std::invalid_argument)
        << t;
  second.motions = {{"trun", wave(1, 0, 0)}};
  EXPECT_THAT([&] { return simulate(model, start.q, start.v, 1, {}, second); },
              refuses("has no joint and no rod \"trun\"; did you mean \"turn\"?"));
  EXPECT_THAT(
      [&] {
        return kinematic_motion(built(slider_crank()), start.q, Numbers{0, 1});
      },
      refuses("the motions leave the mechanism 1 velocity;"));
  EXPECT_THAT(
      [&] {
        return kinematic_motion(model, neutral(model), Numbers{0, 1});
      },
      refuses("q is not near a configuration"));
}

}  // namespace
}  // namespace axode::test
