#include "axode/integration/driven/drive_sensitivities.hpp"

#include <gmock/gmock.h>

#include "axode/batch.hpp"
#include "tests/integration/driven_mechanisms.hpp"

/// Sensitivities of motions with drives that have states: they equal limits of differences of rollouts, also
/// where statuses of drives change, and forward derivatives, gradients and matrices agree with each other.
namespace axode::test {
namespace drive_sensitivities {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;
using Rows = Eigen::Matrix<double, -1, -1, Eigen::RowMajor>;

/// A motion of K steps of a mechanism with drives, and its sensitivities along random directions.
struct Motion {
  Model model;
  Numbers q, v, x, tau;
  std::size_t K;
  double step;
  DriveSystem drives;
  std::size_t nq, nv, nx, nu;
  Numbers dq, dv, dx, dtau, du;

  Motion(Model of, Numbers of_q, Numbers of_v, Numbers of_x, std::size_t steps, double length,
         std::uint64_t seed)
      : model(std::move(of)),
        q(std::move(of_q)),
        v(std::move(of_v)),
        x(std::move(of_x)),
        K(steps),
        step(length),
        drives(model),
        nq(q.size()),
        nv(v.size()),
        nx(drives.nx()),
        nu(drives.inputs().size()) {
    Random<double> random(seed + 5);
    const auto some = [&](std::size_t n) { return random_numbers(random, static_cast<int>(n)); };
    tau = some(K * nv);
    dq = some(nv);
    dv = some(nv);
    dx = some(nx);
    for (std::size_t k = 0; k < nx; ++k)
      if (drives.states()[k].unit == "Pa") dx[k] *= 1e3;
    dtau = some(K * nv);
    du.resize(K * nu);
  }

