#include "axode/batch/contact_rollout.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <thread>

#include "axode/constraints/assembly.hpp"
#include "axode/drives.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "axode/io.hpp"
#include "axode/model/configuration.hpp"
#include "tests/contact/scene.hpp"
#include "tests/contact/two_shapes.hpp"

/// Rollouts with contact against simulations of each motion alone.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;

/// A box and a ball on a floor, and states from which they fall with a spin.
struct Thrown {
  static constexpr std::size_t N = 5, K = 150, nq = 14, nv = 12;
  static constexpr double step = 4e-3;
  Model model;
  ContactShapes shapes;
  Numbers q, v, tau;

  Thrown() : model(build()), shapes(model), tau(N * K * nv, 0.0) {
    Random<double> random(1);
    for (std::size_t n = 0; n < N; ++n) {
      Numbers q_n = neutral(model);
      q_n[6] = random.number(0.4, 0.6);
      q_n[11] = 1;
      q_n[13] = random.number(0.4, 0.6);
      q.insert(q.end(), q_n.begin(), q_n.end());
      for (std::size_t c = 0; c < nv; ++c) v.push_back(random.number(-1, 1));
    }
    for (double& x : tau) x = random.number(-0.5, 0.5);
  }
  static Model build() {
    Description d = free_bodies({collision_shape(ShapeKind::box, {0.4, 0.3, 0.2}, 0, 0),
                                 collision_shape(ShapeKind::sphere, {}, 0.2, 0)})
                        .description();
    d.shapes.push_back(collision_shape(ShapeKind::plane, {}, 0, 0));
    d.contact = ContactDescription{};
    return ModelBuilder(std::move(d)).build();
  }
  std::span<const double> q_of(std::size_t n) const { return std::span(q).subspan(n * nq, nq); }
  std::span<const double> v_of(std::size_t n) const { return std::span(v).subspan(n * nv, nv); }
};

struct Rolled {
  Numbers q = Numbers(Thrown::N * (Thrown::K + 1) * Thrown::nq),
          v = Numbers(Thrown::N * (Thrown::K + 1) * Thrown::nv),
          certificates = Numbers(Thrown::N * Thrown::K);
};
Rolled roll(const Thrown& at, int threads) {
  Rolled out;
  const batch::Outcome outcome = batch::rollout_with_contact(
      at.model, at.shapes, at.q, at.v, at.tau, Thrown::step, out.q, out.v, out.certificates, threads);
  EXPECT_TRUE(outcome.ok());
  EXPECT_EQ(outcome.done, Thrown::N);
  return out;
}

TEST(ContactRollout, HasTheMotionsOfSimulationsToTheLastBit) {
  const Thrown at;
  const Rolled found = roll(at, 2);
  EXPECT_LE(std::ranges::max(found.certificates), 1e-9);
  for (std::size_t n = 0; n < Thrown::N; ++n) {
    SimulationOptions options;
    options.drive = [&](double t, std::span<const double>, std::span<const double>, std::span<double> out) {
      const std::size_t k = static_cast<std::size_t>(t / Thrown::step + 1e-6);
      const std::size_t first = (n * Thrown::K + std::min(k, Thrown::K - 1)) * Thrown::nv;
      std::ranges::copy(std::span(at.tau).subspan(first, Thrown::nv), out.begin());
    };
    const Trajectory one = simulate_contact(at.model, at.shapes, at.q_of(n), at.v_of(n),
                                            Thrown::step * Thrown::K, Thrown::step, options);
    ASSERT_EQ(one.size(), Thrown::K + 1);
    EXPECT_TRUE(std::ranges::equal(one.q(), std::span(found.q).subspan(n * one.q().size(), one.q().size())));
    EXPECT_TRUE(std::ranges::equal(one.v(), std::span(found.v).subspan(n * one.v().size(), one.v().size())));
    EXPECT_TRUE(std::ranges::equal(one.certificates,
                                   std::span(found.certificates).subspan(n * Thrown::K, Thrown::K)));
  }
}

