#include "tests/laws/law.hpp"

/// The centre of mass of all moving bodies.
namespace axode::test {
namespace {

class CenterOfMassOf : public Law {};
INSTANTIATE_TEST_SUITE_P(Kinematics, CenterOfMassOf, testing::ValuesIn(scalars()), name_of);

TEST_P(CenterOfMassOf, ATreeIsTheMeanOfItsMatterWeightedByMass) {
  Comparison position("position", GetParam().agreement());
  for_seeds(500, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const Mechanism drawn = random_mechanism(random, {.couplings = false});
    Trial trial(GetParam(), ModelBuilder(told(drawn, random)).build(), random);
    const std::vector<SE3<>> C = trial.poses();
    double mass = 0, reach = 0;
    Vec3<> h;
    for (const DrawnBody& body : drawn.bodies) {
      const int frame = trial.model.frame_index(body.name);
      if (!body.matter || trial.model.frame(frame).body == 0)
        continue;  // what is fixed to the ground does not move
      const double m = body.matter->mass;
      const Vec3<> c = C[static_cast<std::size_t>(frame)] * (inverse(body.A) * body.matter->com);
      mass += m, h += m * c, reach = std::max(reach, norm(c));
    }
    if (mass > 0) position.expect_equal(vectors_of(trial.call("center_of_mass"))[0], (1 / mass) * h, reach);
  });
}

TEST_P(CenterOfMassOf, AMasslessModelIsAnError) {
  const Model model =
      ModelBuilder("ghost").add({.name = "link", .joint = {.kind = JointKind::revolute}}).build();
  try {
    subject(GetParam(), model)->call("center_of_mass", {.q = {0}});
    FAIL() << "no error";
  } catch (const std::domain_error& error) {
    EXPECT_STREQ(error.what(), "model \"ghost\" has no mass that moves, so no centre of mass");
  }
}

}  // namespace
}  // namespace axode::test
