#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "axode/io.hpp"
#include "axode/model/configuration.hpp"
#include "tests/io/same_mechanism.hpp"
#include "tests/laws/law.hpp"
#include "tests/model/random_mechanism.hpp"

/// Initial states and prescribed motions in drawings, and where a format has no word for them.
namespace axode::test {
namespace {

using testing::HasSubstr;

/// The description of a random tree with an initial state and motions of all kinds.
Description with_motions(Random<double>& random) {
  constexpr std::array kinds{JointKind::revolute,  JointKind::prismatic, JointKind::cylindrical,
                             JointKind::universal, JointKind::spherical, JointKind::planar,
                             JointKind::free};
  Description d = random_tree(random, static_cast<int>(random.number(2, 20)), kinds);
  const Model model = ModelBuilder(d).build();
  const std::vector<double> q =
      random_configuration(model, static_cast<std::uint64_t>(random.number(0, 1e9)));
  InitialStateDescription& state = d.state.emplace();
  int n = 0;
  for (const Joint& joint : model.joints()) {
    if (random.number(0, 1) < 0.6)
      state.q.emplace_back(joint.name, std::vector(q.begin() + joint.iq, q.begin() + joint.iq + joint.nq));
    if (random.number(0, 1) < 0.6)
      for (auto& [name, v] = state.v.emplace_back(joint.name, std::vector<double>());
           std::ssize(v) < joint.nv;)
        v.push_back(random.number(-1, 1));
    if (joint.nv != 1) continue;
    MotionDescription motion{.of = joint.name, .kind = static_cast<MotionDescription::Kind>(n++ % 4)};
    if (n % 3 == 0) motion.name = "leads " + joint.name;
    switch (motion.kind) {
      case MotionDescription::Kind::harmonic:
        motion.offset = random.number(-1, 1), motion.amplitude = random.number(-1, 1);
        motion.frequency = random.number(0, 3), motion.phase = random.number(-1, 1);
        break;
      case MotionDescription::Kind::ramp:
        motion.from = random.number(-1, 1), motion.to = random.number(-1, 1);
        motion.start = random.number(0, 1), motion.end = random.number(1.5, 2);
        break;
      case MotionDescription::Kind::polynomial: motion.coefficients = {0, random.number(-1, 1), 0.5}; break;
      case MotionDescription::Kind::samples:
        for (int k = 0; k < 9; ++k)
          motion.times.push_back(0.25 * k), motion.values.push_back(random.number(-1, 1));
        break;
    }
    d.motions.push_back(std::move(motion));
  }
  return d;
}

TEST(RoundTrip, ADrawingKeepsTheInitialStateAndTheMotions) {
  for_seeds(100, [](std::uint64_t seed) {
    Random<double> random(seed);
    const Model model = ModelBuilder(with_motions(random)).build();
    const std::string text = drawing_of(model);
    const Model again = ModelBuilder(read_drawing_text(text, "again.toml")).build();
    EXPECT_EQ(drawing_of(again), text);
    EXPECT_EQ(initial_state(again).q, initial_state(model).q);
    EXPECT_EQ(initial_state(again).v, initial_state(model).v);
    ASSERT_EQ(again.motions().size(), model.motions().size());
    for (std::size_t k = 0; k < model.motions().size(); ++k) {
      const MotionDescription &one = model.motions()[k], &other = again.motions()[k];
      EXPECT_EQ(one.name, other.name);
      EXPECT_EQ(one.of, other.of);
      EXPECT_EQ(one.kind, other.kind);
      EXPECT_EQ((std::array{one.offset, one.amplitude, one.frequency, one.phase, one.from, one.to, one.start,
                            one.end}),
                (std::array{other.offset, other.amplitude, other.frequency, other.phase, other.from, other.to,
                            other.start, other.end}));
      EXPECT_EQ(one.coefficients, other.coefficients);
      EXPECT_EQ(one.times, other.times);
      EXPECT_EQ(one.values, other.values);
    }
  });
}

TEST(FormatsWithoutMotions, WarnByNameOrRefuseIfStrict) {
  const Model model = ModelBuilder("arm")
                          .add({.name = "link",
                                .joint = {.name = "hinge", .kind = JointKind::revolute},
                                .inertia = MassProperties{.mass = 1, .com = {.1, 0, 0}, .Theta = {1, 1, 1}}})
                          .add(MotionDescription{.of = "hinge", .coefficients = {0, 1}})
                          .state({.q = {{"hinge", {1}}}})
                          .build();
  for (const auto write : {write_urdf, write_mjcf}) {
    std::ostringstream text, strict;
    std::string warnings;
    for (const Fault& fault : write(model, text, Strictness::lenient)) warnings += to_string(fault) + '\n';
    EXPECT_THAT(warnings, HasSubstr("motion of \"hinge\": is prescribed; "));
    EXPECT_THAT(warnings, HasSubstr("state: is the initial state of motions; "));
    EXPECT_THROW(write(model, strict, Strictness::strict), ModelError);
    EXPECT_TRUE(strict.str().empty());
  }
}

}  // namespace
}  // namespace axode::test