/// Boxes on belts that shake.
TEST(ContactRollout, FollowsPrescribedMotionsAsSimulationsDo) {
  Description d = free_bodies({collision_shape(ShapeKind::box, {0.4, 0.3, 0.2}, 0, 0.3)}).description();
  BodyDescription belt{.name = "belt"};
  belt.joint = {.name = "rail", .kind = JointKind::prismatic, .axis = {1, 0, 0}};
  belt.inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}};
  belt.shapes = {collision_shape(ShapeKind::plane, {}, 0, 0.3)};
  d.bodies.push_back(belt);
  d.contact = ContactDescription{};
  d.motions = {{.of = "rail", .kind = MotionDescription::Kind::harmonic, .amplitude = 0.05, .frequency = 3}};
  const Model model = ModelBuilder(d).build();
  constexpr std::size_t N = 3, K = 100;
  constexpr double step = 2e-3;
  Numbers q, v;
  for (std::size_t n = 0; n < N; ++n) {
    const double height = 0.1 + 0.02 * static_cast<double>(n);
    const AssemblyResult start = assemble(model, Numbers{0, 0, 0, 1, 0, 0, height, 0}, Numbers(7));
    ASSERT_EQ(start.status, AssemblyStatus::closed);
    q.insert(q.end(), start.q.begin(), start.q.end());
    v.insert(v.end(), start.v.begin(), start.v.end());
  }
  Numbers q_out(N * (K + 1) * 8), v_out(N * (K + 1) * 7);
  const ContactShapes shapes(model);
  const auto roll = [&](const Numbers& v_0, const batch::DriveMotions& drives) {
    return batch::rollout_with_contact(model, shapes, q, v_0, Numbers(N * K * 7), step, q_out, v_out, {}, 2,
                                       {}, false, drives);
  };
  EXPECT_TRUE(roll(v, {}).ok());
  for (std::size_t n = 0; n < N; ++n) {
    const Trajectory one = simulate_contact(model, shapes, std::span(q).subspan(8 * n, 8),
                                            std::span(v).subspan(7 * n, 7), step * K, step);
    ASSERT_EQ(one.size(), K + 1);
    EXPECT_TRUE(std::ranges::equal(one.q(), std::span(q_out).subspan(n * one.q().size(), one.q().size())));
    EXPECT_TRUE(std::ranges::equal(one.v(), std::span(v_out).subspan(n * one.v().size(), one.v().size())));
    EXPECT_GT(std::abs(one.v(K)[3]), 1e-3) << "the belt moves the box";
  }
  const auto refuses = [](const char* why) {
    return testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(why));
  };
  Numbers other = v;
  other.back() += 0.1;
  EXPECT_THAT([&] { static_cast<void>(roll(other, {})); }, refuses("state 2: "));
  EXPECT_THAT([&] { static_cast<void>(roll(v, {.t = 1})); },
              refuses("with prescribed motions they begin at 0 s"));
}

/// Hoppers that fall on a floor, whose motors reach their limits, and whose controllers have inputs that jump.
struct Hoppers {
  static constexpr std::size_t N = 3, K = 300;
  static constexpr double step = 2e-3;
  Model model;
  ContactShapes shapes;
  std::size_t nx;
  Numbers q, v, x;

  explicit Hoppers(bool given) : model(build()), shapes(model), nx(DriveSystem(model).nx()) {
    for (std::size_t n = 0; n < N; ++n) {
      q.insert(q.end(), {0.7 + 0.1 * static_cast<double>(n), 0.0});
      v.insert(v.end(), {0.0, 0.1});
      if (given) x.insert(x.end(), nx, 0.001 * static_cast<double>(n));
    }
  }
  static Model build() {
    Description d = hopper();
    d.drives[0].input = {.times = {0, 0.1001, 0.4}, .values = {0.1, -0.05, 0.1}};
    return ModelBuilder(d).build();
  }
  SimulationOptions options_of(std::size_t n, const Drive& drive) const {
    SimulationOptions options{.drive = drive};
    if (!x.empty())
      options.x.assign(x.begin() + static_cast<std::ptrdiff_t>(n * nx),
                       x.begin() + static_cast<std::ptrdiff_t>((n + 1) * nx));
    return options;
  }
};

