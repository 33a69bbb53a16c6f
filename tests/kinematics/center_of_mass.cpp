#include "tests/laws/law.hpp"

/// The centre of mass of all moving bodies.
namespace axode::test {
namespace {

template <class T> class CenterOfMassOf : public testing::Test {};
using Scalars = testing::Types<double, float>;
struct ScalarNames {
  template <class T> static std::string GetName(int) { return std::same_as<T, double> ? "double" : "float"; }
};
TYPED_TEST_SUITE(CenterOfMassOf, Scalars, ScalarNames);

TYPED_TEST(CenterOfMassOf, ATreeIsTheMeanOfItsMatterWeightedByMass) {
  using T = TypeParam;
  Comparison position("position", agreement<T>);
  for_seeds(500, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const Mechanism drawn = random_mechanism(random, {.couplings = false});
    Trial<T> trial(ModelBuilder(told(drawn, random)).build(), random);
    const std::vector<SE3<T>> C = trial.poses();
    T mass(0), reach(0);
    Vec3<T> h;
    for (const DrawnBody& body : drawn.bodies) {
      const int frame = trial.model.frame_index(body.name);
      if (!body.matter || trial.model.frame(frame).body == 0)
        continue;  // what is fixed to the ground does not move
      const T m = static_cast<T>(body.matter->mass);
      const Vec3<T> c = C[frame] * axode::cast<T>(inverse(body.A) * body.matter->com);
      mass += m, h += m * c, reach = std::max(reach, norm(c));
    }
    if (mass > T(0))
      position.expect_equal(center_of_mass(trial.model, trial.workspace, trial.state.q), (T(1) / mass) * h,
                            reach);
  });
}

TYPED_TEST(CenterOfMassOf, AMasslessModelIsAnError) {
  using T = TypeParam;
  const Model model =
      ModelBuilder("ghost").add({.name = "link", .joint = {.kind = JointKind::revolute}}).build();
  Workspace<T> workspace(model);
  const std::vector<T> q(1);
  try {
    center_of_mass(model, workspace, q);
    FAIL() << "no error";
  } catch (const std::domain_error& error) {
    EXPECT_STREQ(error.what(), "model \"ghost\" has no mass that moves, so no centre of mass");
  }
}

}  // namespace
}  // namespace axode::test
