#include "axode/constraints/embedding/platform_placement.hpp"
#include "axode/constraints/embedding/task_rates.hpp"
#include "axode/drives/elastic_feed_forward.hpp"
#include "axode/io.hpp"
#include "tests/support/comparison.hpp"
#include "tests/support/refused_arguments.hpp"

/// Mechanisms with elastic drives follow a motion in open loop, by the forces that flatness gives to their
/// motors.
namespace axode::test {
namespace {

using Vector = std::vector<double>;

void add(Vector& to, double h, const Vector& from) {
  for (std::size_t k = 0; k < to.size(); ++k) to[k] += h * from[k];
}
/// One step of Runge-Kutta's method of order four. rate(t, x) is x'.
template <class Rate> void advance(Vector& x, double t, double h, const Rate& rate) {
  const auto moved = [&](double s, const Vector& by) {
    Vector y = x;
    add(y, s, by);
    return y;
  };
  const Vector a = rate(t, x), b = rate(t + h / 2, moved(h / 2, a)), c = rate(t + h / 2, moved(h / 2, b)),
               d = rate(t + h, moved(h, c));
  add(x, h / 6, a), add(x, h / 3, b), add(x, h / 3, c), add(x, h / 6, d);
}
Vector part(const Vector& x, std::size_t k, std::size_t n) {
  const auto first = x.begin() + static_cast<std::ptrdiff_t>(k * n);
  return {first, first + static_cast<std::ptrdiff_t>(n)};
}
Vector joined(std::initializer_list<Vector> parts) {
  Vector all;
  for (const Vector& x : parts) all.insert(all.end(), x.begin(), x.end());
  return all;
}

/// The forces u of a feed-forward without springs, Q + I a, from those with springs, Q + I (a + Q''/k).
enum class With { springs, rigid_motors };

/// An arm with a swing in each joint.
struct Arm {
  static constexpr double k = 2000, I = 0.3;  // N m/rad, kg m²
  Model model = load(AXODE_SOURCE_DIR "/examples/robots/arm7.toml");
  std::size_t n = static_cast<std::size_t>(model.nv());
  Workspace<> workspace{model};
  ElasticFeedForward elastic{model, std::vector<ElasticDrive>(n, {k, I})},
      rigid{model, std::vector<ElasticDrive>(n, {std::numeric_limits<double>::infinity(), I})};

  /// q and its derivatives of order 1 to 4, row by row.
  Vector motion(double t) const {
    Vector rows;
    for (int order = 0; order < 5; ++order)
      for (std::size_t j = 0; j < n; ++j) {
        const double rhythm = 3 + static_cast<double>((2 * j) % 5), phase = 0.7 * static_cast<double>(j);
        rows.push_back(0.45 * std::pow(rhythm, order) * std::sin(rhythm * t + phase + order * M_PI / 2));
      }
    return rows;
  }
  MotorMotion motors(double t, With with) {
    const Vector rows = motion(t);
    MotorMotion out;
    (with == With::springs ? elastic : rigid)
        .evaluate(std::span(rows).first(n), std::span(rows).subspan(n), out);
    return out;
  }
  /// The rate of (q, θ, v, θ').
  Vector rate(double t, const Vector& x, With with) {
    const Vector q = part(x, 0, n), v = part(x, 2, n), omega = part(x, 3, n), u = motors(t, with).force;
    Vector spring(n), a(n), alpha(n);
    for (std::size_t j = 0; j < n; ++j) {
      spring[j] = k * (x[n + j] - q[j]);
      alpha[j] = (u[j] - spring[j]) / I;
    }
    EXPECT_TRUE(forward_dynamics<Fast>(model, workspace, q, v, spring, a).ok());
    return joined({v, omega, a, alpha});
  }
  /// The largest error of a joint in rad, after a start on the motion.
  double largest_error(With with) {
    constexpr double step = 4e-4;
    const Vector at_start = motion(0);
    const MotorMotion start = motors(0, With::springs);
    Vector x = joined({part(at_start, 0, n), start.position, part(at_start, 1, n), start.velocity});
    double worst = 0;
    for (int s = 0; s < 500; ++s) {
      advance(x, s * step, step, [&](double t, const Vector& at) { return rate(t, at, with); });
      const Vector wanted = motion((s + 1) * step);
      for (std::size_t j = 0; j < n; ++j) worst = std::max(worst, std::abs(x[j] - wanted[j]));
    }
    return worst;
  }
};

TEST(ElasticDrives, LetAnArmFollowAMotionInOpenLoop) {
  Arm arm;
  EXPECT_LT(arm.largest_error(With::springs), 1e-10);
  EXPECT_GT(arm.largest_error(With::rigid_motors), 1e-3);
}

/// A Gough platform whose plate moves without turning.
struct Platform {
  static constexpr double k = 5e5, I = 20;  // N/m, kg
  Model model = load(AXODE_SOURCE_DIR "/examples/robots/gough.toml");
  TaskSpace space{model, neutral(model)};
  std::size_t nv = static_cast<std::size_t>(model.nv());
  ElasticFeedForward elastic{model, std::vector<ElasticDrive>(nv, {k, I})},
      rigid{model, std::vector<ElasticDrive>(nv, {std::numeric_limits<double>::infinity(), I})};
  std::vector<std::pair<std::size_t, std::size_t>> legs;  ///< velocity and coordinate of each drive