TEST(ContactRollout, CarriesDrivesAsSimulationsDoToTheLastBit) {
  const Drive sway = [](double t, std::span<const double>, std::span<const double> v, std::span<double> out) {
    for (std::size_t c = 0; c < out.size(); ++c) out[c] = std::sin(9 * t) - 0.1 * v[c];
  };
  for (const bool given : {false, true}) {
    const Hoppers at(given);
    const std::size_t rows = Hoppers::N * (Hoppers::K + 1);
    Numbers q(rows * 2), v(rows * 2), x(rows * at.nx), certificates(Hoppers::N * Hoppers::K);
    ASSERT_TRUE(batch::rollout_with_contact(at.model, at.shapes, at.q, at.v, sway, Hoppers::K, Hoppers::step,
                                            q, v, certificates, 2, {}, false, {.x = at.x, .x_out = x})
                    .ok());
    std::size_t early = 0, touched = 0;
    for (std::size_t n = 0; n < Hoppers::N; ++n) {
      const Trajectory one = simulate_contact(at.model, at.shapes, std::span(at.q).subspan(2 * n, 2),
                                              std::span(at.v).subspan(2 * n, 2), Hoppers::step * Hoppers::K,
                                              Hoppers::step, at.options_of(n, sway));
      ASSERT_TRUE(one.complete) << one.stop_reason;
      std::size_t i = 0;
      for (std::size_t k = 0; k <= Hoppers::K; ++k, ++i) {
        for (; one.t()[i] < static_cast<double>(k) * Hoppers::step; ++i) ++early;
        const std::size_t row = n * (Hoppers::K + 1) + k;
        EXPECT_TRUE(std::ranges::equal(one.q(i), std::span(q).subspan(2 * row, 2))) << n << " " << k;
        EXPECT_TRUE(std::ranges::equal(one.v(i), std::span(v).subspan(2 * row, 2))) << n << " " << k;
        EXPECT_TRUE(std::ranges::equal(one.x(i), std::span(x).subspan(at.nx * row, at.nx))) << n << " " << k;
        touched += one.contacts(i).empty() ? 0 : 1;
      }
    }
    EXPECT_GT(early, 6U);
    EXPECT_GT(touched, 200U);
  }
}

/// The second half of a motion begins at the state and time at which the first one has ended.
TEST(ContactRollout, ContinuesFromTheStatesOfDrives) {
  const Hoppers at(false);
  constexpr std::size_t K = Hoppers::K, half = K / 2, N = Hoppers::N;
  const auto roll = [&](const Numbers& q, const Numbers& v, const Numbers& x, std::size_t steps, double t) {
    std::array<Numbers, 3> out{Numbers(N * (steps + 1) * 2), Numbers(N * (steps + 1) * 2),
                               Numbers(N * (steps + 1) * at.nx)};
    EXPECT_TRUE(batch::rollout_with_contact(at.model, at.shapes, q, v, Numbers(N * steps * 2), Hoppers::step,
                                            out[0], out[1], {}, 1, {}, false,
                                            {.x = x, .x_out = out[2], .t = t})
                    .ok());
    return out;
  };
  const auto ends = [&](const Numbers& all, std::size_t steps, std::size_t k, std::size_t width) {
    Numbers rows;
    for (std::size_t n = 0; n < N; ++n)
      for (std::size_t c = 0; c < width; ++c) rows.push_back(all[(n * (steps + 1) + k) * width + c]);
    return rows;
  };
  const auto whole = roll(at.q, at.v, at.x, K, 0), first = roll(at.q, at.v, at.x, half, 0);
  const auto second = roll(ends(first[0], half, half, 2), ends(first[1], half, half, 2),
                           ends(first[2], half, half, at.nx), K - half, half * Hoppers::step);
  for (const auto& [which, width] : {std::pair<std::size_t, std::size_t>{0, 2}, {1, 2}, {2, at.nx}})
    Comparison("states", 1e-8)
        .expect_equal(ends(second[which], K - half, K - half, width), ends(whole[which], K, K, width));
}

