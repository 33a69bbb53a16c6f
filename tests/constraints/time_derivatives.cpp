#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "axode/constraints.hpp"
#include "axode/constraints/higher_order/constrained_rates.hpp"
#include "axode/constraints/higher_order/inverse_kinematics_rates.hpp"
#include "axode/constraints/higher_order/loop_series.hpp"
#include "axode/constraints/loop_system/independent_rows.hpp"
#include "axode/kinematics.hpp"
#include "axode/recursion/least_squares.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/kinematics/derivatives.hpp"
#include "tests/support/random_loops.hpp"
#include "tests/support/refused_arguments.hpp"

/// Motions of mechanisms with loops of all kinds, their drive forces, and the time derivatives of both.
namespace axode::test {
namespace {

constexpr int orders = 6;  // of the velocities: v, v', ...
using MotionInTime = Taylor<double, orders + 2>;

/// A closed mechanism and random derivatives of its velocities, each of which keeps the loops closed.
struct ClosedMotionInTime {
  explicit ClosedMotionInTime(std::uint64_t seed)
      : random(seed),
        closed(closed_mechanism(random, {.most_bodies = 7, .springs = 0})),
        model(closed.model),
        q(closed.state.q),
        workspace(model),
        nv(static_cast<std::size_t>(model.nv())),
        rates(orders * nv) {
    LoopSystem<double>& system = workspace.system(model);
    system.update_kinematics(q.data());
    system.make_rows(ConstraintLevel::velocity);
    static_cast<void>(system.factorize(q.data()));
    const Eigen::MatrixXd N = IndependentRows<double>(system, ConstraintLevel::velocity).kernel();
    LoopSeries loops(model, orders - 1);
    for (int k = 0; k < orders; ++k) {
      loops.run(q.data(), rates.data());
      const Eigen::VectorXd own =
          least_squares(loops.derivative(0), -loops.known_terms(rates.data(), k), 1e-9);
      const Eigen::VectorXd free = vector(random_numbers(random, static_cast<int>(N.cols())));
      std::ranges::copy(numbers(Eigen::VectorXd(own + product(N, free))),
                        rates.begin() + k * std::ssize(row(0)));
    }
    std::vector<MotionInTime> v(nv);
    double factorial = 1;
    for (int k = 0; k < orders; ++k) {
      if (k > 1) factorial *= k;
      for (std::size_t c = 0; c < nv; ++c) v[c].c[static_cast<std::size_t>(k)] = row(k)[c] / factorial;
    }
    v_t = v, q_t = flow(model, q, v);
  }
  std::span<const double> row(int k) const {
    return std::span(rates).subspan(static_cast<std::size_t>(k) * nv, nv);
  }
  /// The value of a series, or of its derivative, at a time.
  static std::vector<double> at(const std::vector<MotionInTime>& series, double t, int derivative = 0) {
    std::vector<double> x;
    for (const MotionInTime& s : series) {
      double sum = 0;
      for (int k = orders + 1; k >= derivative; --k) {
        double factor = 1;
        for (int j = 0; j < derivative; ++j) factor *= k - j;
        sum = sum * t + factor * s.c[static_cast<std::size_t>(k)];
      }
      x.push_back(sum);
    }
    return x;
  }
  /// How large the derivatives are, as factors of powers of time.
  double rate() const {
    double largest = 1;
    for (int k = 0; k < orders; ++k)
      for (const double x : row(k)) largest = std::max(largest, std::pow(std::abs(x), 1.0 / (k + 1)));
    return largest;
  }
  std::vector<int> all_drives() const {
    std::vector<int> all;
    for (int c = 0; c < model.nv(); ++c) all.push_back(c);
    return all;
  }

