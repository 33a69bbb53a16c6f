#include "axode/contact/compliance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "axode/contact/contacts_at_rest.hpp"
#include "axode/dynamics/momentum/momentum.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "tests/contact/scene.hpp"

/// Contacts of compliant surfaces: the force law of Hunt and Crossley in steps.
namespace axode::test {
namespace {

double distance(const std::vector<double>& one, const std::vector<double>& other) {
  double most = 0;
  for (std::size_t k = 0; k < one.size(); ++k) most = std::max(most, std::abs(one[k] - other[k]));
  return most;
}

double elastic_energy(const Compliance& it, double gap) {
  return gap < 0 ? it.stiffness * std::pow(-gap, it.exponent + 1) / (it.exponent + 1) : 0;
}

TEST(Compliance, TheMeanForceDoesTheWorkOfTheEnergy) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> gap(-2e-3, 1e-3), exponent(1, 3), size(-12, 0);
  for (int k = 0; k < 3000; ++k) {
    const Compliance it{1e6, exponent(random), 0};
    const double before = gap(random),
                 after = k % 2 == 0 ? gap(random) : before * (1 + std::pow(10, size(random)));
    const MeanForce mean = mean_force(it, before, after, 1e-3);
    const double energy = elastic_energy(it, before) + elastic_energy(it, after);
    EXPECT_NEAR(mean.force * (before - after), elastic_energy(it, after) - elastic_energy(it, before),
                1e-14 * energy);
    const double d = 1e-6 * std::abs(after);
    const double difference =
        (mean_force(it, before, after - d, 1e-3).force - mean_force(it, before, after + d, 1e-3).force) /
        (2 * d);
    if (std::abs(after) > 1e-5 && std::abs(before - after) > 1e-3 * std::abs(after)) {
      EXPECT_NEAR(mean.slope, difference, 1e-4 * std::abs(difference) + 1e-3);
    }
  }
}

TEST(Compliance, TheMeanForceIsContinuousWhereItsFormulaChanges) {
  const Compliance it{1e6, 1.5, 0.3};
  for (const double sign : {1.0, -1.0}) {
    const double before = -1e-3, inside = before * (1 + sign * 0.05 * (1 - 1e-9)),
                 outside = before * (1 + sign * 0.05 * (1 + 1e-9));
    const MeanForce one = mean_force(it, before, inside, 1e-3), other = mean_force(it, before, outside, 1e-3);
    EXPECT_NEAR(one.force, other.force, 1e-8 * one.force);
    EXPECT_NEAR(one.slope, other.slope, 1e-8 * one.slope);
  }
}

TEST(Compliance, DampingNeverPullsAndVanishesAtRest) {
  const Compliance it{1e6, 1.5, 10};
  EXPECT_EQ(mean_force(it, -1e-3, -0.5e-3, 1e-3).force, 0);
  EXPECT_NEAR(mean_force(it, -1e-3, -1e-3, 1e-3).force, it.force_at_rest(-1e-3), 1e-12);
  EXPECT_EQ(mean_force(it, 1e-3, 2e-3, 1e-3).force, 0);
  EXPECT_EQ(it.force_at_rest(1e-3), 0);
}

TEST(Compliance, InSeriesTheDepthsAddUp) {
  const Compliance a{2e6, 1.5, 0.4}, b{5e5, 1.5, 0.1}, both = in_series(a, b);
  const double depth_a = 1e-3, force = a.force_at_rest(-depth_a);
  const double depth_b = std::pow(force / b.stiffness, 1 / b.exponent);
  EXPECT_NEAR(both.force_at_rest(-depth_a - depth_b), force, 1e-12 * force);
  const double part = depth_a / (depth_a + depth_b);
  EXPECT_NEAR(both.damping, a.damping * part * part + b.damping * (1 - part) * (1 - part), 1e-15);
  EXPECT_EQ(in_series(a, {}).stiffness, a.stiffness);
  EXPECT_EQ(in_series({}, b).damping, b.damping);
  EXPECT_FALSE(in_series({}, {}));
}

/// A ball of 1 kg that flies against a floor with 1 m/s, without gravity.
struct Impact {
  Model model;
  Trajectory motion;

