#include <string_view>

#include "tests/laws/correspondence.hpp"

/// Mechanisms made from others: with couplings taken away, with joints locked, with composite joints taken
/// apart. They have no loops: the least drive forces of a closed mechanism are others if it has other drives.
namespace axode::test {
namespace {

class EditedModels : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, EditedModels, testing::ValuesIn(cases()), name_of);

TEST_P(EditedModels, CoupledJointsArePartsOfTheirLeaders) {
  const double agreement = GetParam().agreement();
  Comparison torque("torque", agreement), springs("springs", agreement), energy("energy", agreement);
  for_seeds(250, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Description description = random_description(random);
    const Model model = ModelBuilder(description).build();
    for (BodyDescription& body : description.bodies) body.joint.coupling.reset();
    const Model uncoupled = ModelBuilder(description).build();

    Trial trial(GetParam(), model, random);
    const Correspondence same(model, uncoupled);
    State<double> state = same.carry(trial.state);
    for (int i = 1; i <= model.n_bodies(); ++i) {
      const auto& leader = model.joint(i).leader;
      if (!leader) continue;
      const Joint &lead = model.joint(leader->joint), &own = uncoupled.joint(same.joint(i));
      state.q[own.iq] = leader->ratio * trial.state.q[lead.iq] + leader->offset;
      state.v[own.iv] = leader->ratio * trial.state.v[lead.iv];
      state.a[own.iv] = leader->ratio * trial.state.a[lead.iv];
    }
    Trial free_trial(GetParam(), uncoupled, state);
    const auto of_leaders = [&](const std::vector<double>& tau_free) {
      std::vector<double> tau(static_cast<std::size_t>(model.nv()));
      for (int i = 1; i <= model.n_bodies(); ++i) {
        const Joint &joint = model.joint(i), &own = uncoupled.joint(same.joint(i));
        const double ratio = joint.leader ? joint.leader->ratio : 1;
        for (int k = 0; k < own.nv; ++k) tau[joint.iv + k] += ratio * tau_free[own.iv + k];
      }
      return tau;
    };
    const std::vector<double> tau_free = free_trial.inverse_dynamics();
    torque.expect_equal(trial.inverse_dynamics(), of_leaders(tau_free), largest(tau_free));
    const std::vector<double> of_springs = free_trial.call("spring_forces");
    springs.expect_equal(trial.call("spring_forces"), of_leaders(of_springs), largest(of_springs));
    energy.expect_equal(trial.call("elastic_energy"), free_trial.call("elastic_energy"));
  });
}

TEST(Couplings, InAChainMultiplyTheirRatios) {
  const auto slider = [](const char* name, std::optional<Coupling> coupling) {
    return BodyDescription{.name = name,
                           .joint = {.name = std::string("along ") + name,
                                     .kind = JointKind::prismatic,
                                     .coupling = std::move(coupling)}};
  };
  const Model model = ModelBuilder("gears")
                          .add(slider("c", Coupling{"along b", -3, 0.5}))
                          .add(slider("b", Coupling{"along a", 2, 0.25}))
                          .add(slider("a", {}))
                          .build();
  ASSERT_EQ(model.nv(), 1);
  const Joint& c = model.joint(model.joint_index("along c"));
  ASSERT_TRUE(c.leader);
  EXPECT_EQ(c.leader->joint, model.joint_index("along a"));
  EXPECT_EQ(c.leader->ratio, -6);
  EXPECT_EQ(c.leader->offset, -0.25);
  Trial trial(scalars()[0], model, {{0.1}, {1}, {0}});
  EXPECT_DOUBLE_EQ(trial.poses()[model.frame_index("c")].r.z, -0.85);
  EXPECT_DOUBLE_EQ(trial.twists()[model.frame_index("c")].b.z, -6);
}