TEST(ContactRollout, DoesNotDependOnThreads) {
  const Thrown at;
  const Rolled one = roll(at, 1), three = roll(at, 3);
  EXPECT_EQ(one.q, three.q);
  EXPECT_EQ(one.v, three.v);
  EXPECT_EQ(one.certificates, three.certificates);
}

TEST(ContactRollout, CallsADriveWithTheTime) {
  const Thrown at;
  Numbers constant(at.tau.size(), 0.1);
  Rolled forces, drive;
  EXPECT_TRUE(
      batch::rollout_with_contact(at.model, at.shapes, at.q, at.v, constant, Thrown::step, forces.q, forces.v)
          .ok());
  const Drive same = [](double t, std::span<const double>, std::span<const double>, std::span<double> out) {
    EXPECT_LE(t, Thrown::step * Thrown::K);
    std::ranges::fill(out, 0.1);
  };
  EXPECT_TRUE(batch::rollout_with_contact(at.model, at.shapes, at.q, at.v, same, Thrown::K, Thrown::step,
                                          drive.q, drive.v, {}, 2)
                  .ok());
  EXPECT_EQ(forces.q, drive.q);
}

TEST(ContactRollout, SaysWhichMotionFails) {
  Thrown at;
  at.tau[2 * Thrown::K * Thrown::nv + 30 * Thrown::nv] = std::numeric_limits<double>::infinity();
  Rolled out;
  const batch::Outcome outcome = batch::rollout_with_contact(at.model, at.shapes, at.q, at.v, at.tau,
                                                             Thrown::step, out.q, out.v, out.certificates);
  EXPECT_EQ(outcome.singular_states, 1U);
  EXPECT_EQ(outcome.first, 2U);
  const auto is_nan = [&](std::size_t k) {
    return std::isnan(out.v[(2 * (Thrown::K + 1) + k) * Thrown::nv]);
  };
  EXPECT_FALSE(is_nan(30));
  EXPECT_TRUE(is_nan(31));
  EXPECT_TRUE(std::isnan(out.certificates[2 * Thrown::K + 30]));
}

/// A monitor is asked after 20 ms at the earliest. The drive makes motions longer, which advance in portions.
TEST(ContactRollout, HasNoCompleteMotionIfTheMonitorEndsIt) {
  const Thrown at;
  const Drive slow = [](double, std::span<const double>, std::span<const double>, std::span<double> out) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::ranges::fill(out, 0.0);
  };
  for (const int threads : {1, 3}) {
    Rolled out;
    const batch::Outcome outcome =
        batch::rollout_with_contact(at.model, at.shapes, at.q, at.v, slow, Thrown::K, Thrown::step, out.q,
                                    out.v, {}, threads, [](std::size_t done, std::size_t of) {
                                      EXPECT_EQ(done, 0U);
                                      EXPECT_EQ(of, Thrown::N);
                                      return false;
                                    });
    EXPECT_EQ(outcome.done, 0U);
    EXPECT_EQ(outcome.singular_states, 0U);
    const std::size_t after_a_portion = 64;
    EXPECT_TRUE(std::isnan(out.q[after_a_portion * Thrown::nq]));
  }
}

TEST(ContactRollout, RefusesLoopsThatAreOpen) {
  const Model model = load(AXODE_SOURCE_DIR "/examples/robots/four_bar.toml");
  const ContactShapes shapes(model);
  const Numbers open{0.1, 0.1, 0.1}, rest(3);
  Numbers q(6), v(6);
  EXPECT_THAT(
      [&] {
        static_cast<void>(batch::rollout_with_contact(model, shapes, open, rest, rest, 1e-3, q, v, {}));
      },
      testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("open")));
}

