#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/dynamics.hpp"
#include "axode/kinematics.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/laws/law.hpp"
#include "tests/model/random_loops.hpp"

/// The wrenches that joints of mechanisms with loops transmit. The tests in cut_joints.cpp compare them with
/// those in trees.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;

/// A random tree with a loop of every kind, a coupling and passive joints; the loops are closed in the drawn
/// configuration.
Description closed_as_drawn(Random<double>& random) {
  Description d = with_loops(described(random_mechanism(random, {.most_bodies = 8}), random), random);
  for (BodyDescription& body : d.bodies)
    if (body.joint.coupling) body.joint.coupling->offset = 0;
  for (LoopDescription& loop : d.loops)
    loop.frames.reset(), loop.length.reset(), loop.radius.reset(), loop.angle.reset();
  for (CouplingDescription& coupling : d.couplings) coupling.offset = 0;
  return d;
}

/// The wrenches of joints and loops fulfil the Newton-Euler equations of every body, and Sᵀ W is the drive
/// force of every joint.
TEST(JointWrenchesOfClosedMechanisms, BalanceEveryBodyAndHoldTheDriveForces) {
  int rows = 0, passive = 0;
  for_seeds(60, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const Model model = ModelBuilder(closed_as_drawn(random)).build();
    const auto nv = static_cast<std::size_t>(model.nv()), n = static_cast<std::size_t>(model.n_bodies());
    LoopWorkspace<double> loops(model);
    Workspace<double> workspace(model, cut_tree);
    const std::vector<AppliedWrench<>> applied{{1, Representation::hybrid, random.vector(), random.vector()}};
    const Loads<> loads{applied};
    const Numbers q = neutral(model);
    Numbers v = random_numbers(random, model.nv()), tau = random_numbers(random, model.nv(), 10), a(nv),
            lambda(static_cast<std::size_t>(model.loops().rows));
    for (std::size_t c = 0; c < nv; ++c)
      if (!model.loops().driven[c]) tau[c] = 0, ++passive;
    ASSERT_TRUE(impact(model, loops, q, v, 0.0, v).ok());
    ASSERT_TRUE(forward_dynamics(model, loops, q, v, tau, a, {}, loads).ok());
    ASSERT_LT(inverse_dynamics(model, loops, q, v, a, tau, lambda, {}, loads), 1e-6);

    std::vector<Wrench<Spatial>> W(n), of_tree(n), closing(model.loops().all.size()), on(n + 1);
    ASSERT_LT(joint_wrenches<Spatial>(model, loops, q, v, a, W, {}, loads), 1e-6);
    joint_wrenches<Spatial>(model, workspace, q, v, a, of_tree, loads);
    loop_wrenches<Spatial>(model, loops, q, lambda, closing);
    double size = 1;
    for (std::size_t i = 0; i < n; ++i) {
      const auto p = static_cast<std::size_t>(model.body(static_cast<int>(i + 1)).predecessor);
      on[i + 1] += W[i] - of_tree[i], on[p] -= W[i] - of_tree[i];
      size += norm(W[i].m) + norm(W[i].f);
    }
    for (std::size_t k = 0; k < model.loops().joints.size(); ++k) {
      const auto& ends = model.loops().joints[k].ends;
      on[static_cast<std::size_t>(ends[1].body)] += closing[k];
      on[static_cast<std::size_t>(ends[0].body)] -= closing[k];
    }
    for (std::size_t i = 1; i <= n; ++i) {
      EXPECT_LT(norm(on[i].m), 1e-11 * size) << model.body(static_cast<int>(i)).name;
      EXPECT_LT(norm(on[i].f), 1e-11 * size) << model.body(static_cast<int>(i)).name;
    }

    std::vector<Twist<Spatial>> S(static_cast<std::size_t>(model.n_screws()));
    joint_screws(model, workspace, q, S);
    Numbers A(lambda.size() * nv), held(nv);
    loop_jacobian(model, loops, q, A);
    for (int i = 1; i <= model.n_bodies(); ++i) {
      const Joint& joint = model.joint(i);
      const int c = joint.leader ? model.joint(joint.leader->joint).iv : joint.iv;
      const double ratio = joint.leader ? joint.leader->ratio : 1;
      for (int s = model.first_screw(i), k = c; s < model.first_screw(i + 1); ++s, ++k)
        held[static_cast<std::size_t>(k)] +=
            ratio * (W[static_cast<std::size_t>(i - 1)] | S[static_cast<std::size_t>(s)]);
      for (std::size_t k = 0; k < joint.dof.size() && !joint.leader; ++k)
        held[static_cast<std::size_t>(c) + k] += joint.dof[k].armature * a[static_cast<std::size_t>(c) + k];
    }
    for (std::size_t c = 0; c < nv; ++c) {
      double coupled = 0;
      for (const LoopCoupling& gear : model.loops().couplings)
        coupled += A[static_cast<std::size_t>(gear.first_row) * nv + c] *
                   lambda[static_cast<std::size_t>(gear.first_row)];
      EXPECT_NEAR(held[c], (model.loops().driven[c] ? tau[c] : 0) + coupled, 1e-6 * size) << c;
    }
    rows += model.loops().rows;
  });
  EXPECT_GT(rows, 100);
  EXPECT_GT(passive, 10);
}