  Impact(const ContactProperties& floor, double step, double until = 0.03)
      : model([&] {
          Scene scene(floor);
          scene.description.gravity = {};
          return scene.add("ball", ShapeKind::sphere, 0.1, {.friction = 0}).build();
        }()),
        motion(simulate_contact(model, at({0, 0, 0.101}), std::vector<double>{0, 0, 0, 0, 0, -1}, until,
                                step)) {}
  double speed_after() const { return motion.v(motion.size() - 1)[5]; }
};

/// The restitution e at the speed v: c v (1 + e) + ln((1 - c v e)/(1 + c v)) = 0.
double restitution_of_damping(double c) {
  double low = 1e-6, high = 1;
  for (int k = 0; k < 100; ++k) {
    const double e = (low + high) / 2;
    (c * (1 + e) + std::log(1 - c * e) - std::log(1 + c) > 0 ? low : high) = e;
  }
  return low;
}

TEST(CompliantContact, BouncesByItsDamping) {
  for (const double exponent : {1.0, 1.5, 2.0})
    for (const double c : {0.1, 0.5}) {
      const Impact impact({.stiffness = exponent == 1 ? 1e5 : 1e6, .exponent = exponent, .damping = c}, 1e-4,
                          0.05);
      ASSERT_TRUE(impact.motion.complete) << impact.motion.stop_reason;
      EXPECT_NEAR(impact.speed_after(), restitution_of_damping(c), 2e-4) << exponent;
      EXPECT_LE(std::ranges::max(impact.motion.certificates), 1e-9);
    }
  EXPECT_NEAR(restitution_of_damping(0.1), 0.937476, 1e-6);
  EXPECT_NEAR(restitution_of_damping(0.5), 0.748435, 1e-6);
}

TEST(CompliantContact, IsOfSecondOrder) {
  const auto error = [](double step) {
    return std::abs(Impact({.stiffness = 1e6, .damping = 0.5}, step).speed_after() -
                    restitution_of_damping(0.5));
  };
  const double coarse = error(4e-4), fine = error(1e-4);
  EXPECT_LE(fine, coarse / 10);
  EXPECT_LE(fine, 1e-4);
}

TEST(CompliantContact, KeepsTheEnergyWithoutDamping) {
  for (const double step : {1e-3, 1e-4}) {
    const Compliance compliance{1e6, 1.5, 0};
    const Impact impact({.stiffness = 1e6}, step);
    double deepest = 0;
    for (std::size_t k = 0; k < impact.motion.size(); ++k) {
      const double gap = impact.motion.q(k)[6] - 0.1;
      deepest = std::min(gap, deepest);
      EXPECT_NEAR(energy_at(impact.model, impact.motion, k) + elastic_energy(compliance, gap), 0.5, 1e-12);
    }
    EXPECT_LT(deepest, -3e-3);
    EXPECT_NEAR(impact.speed_after(), 1, 1e-12);
  }
}

/// Steps that are far too long for the stiffness neither gain energy nor fail.
TEST(CompliantContact, IsStableInStepsThatAreFarLongerThanTheImpact) {
  for (const double stiffness : {1e9, 1e12, 1e15}) {
    const Impact impact({.stiffness = stiffness}, 1e-3);
    ASSERT_TRUE(impact.motion.complete) << impact.motion.stop_reason;
    EXPECT_NEAR(impact.speed_after(), 1, 1e-9) << stiffness;
    EXPECT_LE(std::ranges::max(impact.motion.certificates), 1e-9);
  }
}

TEST(CompliantContact, CarriesTheWeightAtTheDepthOfItsLaw) {
  const double stiffness = 1e6;
  const Model model = Scene({.friction = 0.5, .stiffness = stiffness, .damping = 5})
                          .add("box", ShapeKind::box, 0.1, {.friction = 0.5})
                          .build();
  const Trajectory motion = simulate_contact(model, at({0, 0, 0.1}), std::vector<double>(6), 4, 1e-3);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  const double depth = std::pow(g / 4 / stiffness, 1 / 1.5);
  EXPECT_NEAR(last(motion, false)[6], 0.1 - depth, 1e-9);
  EXPECT_NEAR(largest(last(motion, true)), 0, 1e-6);

  const ContactsAtRest found = contacts_at_rest(model, ContactShapes(model), at({0, 0, 0.1 - depth}), {});
  ASSERT_EQ(found.contacts.size(), 4U);
  for (const ContactForce& contact : found.contacts) EXPECT_NEAR(contact.force.z, g / 4, 1e-9);
  EXPECT_LE(largest(found.a), 1e-9);
}

/// A box that moves along x and z without turning, under gravity that leans by an angle.
Model sledge(double angle, const ContactProperties& floor) {
  Scene scene(floor);
  scene.description.gravity = {g * std::sin(angle), 0, -g * std::cos(angle)};
  BodyDescription carriage{.name = "carriage"};
  carriage.joint = {.name = "along", .kind = JointKind::prismatic, .axis = {1, 0, 0}};
  scene.add("box", ShapeKind::box, 0.1, {.friction = *floor.friction});
  BodyDescription& box = scene.description.bodies.front();
  box.predecessor = "carriage";
  box.joint = {.name = "across", .kind = JointKind::prismatic, .axis = {0, 0, 1}};
  scene.description.bodies.insert(scene.description.bodies.begin(), carriage);
  return scene.build();
}

TEST(CompliantContact, HasCoulombsConeWithoutCreep) {
  const double angle = 20 * std::acos(-1.0) / 180, stiffness = 1e6, until = 1;
  const double depth = std::pow(g * std::cos(angle) / 4 / stiffness, 1 / 1.5);
  for (const double mu : {std::tan(angle) * (1 + 1e-9), 0.3}) {
    const Model model = sledge(angle, {.friction = mu, .stiffness = stiffness, .damping = 2});
    const Trajectory motion =
        simulate_contact(model, std::vector<double>{0, 0.1 - depth}, std::vector<double>(2), until, 1e-2);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_LE(std::ranges::max(motion.certificates), 1e-9);
    const double slides = g * std::max(std::sin(angle) - mu * std::cos(angle), 0.0) / 2 * until * until;
    EXPECT_NEAR(last(motion, false)[0], slides, 1e-9) << mu;
    EXPECT_NEAR(last(motion, false)[1], 0.1 - depth, 1e-9);
  }
}

TEST(CompliantContact, BecomesTheRigidOneWithItsStiffness) {
  const auto end = [](std::optional<double> stiffness) {
    Scene scene({.friction = 0.3, .stiffness = stiffness, .damping = stiffness ? 1e3 : 0});
    const Model model = scene.add("ball", ShapeKind::sphere, 0.1, {.friction = 0.3}).build();
    const Trajectory motion =
        simulate_contact(model, at({0, 0, 0.1}), std::vector<double>{0, 0, 0, 2, 0, 0}, 0.8, 1e-3);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    EXPECT_LE(std::ranges::max(motion.certificates), 1e-9);
    return last(motion, true);
  };
  const std::vector<double> rigid = end({});
  double before = 1;
  for (const double stiffness : {1e6, 1e8, 1e10}) {
    const double difference = distance(end(stiffness), rigid);
    EXPECT_LT(difference, before / 2) << stiffness;
    before = difference;
  }
  EXPECT_LE(before, 1e-4);
}

TEST(CompliantContact, KeepsTheMomentumOfTwoBodies) {
  Scene scene({.friction = 0.5, .stiffness = 1e6});
  scene.description.gravity = {};
  scene.description.shapes.clear();
  const ContactProperties soft{.friction = 0.5, .stiffness = 1e6, .damping = 0.2};
  const Model model =
      scene.add("one", ShapeKind::sphere, 0.1, soft).add("other", ShapeKind::box, 0.1, soft).build();
  std::vector<double> q = at({0, 0, 0});
  for (const double x : at({0.05, 0.02, 0.205})) q.push_back(x);
  const std::vector<double> v{1, 2, 3, 0.3, 0, 1, -2, 0, 1, 0, 0.2, -1};
  const Trajectory motion = simulate_contact(model, q, v, 0.05, 1e-3);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  Workspace<> workspace(model, cut_tree);
  const auto momentum = [&](std::size_t k) {
    return spatial_momentum<double>(model, workspace, motion.q(k), motion.v(k));
  };
  const Momentum<Spatial> first = momentum(0), end = momentum(motion.size() - 1);
  EXPECT_NEAR(norm(end.p - first.p), 0, 1e-13);
  EXPECT_NEAR(norm(end.l - first.l), 0, 1e-13);
  EXPECT_GT(distance(last(motion, true), v), 0.1) << "they have touched";
}

TEST(CompliantContact, StopsIfItsForcesOverflow) {
  const Model model = Scene({.friction = 0.5, .stiffness = 1e6})
                          .add("ball", ShapeKind::sphere, 0.1, {.friction = 0.5})
                          .build();
  const std::vector<double> v{0, 0, 0, 0, 0, -1e150};
  const Trajectory motion = simulate_contact(model, at({0, 0, 0.3}), v, 0.01, 1e-3);
  EXPECT_FALSE(motion.complete);
  EXPECT_EQ(motion.stop_reason.find("at t = 0 s: the impulses of contacts are not finite"), 0U)
      << motion.stop_reason;
}

TEST(CompliantContact, RefusesWhatItCannotDo) {
  const auto message = [](const auto& call) {
    try {
      call();
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const ContactProperties soft{.friction = 0.5, .stiffness = 1e6};
  const Model other =
      Scene({.stiffness = 1e5, .exponent = 1}).add("ball", ShapeKind::sphere, 0.1, soft).build();
  EXPECT_EQ(
      message([&] { static_cast<void>(ContactShapes(other)); }),
      "shape \"floor\" has the exponent 1 of its stiffness, and shape \"ball shape 1\", which it may touch, "
      "1.5; compliant shapes that touch need the same exponent");
}

}  // namespace
}  // namespace axode::test