/// Four corners of a box slide while it turns. Their forces are determined badly, and rounding moves them by
/// more than the tolerance of the iteration.
TEST(ContactRollout, ObeysTheLawWhereFrictionDeterminesForcesBadly) {
  Description d{.name = "box on an incline"};
  const SO3<> tilt = exp_SO3(Vec3<>{0, 0.26, 0});
  const Vec3<> center = tilt * Vec3<>{0, 0, 0.1};
  d.contact = ContactDescription{.friction = 0.5};
  d.shapes.push_back(collision_shape(ShapeKind::plane, {}, 0, 0));
  d.shapes.back().pose.R = tilt;
  d.bodies.push_back({.name = "box",
                      .joint = {.kind = JointKind::free},
                      .inertia = MassProperties{.mass = 2, .com = center, .Theta = {0.0133, 0.0133, 0.0133}},
                      .shapes = {collision_shape(ShapeKind::box, {0.2, 0.2, 0.2}, 0, 0)}});
  d.bodies.back().shapes.back().pose = {tilt, center};
  const Model model = ModelBuilder(d).build();
  const ContactShapes shapes(model);
  constexpr std::size_t K = 1000;
  Random<double> random(1);
  std::vector<double> tau(6 * K), q(7 * (K + 1)), v(6 * (K + 1)), certificates(K);
  for (double& x : tau) x = random.number(-2, 2);
  const std::vector<double> start = neutral(model), rest(6);
  const batch::Outcome outcome =
      batch::rollout_with_contact(model, shapes, start, rest, tau, 0.002, q, v, certificates);
  EXPECT_TRUE(outcome.ok());
  EXPECT_LE(std::ranges::max(certificates), 1e-9);
}

/// A state that is not finite is a failure of its motion alone, and no point of contact is sought there.
TEST(ContactRollout, FailsAtAStateThatIsNotFinite) {
  Thrown at;
  at.q[Thrown::nq + 4] = std::numeric_limits<double>::quiet_NaN();
  at.q[2 * Thrown::nq + 12] = std::numeric_limits<double>::infinity();
  Rolled out;
  const batch::Outcome outcome = batch::rollout_with_contact(at.model, at.shapes, at.q, at.v, at.tau,
                                                             Thrown::step, out.q, out.v, out.certificates);
  EXPECT_EQ(outcome.singular_states, 2U);
  EXPECT_EQ(outcome.first, 1U);
}

TEST(ContactRollout, RefusesCertificatesInTheMemoryOfStates) {
  const Thrown at;
  Rolled out;
  for (const std::span<double> shared : {std::span(out.q), std::span(out.v)})
    EXPECT_THROW(static_cast<void>(batch::rollout_with_contact(at.model, at.shapes, at.q, at.v, at.tau,
                                                               Thrown::step, out.q, out.v,
                                                               shared.subspan(1, Thrown::N * Thrown::K))),
                 std::invalid_argument);
}

TEST(ContactRollout, RefusesStatesOfDrivesThatItCannotTake) {
  const Hoppers at(true);
  Numbers q(Hoppers::N * 2), v(q), x(Hoppers::N * at.nx);
  const auto call = [&](const batch::DriveMotions& drives, std::span<double> certificates = {}) {
    static_cast<void>(batch::rollout_with_contact(at.model, at.shapes, at.q, at.v, Numbers(), 1e-3, q, v,
                                                  certificates, 1, {}, false, drives));
  };
  const auto refuses = [](const char* why) {
    return testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(why));
  };
  Numbers lost = at.x;
  lost.back() = std::nan("");
  EXPECT_NO_THROW(call({.x = at.x, .x_out = x}));
  EXPECT_THAT([&] { call({.x = std::span(at.x).first(2)}); }, refuses("x has 2 entries; expected nx N = 9"));
  EXPECT_THAT([&] { call({.x = lost}); }, refuses("of a drive is not finite"));
  EXPECT_THAT([&] { call({.x_out = v}); }, refuses("x_out has 6 entries; expected (K + 1) nx N = 9"));
}

TEST(ContactRollout, RefusesArraysOfAnotherSizeAndAnEmptyDrive) {
  const Thrown at;
  Rolled out;
  out.certificates.pop_back();
  EXPECT_THROW(static_cast<void>(batch::rollout_with_contact(at.model, at.shapes, at.q, at.v, at.tau,
                                                             Thrown::step, out.q, out.v, out.certificates)),
               std::invalid_argument);
  EXPECT_THROW(static_cast<void>(batch::rollout_with_contact(at.model, at.shapes, at.q, at.v, Drive(),
                                                             Thrown::K, Thrown::step, out.q, out.v)),
               std::invalid_argument);
}

}  // namespace
}  // namespace axode::test
