#include "axode/constraints.hpp"
#include "axode/dynamics.hpp"
#include "axode/integration.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/laws/law.hpp"

/// Controllers for mechanisms with passive joints, with and without loops.
namespace axode::test {
namespace passive_joints {
namespace {

using Numbers = std::vector<double>;
using Span = std::span<const double>;

Numbers call(Drive drive, Span q, Span v) {
  Numbers tau(v.size(), NAN);
  drive(0, q, v, tau);
  return tau;
}

/// The accelerations that ComputedTorque is to cause with gains of 4 and 3 and a reference at rest.
const Numbers kp{4}, kd{3};
Numbers wanted(const Model& model, Span q, Span v, Span q_d) {
  Numbers w = difference(model, q, q_d);
  for (std::size_t c = 0; c < w.size(); ++c) w[c] = 4 * w[c] - 3 * v[c];
  return w;
}

TEST(PassiveJoints, OfTreesGetNoForceAndDrivesMoveAsWanted) {
  int passive = 0;
  for_seeds(40, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Description tree = described(random_mechanism(random, {.most_bodies = 6, .always_mass = true}), random);
    for (BodyDescription& body : tree.bodies)
      if (body.joint.kind != JointKind::fixed) body.joint.passive = random.number(0, 1) < 0.4;
    const Model model = ModelBuilder(with_springs(tree, random)).build();
    const State<double> at = random_state(model, random);
    const Numbers q_d = random_configuration(model, seed);
    const std::vector<char>& driven = model.loops().driven;
    Workspace<double> workspace(model);
    Numbers a(at.v.size());
    const Numbers tau = call(ComputedTorque(model, {kp, kd}, {model, q_d}), at.q, at.v);
    Numbers forces = tau;
    add_spring_forces(model, workspace, at.q, at.v, forces);
    ASSERT_TRUE(forward_dynamics(model, workspace, at.q, at.v, forces, a).ok());
    const Numbers w = wanted(model, at.q, at.v, q_d);
    double size = 1;
    for (const double x : a) size = std::max(size, std::abs(x));
    const Numbers pd = call(ProportionalDerivative(model, {kp, kd}, {model, q_d}), at.q, at.v);
    for (std::size_t c = 0; c < w.size(); ++c)
      if (driven[c]) {
        EXPECT_NEAR(a[c], w[c], 1e-7 * size) << c;
      } else {
        ++passive;
        EXPECT_EQ(tau[c], 0) << c;
        EXPECT_EQ(pd[c], 0) << c;
      }
  });
  EXPECT_GT(passive, 20);
}

/// A mechanism with as many drives as degrees of freedom.
Model closed(const char* name) {
  Description d = std::string_view(name) == "gough" ? gough() : four_bar();
  for (BodyDescription& body : d.bodies)
    if (body.joint.kind == JointKind::universal || body.name == "bar1" || body.name == "bar2")
      body.joint.passive = true;
  return ModelBuilder(d).build();
}

TEST(PassiveJoints, OfClosedMechanismsGetNoForceAndDrivesMoveAsWanted) {
  for (const char* name : {"gough", "four-bar"}) {
    SCOPED_TRACE(name);
    const Model model = closed(name);
    const auto nv = static_cast<std::size_t>(model.nv());
    const std::vector<char>& driven = model.loops().driven;
    EXPECT_EQ(std::ranges::count(driven, 1), loop_mobility(model, neutral(model)).degrees_of_freedom);
    Random<double> random(3);
    const auto near = [&] {
      return assemble(model, integrate(model, neutral(model), random_numbers(random, model.nv(), 0.1)),
                      random_numbers(random, model.nv()));
    };
    const AssemblyResult at = near(), there = near();
    ASSERT_EQ(at.status, AssemblyStatus::closed);
    ASSERT_EQ(there.status, AssemblyStatus::closed);
    LoopWorkspace<double> loops(model);
    Numbers a(nv);
    const ComputedTorque drive(model, {kp, kd}, {model, there.q});
    const Numbers tau = call(drive, at.q, at.v), w = wanted(model, at.q, at.v, there.q),
                  pd = call(ProportionalDerivative(model, {kp, kd}, {model, there.q}), at.q, at.v);
    ASSERT_TRUE(forward_dynamics(model, loops, at.q, at.v, tau, a).ok());
    for (std::size_t c = 0; c < nv; ++c)
      if (driven[c]) {
        EXPECT_NEAR(a[c], w[c], 1e-7 * (1 + std::abs(w[c]))) << c;
      } else {
        EXPECT_EQ(tau[c], 0) << c;
        EXPECT_EQ(pd[c], 0) << c;
      }

    SimulationOptions options;
    options.drive = drive;
    const Trajectory motion =
        simulate(model, at.q, Numbers(nv), 8, {.relative = 1e-6, .absolute = 1e-8}, options);
    ASSERT_TRUE(motion.complete) << motion.stop_reason;
    for (const double x : difference(model, motion.q(motion.size() - 1), Span(there.q)))
      EXPECT_NEAR(x, 0, 1e-3);
  }
}

/// With more drives than degrees of freedom the controller causes the nearest motion that is possible, with
/// the least forces, and in all units the same one.
TEST(PassiveJoints, AreNotNeededWhereDrivesAreRedundant) {
  const Model model = ModelBuilder(four_bar()).build();
  ASSERT_EQ(std::ranges::count(model.loops().driven, 1), 3);
  const AssemblyResult at = assemble(model, Numbers{0.1, 0, 0}, Numbers{1, 0, 0});
  LoopWorkspace<double> loops(model);
  Numbers a(3), least(3);
  const Numbers tau = call(ComputedTorque(model, {kp, kd}, {model, Numbers{0.3, 0.1, -0.2}}), at.q, at.v);
  ASSERT_TRUE(forward_dynamics(model, loops, at.q, at.v, tau, a).ok());
  EXPECT_LT(inverse_dynamics(model, loops, at.q, at.v, a, least), 1e-9);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(tau[c], least[c], 1e-9 * (1 + std::abs(least[c])));
}

TEST(PassiveJoints, AreFreeJointsOfMechanismsWithLoopsUnlessTheDrawingSaysOtherwise) {
  Description d = gough();
  const auto platform_is_passive = [&] {
    const Model model = ModelBuilder(d).build();
    const Joint& joint = model.joint(model.joint_index("platform_joint"));
    for (int k = 0; k < joint.nv; ++k)
      EXPECT_NE(joint.passive,
                static_cast<bool>(model.loops().driven[static_cast<std::size_t>(joint.iv + k)]));
    return joint.passive;
  };
  EXPECT_TRUE(platform_is_passive());
  d.bodies[0].joint.passive = false;
  EXPECT_FALSE(platform_is_passive());
  d.bodies[0].joint.passive.reset();
  d.loops.clear();
  EXPECT_FALSE(platform_is_passive()) << "the forces on a free base are asked for in trees";
}

}  // namespace
}  // namespace passive_joints
}  // namespace axode::test
