#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "axode/batch.hpp"
#include "axode/dynamics.hpp"
#include "axode/integration.hpp"
#include "axode/integration/contact_sensitivities.hpp"
#include "axode/integration/sensitivities.hpp"
#include "axode/model/building/builder.hpp"
#include "tests/integration/motions.hpp"

/// Couplings with play: their impacts keep momentum, their ends do not pull, and every relative method
/// meets them.
namespace axode::test {
namespace plays {
namespace {

/// Sliders on one axis with the masses 1, 2, ..., each coupled to the next one with a play of 0.2.
Model train(std::size_t sliders, double restitution) {
  Description d{.name = "train", .gravity = {0, 0, 0}};
  for (std::size_t k = 0; k < sliders; ++k) {
    const std::string name(1, static_cast<char>('a' + k));
    d.bodies.push_back({.name = name,
                        .joint = {.name = name, .kind = JointKind::prismatic, .axis = {1, 0, 0}},
                        .inertia = MassProperties{.mass = static_cast<double>(k + 1), .Theta = {1, 1, 1}}});
    if (k == 0) continue;
    d.couplings.push_back({.name = "buffer " + std::to_string(k),
                           .terms = {{d.bodies[k - 1].name, 1.0}, {name, -1.0}},
                           .play = 0.2,
                           .restitution = restitution});
  }
  d.contact = ContactDescription{.threshold = 1e-3};
  return ModelBuilder(std::move(d)).build();
}
double momentum(Span v) {
  double sum = 0;
  for (std::size_t k = 0; k < v.size(); ++k) sum += static_cast<double>(k + 1) * v[k];
  return sum;
}
double energy(Span v) {
  double sum = 0;
  for (std::size_t k = 0; k < v.size(); ++k) sum += 0.5 * static_cast<double>(k + 1) * v[k] * v[k];
  return sum;
}
double widest(const Trajectory& motion) {
  double most = 0;
  for (std::size_t k = 0; k < motion.size(); ++k)
    for (std::size_t c = 1; c < motion.q(k).size(); ++c)
      most = std::max(most, std::abs(motion.q(k)[c - 1] - motion.q(k)[c]));
  return most;
}

TEST(Plays, BounceByTheirRestitution) {
  const Model model = train(2, 0.5);
  const Trajectory motion = simulate(model, Numbers{0, 0}, Numbers{3, 0}, 0.2);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  ASSERT_EQ(motion.play_events.size(), 2U);
  EXPECT_NEAR(motion.play_events[0].t, 0.1 / 3, 1e-12);
  EXPECT_EQ(motion.play_events[0].side, 1);
  EXPECT_NEAR(motion.play_events[0].speed, 3, 1e-12);
  EXPECT_NEAR(motion.play_events[0].impulse, 1.5 * 3 * 2 / 3, 1e-12);
  EXPECT_NEAR(motion.play_events[1].t, 0.1 / 3 + 0.2 / 1.5, 1e-12);
  EXPECT_EQ(motion.play_events[1].side, -1);
  EXPECT_NEAR(momentum(last_v(motion)), 3, 1e-12);
}

TEST(Plays, KeepMomentumAndLoseEnergyInImpactsOfSeveral) {
  for (const double e : {0.0, 0.3, 1.0}) {
    const Model model = train(4, e);
    const Numbers v{2, 0, 1, -1};
    const Trajectory motion = simulate(model, Numbers(4), v, 1.5);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_GE(motion.play_events.size(), 3U);
    for (std::size_t k = 1; k < motion.size(); ++k) {
      EXPECT_NEAR(momentum(motion.v(k)), momentum(v), 1e-11);
      EXPECT_LE(energy(motion.v(k)), energy(motion.v(k - 1)) + 1e-11);
    }
    EXPECT_LE(widest(motion), 0.1 + 1e-9);
    for (const Trajectory::PlayEvent& event : motion.play_events) EXPECT_GE(event.impulse, 0);
  }
}

TEST(Plays, PushAtTheirEndsAndLetGo) {
  const Model model = train(2, 0);
  SimulationOptions options;
  options.drive = [](double t, Span, Span, std::span<double> tau) { tau[0] = t < 1 ? 3 : -6, tau[1] = 0; };
  for (const Trajectory& motion :
       {simulate(model, Numbers{0.1, 0}, Numbers{0, 0}, 1.6, {.largest_step = 0.05}, options),
        simulate_fixed(model, Numbers{0.1, 0}, Numbers{0, 0}, 1.6, 0.01, runge_kutta(4), options),
        simulate_stiff(model, Numbers{0.1, 0}, Numbers{0, 0}, 1.6, 0.002, 0.8, options)}) {
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    Numbers q(2), v(2);
    motion.at(0.9, q, v);
    EXPECT_NEAR(v[0], 0.9, 1e-3) << "both move together";
    EXPECT_NEAR(q[0] - q[1], 0.1, 1e-9);
    ASSERT_GE(motion.play_events.size(), 3U);
    EXPECT_FALSE(motion.play_events[1].impact);
    EXPECT_NEAR(motion.play_events[1].t, 1, 1e-2);
    EXPECT_EQ(motion.play_events[2].side, -1);
    // The first slider falls back by the whole play at an acceleration of -6 m/s².
    EXPECT_NEAR(motion.play_events[2].t, 1 + std::sqrt(2 * 0.2 / 6), 2e-2);
  }
}

/// An event leaves a play a little beyond its end, where an impact of another play may stop it.
TEST(Plays, StayAtTheirEndsWithoutMoving) {
  Description d = train(3, 1).description();
  for (BodyDescription& body : d.bodies) body.inertia->mass = 1;
  const Model model = ModelBuilder(std::move(d)).build();
  // The sliders exchange their velocities. At 1.9 s two of them meet, while the third one begins to rest
  // relative to one of them at the end of its play.
  const Trajectory motion = simulate(model, Numbers{0, 0, -0.1}, Numbers{1, 0, 0}, 3);
  EXPECT_TRUE(motion.complete) << motion.stop_reason;
  EXPECT_NEAR(last_v(motion)[0] + last_v(motion)[1] + last_v(motion)[2], 1, 1e-12);
  EXPECT_LE(widest(motion), 0.1 + 1e-11);
}

TEST(Plays, AreRefusedWhereTheyDoNotCount) {
  const Model model = train(2, 0);
  const Numbers q(2), v(2);
  SimulationOptions absolute;
  absolute.coordinates = Coordinates::absolute;
  const auto refuses = testing::ThrowsMessage<std::invalid_argument>(
      testing::HasSubstr("coupling \"buffer 1\" has play, which"));
  EXPECT_THAT([&] { simulate(model, q, v, 1, {}, absolute); }, refuses);
  EXPECT_THAT([&] { simulate_symplectic(model, q, v, 1, 0.1); }, refuses);
  EXPECT_THAT([&] { simulate_contact(model, q, v, 1, 0.1); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(
                  "contact does not count couplings with play, and model \"train\" has 1; simulate")));
  Numbers q_out(4), v_out(4), A(32), B(16);
  const auto does_not_count = [](const std::string& function) {
    return testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(
        function + " does not count couplings with play, and model \"train\" has 1; simulate"));
  };
  EXPECT_THAT([&] { static_cast<void>(batch::rollout<double>(model, q, v, q, 0.1, q_out, v_out)); },
              does_not_count("rollout"));
  EXPECT_THAT([&] { static_cast<void>(batch::rollout<double>(model, q, v, Drive(), 1, 0.1, q_out, v_out)); },
              does_not_count("rollout"));
  Workspace<> workspace(model);
  EXPECT_THAT(
      [&] {
        static_cast<void>(step_derivatives(model, workspace, q, v, q, 0.1, {q_out, v_out, A, B}));
      },
      does_not_count("rollout sensitivities"));
  EXPECT_THAT(
      [&] {
        static_cast<void>(
            contact_rollout_derivatives(model, ContactShapes(model), q, v, q, 0.1, {q_out, v_out, A, B}));
      },
      does_not_count("contact"));
  EXPECT_THAT(
      [&] {
        simulate(model, Numbers{0.3, 0}, v, 1);
      },
      testing::ThrowsMessage<std::invalid_argument>(
          testing::HasSubstr("from the middle of its play at the start")));
}

}  // namespace
}  // namespace plays
}  // namespace axode::test