  Platform() {
    for (const Joint& joint : model.joints())
      if (!joint.passive && joint.nv == 1)
        legs.emplace_back(static_cast<std::size_t>(joint.iv), static_cast<std::size_t>(joint.iq));
  }
  /// The place of the plate, and its derivatives of order 1 to 4.
  static std::array<Vec3<>, 5> motion(double t) {
    std::array<Vec3<>, 5> rows;
    for (int order = 0; order < 5; ++order) {
      const auto wave = [&](double amplitude, double rhythm) {
        return amplitude * ((order == 0) - std::pow(rhythm, order) * std::cos(rhythm * t + order * M_PI / 2));
      };
      rows[static_cast<std::size_t>(order)] = {wave(0.05, 7), wave(-0.03, 9), wave(0.08, 11)};
    }
    return rows;
  }
  /// The configuration with the plate at r.
  Vector closed(const Vec3<>& r, Vector near) {
    EXPECT_TRUE(place_platform(space, {{}, r}, near).reached);
    return near;
  }
  MotorMotion motors(double t, const Vector& near, With with) {
    const auto rows = motion(t);
    Vector rates;
    for (std::size_t order = 1; order < 5; ++order)
      rates.insert(rates.end(), {0, 0, 0, rows[order].x, rows[order].y, rows[order].z});
    MotorMotion out;
    EXPECT_TRUE(
        (with == With::springs ? elastic : rigid).evaluate(space, closed(rows[0], near), rates, out).ok());
    return out;
  }
  /// The largest error of the place of the plate in m. The state has the coordinates q, the task
  /// velocities V, and the motors.
  double largest_error(With with) {
    constexpr double step = 5e-4;
    const std::size_t nq = static_cast<std::size_t>(model.nq());
    Vector near = closed(motion(0)[0], neutral(model)), theta, omega;
    const MotorMotion start = motors(0, near, With::springs);
    for (const auto& [c, at] : legs) {
      theta.push_back(start.position[c]);
      omega.push_back(start.velocity[c]);
    }
    Vector x = joined({near, Vector(6), theta, omega});
    const auto rate = [&](double t, const Vector& y) {
      const Vector q(y.begin(), y.begin() + static_cast<std::ptrdiff_t>(nq));
      const double* const V = y.data() + nq;
      const Vector u = motors(t, near, with).force;
      Vector v(nv), spring(nv), dV(6), alpha(6);
      for (std::size_t leg = 0; leg < 6; ++leg) {
        const auto& [c, at] = legs[leg];
        spring[c] = k * (V[6 + leg] - q[at]);
        alpha[leg] = (u[c] - spring[c]) / I;
      }
      EXPECT_TRUE(space.velocities(q, {V, 6}, v).ok());
      EXPECT_TRUE(space.forward_dynamics(q, v, spring, dV).ok());
      return joined({coordinate_rates(model, q, v), dV, Vector(V + 12, V + 18), alpha});
    };
    const std::size_t base = static_cast<std::size_t>(
        model.joint(space.platform()).iq);  // quaternion, then the place of the plate
    double worst = 0;
    for (int s = 0; s < 100; ++s) {
      advance(x, s * step, step, rate);
      const Vec3<> r{x[base + 4], x[base + 5], x[base + 6]};
      worst = std::max(worst, norm(r - motion((s + 1) * step)[0]));
      near = closed(r, near);  // the plate does not turn
      std::copy(near.begin(), near.end(), x.begin());
    }
    return worst;
  }
};

TEST(ElasticDrives, LetAParallelManipulatorFollowAMotionInOpenLoop) {
  Platform platform;
  ASSERT_EQ(platform.legs.size(), 6U);
  EXPECT_LT(platform.largest_error(With::springs), 1e-10);
  EXPECT_GT(platform.largest_error(With::rigid_motors), 1e-6);
}

/// I θ'' + Q = u and k (θ - q) = Q, where θ'' comes from differences of θ'.
TEST(ElasticDrives, HaveTheForcesOfTheirMotors) {
  Arm arm;
  Comparison force("u", 1e-7), velocity("θ'", 1e-7);
  const double t = 0.3, h = 1e-5;
  const MotorMotion before = arm.motors(t - h, With::springs), now = arm.motors(t, With::springs),
                    after = arm.motors(t + h, With::springs);
  const Vector q = arm.motion(t);
  Vector u(arm.n), rate(arm.n);
  for (std::size_t j = 0; j < arm.n; ++j) {
    rate[j] = (after.position[j] - before.position[j]) / (2 * h);
    u[j] = Arm::I * (after.velocity[j] - before.velocity[j]) / (2 * h) + Arm::k * (now.position[j] - q[j]);
  }
  velocity.expect_equal(now.velocity, rate);
  force.expect_equal(now.force, u);
}

TEST(ElasticDrives, AreRefusedWithANameAndARule) {
  const Model arm = load(AXODE_SOURCE_DIR "/examples/robots/arm7.toml"),
              gough = load(AXODE_SOURCE_DIR "/examples/robots/gough.toml");
  const auto made = [&](const ElasticDrive& drive) {
    std::vector<ElasticDrive> drives(7, {1000, 0.1});
    drives[2] = drive;
    return message_of([&] { ElasticFeedForward(arm, drives); });
  };
  const std::string name = "the drive of \"" + velocity_names(arm)[2] + "\" ";
  EXPECT_EQ(made({1000, 0.1}), "no error");
  EXPECT_EQ(made({0, 0.1}), name +
                                "has the stiffness 0; expected a positive number, or infinity for a "
                                "rigid drive");
  EXPECT_EQ(made({1000, -1}), name + "has the inertia -1; expected a finite number that is not negative");
  EXPECT_EQ(message_of([&] {
              ElasticFeedForward(arm, std::vector<ElasticDrive>(6, {1, 1}));
            }),
            "drives has 6 entries; expected nv = 7");
  ElasticFeedForward of_gough(gough,
                              std::vector<ElasticDrive>(static_cast<std::size_t>(gough.nv()), {1000, 1}));
  MotorMotion motors;
  EXPECT_EQ(message_of([&] { of_gough.evaluate(neutral(gough), Vector(4), motors); }),
            "model \"" + gough.name() + "\" has loops; pass a TaskSpace of it, and task velocities");
}

}  // namespace
}  // namespace axode::test