  Random<double> random;
  ClosedMechanism closed;
  const Model& model;
  std::vector<double> q;
  LoopWorkspace<> workspace;
  std::size_t nv;
  std::vector<double> rates;
  std::vector<MotionInTime> q_t, v_t;
};

TEST(TimeDerivativesWithLoops, OfVelocitiesKeepLoopsClosed) {
  Comparison rows("A", 1e-12), residual("residual", 1e-9);
  for_seeds(60, [&](std::uint64_t seed) {
    ClosedMotionInTime motion(seed);
    LoopSeries loops(motion.model, 2);
    loops.run(motion.q.data(), motion.rates.data());
    std::vector<double> A(static_cast<std::size_t>(motion.model.loops().rows) * motion.nv);
    loop_jacobian(motion.model, motion.workspace, motion.q, A);
    rows.expect_equal(loops.derivative(0), matrix(motion.model.loops().rows, A), 1);
    const double t = 0.03 / motion.rate();
    std::vector<double> r(static_cast<std::size_t>(motion.model.loops().residuals));
    for (const double there : {t, -t}) {
      loop_residual(motion.model, motion.workspace, ClosedMotionInTime::at(motion.q_t, there), r);
      residual.expect_equal(r, std::vector<double>(r.size()), 1);
    }
  });
}

TEST(TimeDerivativesWithLoops, OfRowsAreLimitsOfDifferences) {
  Comparison first("A'", 1e-7), second("A''", 1e-6);
  for_seeds(60, [&](std::uint64_t seed) {
    ClosedMotionInTime motion(seed);
    LoopSeries loops(motion.model, 2);
    loops.run(motion.q.data(), motion.rates.data());
    const int m = motion.model.loops().rows;
    const double h = 2e-3 / motion.rate();
    const auto rows_at = [&](double t) {
      std::vector<double> A(static_cast<std::size_t>(m) * motion.nv);
      loop_jacobian(motion.model, motion.workspace, ClosedMotionInTime::at(motion.q_t, t), A);
      return matrix(m, A);
    };
    const Eigen::MatrixXd b2 = rows_at(-2 * h), b = rows_at(-h), here = rows_at(0), a = rows_at(h),
                          a2 = rows_at(2 * h);
    const double size = motion.rate();
    first.expect_equal(loops.derivative(1), Eigen::MatrixXd((8 * (a - b) - (a2 - b2)) / (12 * h)), size);
    second.expect_equal(loops.derivative(2),
                        Eigen::MatrixXd((16 * (a + b) - (a2 + b2) - 30 * here) / (12 * h * h)), size * size);
  });
}

TEST(TimeDerivativesWithLoops, OfDriveForcesAreLimitsOfDifferences) {
  Comparison force("tau", 1e-9), first("tau'", 1e-6), second("tau''", 1e-5);
  for_seeds(60, [&](std::uint64_t seed) {
    ClosedMotionInTime motion(seed);
    const Model& model = motion.model;
    const std::vector<int> drives = motion.all_drives();  // more than needed: the least forces
    const Loads<> loads{.wrenches = motion.closed.state.wrenches};
    const auto forces_at = [&](double t) {
      std::vector<double> tau(motion.nv);
      EXPECT_LT(inverse_dynamics(model, motion.workspace, ClosedMotionInTime::at(motion.q_t, t),
                                 ClosedMotionInTime::at(motion.v_t, t),
                                 ClosedMotionInTime::at(motion.v_t, t, 1), tau, {}, drives, loads),
                1e-7);
      return vector(tau);
    };
    std::vector<double> tau(3 * motion.nv);
    EXPECT_LT(inverse_dynamics_rates(model, motion.workspace, motion.q,
                                     std::span<const double>(motion.rates).first(4 * motion.nv), tau, drives,
                                     loads),
              1e-9);
    const double h = 5e-3 / motion.rate(), size = motion.rate();
    const Eigen::VectorXd b2 = forces_at(-2 * h), b = forces_at(-h), here = forces_at(0), a = forces_at(h),
                          a2 = forces_at(2 * h);
    const auto row = [&](std::size_t k) {
      return std::vector<double>(tau.begin() + static_cast<std::ptrdiff_t>(k * motion.nv),
                                 tau.begin() + static_cast<std::ptrdiff_t>((k + 1) * motion.nv));
    };
    const double scale = std::max(1.0, here.lpNorm<Eigen::Infinity>());
    force.expect_equal(row(0), numbers(here), scale);
    first.expect_equal(row(1), numbers(Eigen::VectorXd((8 * (a - b) - (a2 - b2)) / (12 * h))), scale * size);
    second.expect_equal(row(2),
                        numbers(Eigen::VectorXd((16 * (a + b) - (a2 + b2) - 30 * here) / (12 * h * h))),
                        scale * size * size);
  });
}

/// A mechanism without drives needs no forces for the accelerations that it has by itself.
TEST(TimeDerivativesWithLoops, OfFreeMotionsMissNoForces) {
  int moved = 0;
  for_seeds(30, [&](std::uint64_t seed) {
    ClosedMotionInTime motion(seed);
    Description d = motion.model.description();
    for (BodyDescription& body : d.bodies) body.joint.passive = true;
    const Model model = ModelBuilder(d).build();
    LoopWorkspace<> workspace(model);
    std::vector<double> rates(motion.rates.begin(),
                              motion.rates.begin() + static_cast<std::ptrdiff_t>(motion.nv)),
        a(motion.nv), none(motion.nv), tau(motion.nv);
    const Loads<> loads{.wrenches = motion.closed.state.wrenches};
    ASSERT_TRUE(forward_dynamics(model, workspace, motion.q, rates, none, a, {}, loads).ok());
    rates.insert(rates.end(), a.begin(), a.end());
    EXPECT_EQ(inverse_dynamics_rates(model, workspace, motion.q, rates, tau, {}, loads), 0);
    EXPECT_EQ(tau, none);
    moved += vector(a).norm() > 0 ? 1 : 0;
  });
  EXPECT_GT(moved, 10);
}

/// The twists of all bodies determine all velocities.
TEST(TimeDerivativesWithLoops, OfVelocitiesFollowFromThoseOfTwists) {
  Comparison found("rates", 1e-8);
  for_seeds(60, [&](std::uint64_t seed) {
    ClosedMotionInTime motion(seed);
    const Model& model = motion.model;
    HigherOrderMotion<> wanted(model, orders - 1);
    wanted.evaluate(motion.q, motion.rates);
    std::vector<std::vector<TwistRate<Hybrid>>> V;
    std::vector<TwistTarget<Hybrid>> targets;
    for (int i = 1; i <= model.n_bodies(); ++i) {
      V.emplace_back();
      for (int k = 0; k < orders; ++k) V.back().push_back(wanted.twist_derivative<Hybrid>(i, k));
    }
    for (std::size_t i = 0; i < V.size(); ++i) targets.push_back({static_cast<int>(i + 1), V[i]});
    std::vector<double> rates(motion.rates.size());
    const RatesReached reached = inverse_kinematics_rates<Hybrid>(model, motion.q, targets, rates);
    ASSERT_EQ(reached.orders, orders) << reached.missing;
    for (int k = 0; k < orders; ++k) {
      const auto row = [&](std::span<const double> all) {
        const auto of_order = all.subspan(static_cast<std::size_t>(k) * motion.nv, motion.nv);
        return std::vector<double>(of_order.begin(), of_order.end());
      };
      found.expect_equal(row(rates), row(motion.rates), std::pow(motion.rate(), k + 1));
    }
  });
}

TEST(TimeDerivativesWithLoops, OfWrongArgumentsAreRefused) {
  const Model model = ModelBuilder(gough()).build();
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  LoopWorkspace<> workspace(model);
  const std::vector<double> q = neutral(model);
  std::vector<double> rates(3 * nv), tau(2 * nv);
  const std::vector<TwistRate<BodyFixed>> V(3);
  const TwistTarget<BodyFixed> target{"platform", V};
  const auto solve = [&](const TwistTarget<BodyFixed>& wanted, std::span<double> out) {
    static_cast<void>(inverse_kinematics_rates<BodyFixed>(model, q, std::span(&wanted, 1), out));
  };
  EXPECT_THAT(message_of([&] { solve(target, std::span(rates).first(nv + 1)); }),
              testing::HasSubstr("come in one or more rows of nv"));
  EXPECT_THAT(message_of([&] { solve(target, std::span(rates).first(2 * nv)); }),
              testing::HasSubstr("targets[0].V has 3"));
  EXPECT_THAT(message_of([&] {
                solve({"platfrom", V}, rates);
              }),
              testing::HasSubstr("did you mean \"platform\""));
  std::vector<TwistRate<BodyFixed>> not_finite = V;
  not_finite[1].v.x = NAN;
  EXPECT_THAT(message_of([&] { solve({"platform", not_finite}, rates); }), testing::HasSubstr("not finite"));
  std::vector<double> many(9 * nv);
  const std::vector<TwistRate<BodyFixed>> nine(9);
  EXPECT_THAT(message_of([&] {
                solve({"platform", nine}, many);
              }),
              testing::HasSubstr("with loops 8 are the most"));
  rates[2 * nv] = 1;  // of the platform alone
  EXPECT_THAT(message_of([&] { static_cast<void>(inverse_dynamics_rates(model, workspace, q, rates, tau)); }),
              testing::HasSubstr("row 2 does not keep loop"));
  rates[2 * nv] = NAN;
  EXPECT_THAT(message_of([&] { static_cast<void>(inverse_dynamics_rates(model, workspace, q, rates, tau)); }),
              testing::HasSubstr("rates is not finite"));
  EXPECT_THAT(message_of([&] { static_cast<void>(inverse_dynamics_rates(model, workspace, q, tau, tau)); }),
              testing::HasSubstr("rates has"));
}

TEST(TimeDerivativesWithLoops, StopWhereATwistIsOutOfReach) {
  Description d{.name = "planar arm", .bodies = {}, .frames = {}};
  d.bodies.push_back(bar("upper", "ground", JointKind::revolute, {0, 0, 1}, {0, 0, 0}, {1, 0, 0}));
  d.bodies.push_back(bar("lower", "upper", JointKind::revolute, {0, 0, 1}, {1, 0, 0}, {2, 0, 0}));
  d.frames.push_back({.name = "tip", .body = "lower", .pose = {{}, {2, 0, 0}}});
  const Model model = ModelBuilder(d).build();
  const std::vector<double> stretched{0, 0}, bent{0, 1};
  std::vector<double> rates(6);
  std::vector<TwistRate<Hybrid>> inwards(3);
  const TwistTarget<Hybrid> tip{.place = "tip", .V = inwards, .angular = false};
  for (const double acceleration : {1e300, 1e160, 1.0}) {  // squares above 1e154 are not representable
    inwards[1].v.x = -acceleration;
    const RatesReached reached =
        inverse_kinematics_rates<Hybrid>(model, stretched, std::span(&tip, 1), rates);
    EXPECT_EQ(reached.orders, 1) << acceleration;
    EXPECT_NEAR(reached.missing, 1, 1e-9) << acceleration;
    EXPECT_EQ(rates[0], 0);
    EXPECT_TRUE(std::isnan(rates[2]) && std::isnan(rates[5])) << acceleration;
  }
  const RatesReached reached = inverse_kinematics_rates<Hybrid>(model, bent, std::span(&tip, 1), rates);
  EXPECT_EQ(reached.orders, 3);
  EXPECT_EQ(reached.missing, 0);
}

}  // namespace
}  // namespace axode::test