/// The boom of an excavator at rest. Its weight acts at c; a weightless hydraulic cylinder from b to e holds
/// it like a bar.
TEST(JointWrenchesOfClosedMechanisms, AreThoseOfStaticsInTheBoomOfAnExcavator) {
  const Vec3<> pin{0.4, 0, 1.6}, c{3, 0, 2.8}, b{0.9, 0, 1.1}, e{2.2, 0, 2.6}, y{0, 1, 0};
  BodyDescription boom{
      .name = "boom",
      .joint = {.name = "pin", .kind = JointKind::revolute, .axis = y, .point = pin},
      .geometry = InConstructionFrame{SE3<>{{}, {1, 2, 3}}},
      .inertia = MassProperties{
          .mass = 3000, .com = c, .Theta = {100, 9000, 9000}, .in = GivenIn::construction_frame}};
  BodyDescription barrel = bar("barrel", "ground", JointKind::revolute, y, b, 0.5 * (b + e)),
                  rod = bar("rod", "barrel", JointKind::prismatic, e - b, 0.5 * (b + e), e);
  boom.joint.passive = barrel.joint.passive = true;
  for (BodyDescription* light : {&barrel, &rod})
    light->inertia->mass *= 1e-9, light->inertia->Theta = 1e-9 * light->inertia->Theta;
  Description d{.name = "excavator", .bodies = {boom, barrel, rod}, .frames = {}};
  d.loops.push_back({.between = {"rod", "boom"}, .axis = y, .point = e});
  const Model model = ModelBuilder(d).build();
  LoopWorkspace<double> loops(model);
  const Numbers q = neutral(model), rest(q.size());
  const Vec3<> weight{0, 0, -3000 * 9.81}, along = (1 / norm(e - b)) * (e - b);
  const double push = -dot(cross(c - pin, weight), y) / dot(cross(e - pin, along), y);
  const Vec3<> expected = -(weight + push * along);

  std::vector<Wrench<Hybrid>> W(3), about_origin(3);
  EXPECT_LT(joint_wrenches<Hybrid>(model, loops, q, rest, rest, W, {}, {}, WrenchPoint::joint), 1e-9);
  EXPECT_LT(norm(W[0].f - expected), 1e-6 * norm(expected));
  EXPECT_LT(norm(W[0].m), 1e-6 * norm(expected));
  EXPECT_LT(joint_wrenches<Hybrid>(model, loops, q, rest, rest, about_origin), 1e-9);
  EXPECT_LT(norm(about_origin[0].m - cross(pin - Vec3<>{1, 2, 3}, expected)), 1e-6 * norm(expected));
  EXPECT_NEAR(dot(W[2].f, along), push, 1e-6 * push);
}

}  // namespace
}  // namespace axode::test