TEST_P(EditedModels, LockedJointsRest) {
  const double agreement = GetParam().agreement();
  Comparison torque("torque", agreement), wrench("wrench", agreement), pose("pose", agreement),
      springs("springs", agreement);
  for_seeds(250, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const Model model = ModelBuilder(random_description(random)).build();
    State<double> state = random_state(model, random);
    std::vector<std::string_view> locked;
    const double part = random.number(0, 1);
    for (const Joint& joint : model.joints()) {
      if (joint.leader || random.number(0, 1) > part) continue;
      locked.push_back(joint.name);
      for (int k = 0; k < joint.nv; ++k) state.v[joint.iv + k] = state.a[joint.iv + k] = 0;
    }
    const Model rest = reduced(model, locked, state.q);
    Trial trial(GetParam(), model, state);
    const Correspondence same(model, rest);
    Trial rest_trial(GetParam(), rest, same.carry(state));

    const std::vector<double> tau = trial.inverse_dynamics();
    const auto [expected, found] = same.common(tau, rest_trial.inverse_dynamics());
    EXPECT_EQ(static_cast<int>(found.size()), rest.nv());
    torque.expect_equal(found, expected, largest(tau));
    const std::vector<double> of_springs = trial.call("spring_forces");
    const auto [expected_of_springs, found_of_springs] =
        same.common(of_springs, rest_trial.call("spring_forces"));
    springs.expect_equal(found_of_springs, expected_of_springs, largest(of_springs));

    const auto W = trial.joint_wrenches(), W_rest = rest_trial.joint_wrenches();
    std::vector<Six> still_transmitted, transmitted;
    for (int i = 1; i <= model.n_bodies(); ++i)
      if (same.joint(i) > 0)
        still_transmitted.push_back(W_rest[same.joint(i) - 1]), transmitted.push_back(W[i - 1]);
    wrench.expect_equal(still_transmitted, transmitted, largest(entries(W)));

    const auto C = trial.poses(), C_rest = rest_trial.poses();
    for (int f = 0; f < model.n_frames(); ++f) {
      ASSERT_GE(same.frame(f), 0) << "frame " << model.frame(f).name << " got lost";
      pose.expect_equal(C_rest[same.frame(f)], C[f], 1);
    }
    EXPECT_NEAR(
        rest.total_mass(),
        [&] {
          double mass = 0;  // of the bodies that still move
          for (int i = 1; i <= model.n_bodies(); ++i)
            if (rest.frame(same.frame(i)).body > 0) mass += model.body(i).M.m;
          return mass;
        }(),
        1e-12 * model.total_mass());
  });
}

/// The mechanism with each cylindrical or universal joint replaced by two joints and a massless body between
/// them.
Mechanism taken_apart(const Mechanism& mechanism) {
  Mechanism out{.gravity = mechanism.gravity, .bodies = {}};
  std::vector<int> index;  // the index in `out` of each body
  const auto moved = [&](int i) { return i < 0 ? -1 : index[static_cast<std::size_t>(i)]; };
  for (DrawnBody body : mechanism.bodies) {
    body.predecessor = moved(body.predecessor);
    if (body.kind == JointKind::cylindrical || body.kind == JointKind::universal) {
      const bool universal = body.kind == JointKind::universal;
      DrawnBody between{.name = body.joint + (universal ? ".cross" : ".sleeve"),
                        .joint = body.joint + (universal ? ".first" : ".rotation"),
                        .predecessor = body.predecessor,
                        .kind = JointKind::revolute,
                        .A = body.A,
                        .J = body.J};
      if (!body.dof.empty()) between.dof = {body.dof[0]}, body.dof = {body.dof[1]};
      body.predecessor = static_cast<int>(out.bodies.size());
      body.joint += universal ? ".second" : ".translation";
      body.kind = universal ? JointKind::revolute : JointKind::prismatic;
      if (universal) body.J.R = rotation_to((1 / norm(body.second_axis)) * body.second_axis);
      out.bodies.push_back(between);
    }
    index.push_back(static_cast<int>(out.bodies.size()));
    out.bodies.push_back(body);
  }
  for (DrawnFrame frame : mechanism.frames) {
    frame.body = moved(frame.body);
    out.frames.push_back(frame);
  }
  return out;
}

TEST_P(EditedModels, CylindricalAndUniversalJointsAreChains) {
  const double agreement = GetParam().agreement();
  Comparison torque("torque", agreement), twist("twist", agreement), springs("springs", agreement),
      energy("energy", agreement);
  int composite = 0;
  for_seeds(250, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Mechanism drawn = random_mechanism(random);
    const Description tree = with_springs(described(drawn, random), random);
    for (std::size_t k = 0; k < drawn.bodies.size(); ++k) drawn.bodies[k].dof = tree.bodies[k].joint.dof;
    const Model model = ModelBuilder(tree).build();
    const Model by_hand = ModelBuilder(with_parts_of(tree, described(taken_apart(drawn), random))).build();
    for (const DrawnBody& body : drawn.bodies)
      composite += body.kind == JointKind::cylindrical || body.kind == JointKind::universal;
    ASSERT_EQ(by_hand.n_bodies(), model.n_bodies());
    State<double> state = random_state(model, random);
    make_loads_spatial(model, state);  // the two models may place the frames of massless bodies differently
    Trial trial(GetParam(), model, state);
    const Correspondence same(model, by_hand);
    Trial trial_by_hand(GetParam(), by_hand, same.carry(state));
    const auto [expected, found] = same.common(trial.inverse_dynamics(), trial_by_hand.inverse_dynamics());
    EXPECT_EQ(static_cast<int>(found.size()), model.nv());
    torque.expect_equal(found, expected);
    const auto [expected_of_springs, found_of_springs] =
        same.common(trial.call("spring_forces"), trial_by_hand.call("spring_forces"));
    springs.expect_equal(found_of_springs, expected_of_springs);
    energy.expect_equal(trial_by_hand.call("elastic_energy"), trial.call("elastic_energy"));
    Trial spatial = trial.by(Representation::spatial),
          spatial_by_hand = trial_by_hand.by(Representation::spatial);
    twist.expect_equal(same.of_frames(spatial_by_hand.twists()), spatial.twists());
  });
  EXPECT_GT(composite, 0);
}

}  // namespace
}  // namespace axode::test