  /// The displacements and changes of all states from those of the motion, if its start and its forces are
  /// moved by eps times the directions.
  VectorXd moved(double eps, const Model& of) const {
    const auto plus = [eps](const Numbers& a, const Numbers& da) {
      return numbers(VectorXd(vector(a) + eps * vector(da)));
    };
    const auto run = [&](const Model& by, const Numbers& q_0, const Numbers& v_0, const Numbers& x_0,
                         const Numbers& forces) {
      std::array<Numbers, 3> out{Numbers((K + 1) * nq), Numbers((K + 1) * nv), Numbers((K + 1) * nx)};
      EXPECT_TRUE(batch::rollout<double>(by, q_0, v_0, forces, step, out[0], out[1], runge_kutta(4), 1, {},
                                         false, {}, {.x = x_0, .x_out = out[2]})
                      .ok());
      return out;
    };
    const auto from = run(model, q, v, x, tau);
    const Numbers by = numbers(VectorXd(eps * vector(dq)));
    const auto to = run(of, integrate(model, q, by), plus(v, dv), plus(x, dx), plus(tau, dtau));
    VectorXd all(static_cast<Eigen::Index>((K + 1) * (2 * nv + nx)));
    auto next = all.begin();
    for (std::size_t k = 0; k <= K; ++k)
      for (const double d :
           difference(model, Span(from[0]).subspan(k * nq, nq), Span(to[0]).subspan(k * nq, nq)))
        *next++ = d;
    for (const std::size_t part : {1UL, 2UL})
      for (std::size_t k = 0; k < to[part].size(); ++k) *next++ = to[part][k] - from[part][k];
    return all;
  }
  /// The limit of moved(eps)/eps for small eps; mechanism(eps) is the one whose inputs are moved.
  template <class F> VectorXd limit(const F& mechanism, double h) const {
    const auto at = [&](double eps) { return moved(eps, mechanism(eps)); };
    return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
  }
  VectorXd jvp() const {
    Numbers q_out((K + 1) * nv), v_out(q_out), x_out((K + 1) * nx);
    EXPECT_TRUE(rollout_jvp_with_drives(model, drives, 0, q, v, x, tau, step, {dq, dv, dx, dtau, du},
                                        {q_out, v_out, x_out})
                    .ok());
    q_out.insert(q_out.end(), v_out.begin(), v_out.end());
    q_out.insert(q_out.end(), x_out.begin(), x_out.end());
    return vector(q_out);
  }
  /// Expects that two results of jvp() agree, each state relative to its size.
  void expect_equal(const VectorXd& found, const VectorXd& expected, double tolerance) const {
    const std::size_t n = 2 * nv * (K + 1);
    for (Eigen::Index k = 0; k < found.size(); ++k) {
      const std::size_t i = static_cast<std::size_t>(k);
      const double size = i < n ? 1 : drives.states()[(i - n) % nx].nominal;
      EXPECT_NEAR(found[k], expected[k], tolerance * std::max(size, std::abs(expected[k]))) << k;
    }
  }
};

Motion random_motion(std::uint64_t seed, std::size_t K = 6) {
  const Driven at(seed);
  return Motion(at.model, at.q, at.v, at.x, K, 4e-3, seed);
}

TEST(DriveSensitivities, AreLimitsOfDifferences) {
  for_seeds(40, [](std::uint64_t seed) {
    const Motion motion = random_motion(seed);
    motion.expect_equal(motion.jvp(), motion.limit([&](double) { return motion.model; }, 1e-4), 2e-6);
  });
}

/// A wheel whose motor reaches its limits of voltage and current, and leaves them.
Description limited_motor() {
  Description d{.name = "wheel", .gravity = {}};
  d.bodies = {{.name = "wheel",
               .joint = {.name = "hinge", .kind = JointKind::revolute},
               .inertia = MassProperties{.mass = 1, .com = {}, .Theta = {1, 1, 0.05, 0, 0, 0}}}};
  d.drives = {motor_on("hinge")};
  return d;
}

/// At the limit of the current its rate jumps. A displacement of the current before has no effect after.
TEST(DriveSensitivities, KnowThatTheTimeOfAChangeDependsOnTheState) {
  Motion motion(ModelBuilder(limited_motor()).build(), {0.1}, {0.2}, {0.3}, 100, 2e-3, 3);
  motion.expect_equal(motion.jvp(), motion.limit([&](double) { return motion.model; }, 1e-5), 1e-6);
  const std::size_t K = motion.K;
  Numbers q(K + 1), v(q), x(q), A(9 * K), B(3 * K), C(3 * K);
  ASSERT_TRUE(rollout_derivatives_with_drives(motion.model, motion.drives, 0, motion.q, motion.v, motion.x,
                                              motion.tau, motion.step, {q, v, x, A, B, C})
                  .ok());
  std::size_t held = 0;
  for (std::size_t k = 1; k < K; ++k) {
    if (x[k + 1] != 3 || x[k] == 3) continue;
    ++held;  // the current reaches its limit in step k
    EXPECT_NEAR(A[9 * k + 8], 0, 1e-9);
  }
  EXPECT_GT(held, 0U);
}

TEST(DriveSensitivities, ByInputsAreLimitsOfDifferences) {
  Description d = controlled_pendulum();
  d.drives[0].parameters[4].second = 6;  // the limit
  Motion motion(ModelBuilder(d).build(), {-0.5}, {0.3}, {0.1, 0.9, -0.2}, 60, 1.9e-3, 1);
  ASSERT_EQ(motion.nu, 1U);
  std::ranges::fill(motion.du, 1.0);
  const auto moved = [&](double eps) {
    Description other = d;
    other.drives[0].input.values[0] += eps;
    return ModelBuilder(other).build();
  };
  motion.expect_equal(motion.jvp(), motion.limit(moved, 1e-5), 1e-6);
}

TEST(DriveSensitivities, MatricesAndGradientsAgreeWithTangents) {
  for_seeds(30, [](std::uint64_t seed) {
    Motion at = random_motion(seed, 1 + seed % 4);
    Random<double> random(seed);
    at.du = random_numbers(random, static_cast<int>(at.K * at.nu));
    const std::size_t n = 2 * at.nv + at.nx, K = at.K;
    const auto index = [](std::size_t k) { return static_cast<Eigen::Index>(k); };
    Numbers q((K + 1) * at.nq), v((K + 1) * at.nv), x((K + 1) * at.nx), A(K * n * n), B(K * n * at.nv),
        C(K * n * at.nu);
    ASSERT_TRUE(rollout_derivatives_with_drives(at.model, at.drives, 0, at.q, at.v, at.x, at.tau, at.step,
                                                {q, v, x, A, B, C})
                    .ok());
    const VectorXd jvp = at.jvp();
    VectorXd z(index(n)), all(jvp.size()), size;
    z << vector(at.dq), vector(at.dv), vector(at.dx);
    for (std::size_t k = 0; k <= K; ++k) {
      all.segment(index(k * at.nv), index(at.nv)) = z.head(index(at.nv));
      all.segment(index((K + 1 + k) * at.nv), index(at.nv)) = z.segment(index(at.nv), index(at.nv));
      all.segment(index(2 * (K + 1) * at.nv + k * at.nx), index(at.nx)) = z.tail(index(at.nx));
      if (k == K) break;
      const auto part = [&](const Numbers& of, std::size_t width) {
        return Eigen::Map<const Rows>(of.data() + k * n * width, index(n), index(width));
      };
      const auto row = [&](const Numbers& of, std::size_t width) {
        return Eigen::Map<const VectorXd>(of.data() + k * width, index(width));
      };
      z = (part(A, n) * z + part(B, at.nv) * row(at.dtau, at.nv) + part(C, at.nu) * row(at.du, at.nu)).eval();
    }
    at.expect_equal(all, jvp, 1e-9);

    Numbers w_q = random_numbers(random, static_cast<int>((K + 1) * at.nv)),
            w_v = random_numbers(random, static_cast<int>((K + 1) * at.nv)),
            w_x = random_numbers(random, static_cast<int>((K + 1) * at.nx));
    for (std::size_t k = 0; k < w_x.size(); ++k) w_x[k] /= at.drives.states()[k % at.nx].nominal;
    Numbers by_q(at.nv), by_v(at.nv), by_x(at.nx), by_tau(K * at.nv), by_u(K * at.nu);
    ASSERT_TRUE(rollout_vjp_with_drives(at.model, at.drives, 0, at.q, at.v, at.x, at.tau, at.step,
                                        {w_q, w_v, w_x}, {by_q, by_v, by_x, by_tau, by_u})
                    .ok());
    VectorXd w(jvp.size());
    w << vector(w_q), vector(w_v), vector(w_x);
    const auto inner = [](const Numbers& a, const Numbers& b) { return vector(a).dot(vector(b)); };
    EXPECT_NEAR(inner(by_q, at.dq) + inner(by_v, at.dv) + inner(by_x, at.dx) + inner(by_tau, at.dtau) +
                    inner(by_u, at.du),
                w.dot(jvp), 1e-9 * (1 + w.cwiseAbs().dot(jvp.cwiseAbs())));
  });
}

TEST(DriveSensitivities, RefuseWhatTheyDoNotCount) {
  const Motion at(ModelBuilder(controlled_pendulum()).build(), {0.1}, {0.0}, {}, 2, 1e-2, 1);
  Numbers q(3), v(3), x(9), A(50), B(10), C(10);
  const auto refuses = [](const char* why) {
    return testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(why));
  };
  const auto call = [&](const Motion& of, Span x_0, const DriveRolloutDerivatives& out) {
    return rollout_derivatives_with_drives(of.model, of.drives, 0, of.q, of.v, x_0, of.tau, of.step, out);
  };
  EXPECT_TRUE(call(at, {}, {q, v, x, A, B, C}).ok());
  EXPECT_EQ(x[1], 0.4);  // the controller starts its filter at the error
  const Numbers two(2), bad{0, std::nan(""), 0};
  EXPECT_THAT(
      [&] {
        static_cast<void>(call(at, two, {q, v, x, A, B, C}));
      },
      refuses("x has 2 entries; expected nx = 3"));
  EXPECT_THAT(
      [&] {
        static_cast<void>(call(at, bad, {q, v, x, A, B, C}));
      },
      refuses("x of \"controller.filter\" is not finite"));
  EXPECT_THAT(
      [&] {
        static_cast<void>(call(at, {}, {q, v, x, A, B, A}));
      },
      refuses("out.C has 50 entries; expected K (2nv + nx) nu = 10"));
  const std::function<bool()> stop = [] { return false; };
  EXPECT_TRUE(rollout_derivatives_with_drives(at.model, at.drives, 0, at.q, at.v, {}, at.tau, at.step,
                                              {q, v, x, A, B, C}, {}, runge_kutta(4), stop)
                  .not_finite);
  EXPECT_TRUE(std::isnan(q[0]));
  Description crossed = controlled_pendulum();
  crossed.loops.push_back({.between = {"rod", "ground"}, .axis = {0, 1, 0}, .point = {0, 0, 0}});
  const Motion closed(ModelBuilder(crossed).build(), {0.0}, {0.0}, {}, 2, 1e-2, 1);
  EXPECT_THAT(
      [&] {
        static_cast<void>(call(closed, {}, {q, v, x, A, B, C}));
      },
      refuses("rollout_derivatives_with_drives does not count loops"));
}

}  // namespace
}  // namespace drive_sensitivities
}  // namespace axode::test
