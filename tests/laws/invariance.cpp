#include <numeric>
#include <utility>

#include "tests/laws/correspondence.hpp"
#include "tests/support/units.hpp"

/// Changes of a description that do not change the mechanism: other body frames, another way to give the
/// geometry, other names and another order, the whole scene at another place, and another body of a floating
/// mechanism as its base. Springs and loops are the same in both descriptions.
namespace axode::test {
namespace {

class Invariance : public Law {
 protected:
  const double agreement = GetParam().agreement();
};
INSTANTIATE_TEST_SUITE_P(Laws, Invariance, testing::ValuesIn(cases()), name_of);

/// Removes the drives and springs of the joints concerned. They belong to the components of v, which depend
/// on the frame, so that a change of the frame would change the mechanism.
void remove_drives(Description& description, bool (*concerned)(JointKind)) {
  for (BodyDescription& body : description.bodies)
    if (concerned(body.joint.kind)) body.joint.dof.clear();
}

/// The description of a drawn mechanism with springs.
Description sprung(const Mechanism& drawn, Random<double>& random) {
  return with_springs(described(drawn, random), random);
}

/// The mechanism at a random state, with all lengths multiplied by the factor of the recipe.
MechanismAtAState at_a_state(const TreeRecipe& recipe, const Description& tree, Random<double>& random) {
  const Model model = ModelBuilder(tree).build();
  return in_units({.length = recipe.scale}, {tree, model, random_state(model, random)});
}
Model built(const TreeRecipe& recipe, Description description) {
  return ModelBuilder(in_units({.length = recipe.scale}, std::move(description))).build();
}

/// Compares what springs do in two trials of one mechanism: their energy, their power, and their forces on
/// those joints that both trials have.
class OfSprings {
 public:
  explicit OfSprings(double agreement)
      : force_("force of springs", agreement),
        energy_("energy of springs", agreement),
        power_("power of springs", agreement) {}

  void expect_equal(const Correspondence& same, Trial& trial, Trial& other) {
    const auto [expected, found] = same.common(trial.call("spring_forces"), other.call("spring_forces"));
    force_.expect_equal(found, expected);
    expect_equal_work(trial, other);
  }
  void expect_equal_work(Trial& trial, Trial& other) {
    energy_.expect_equal(other.call("elastic_energy"), trial.call("elastic_energy"));
    double size = 0;
    const auto power = [&](Trial& t) {
      const std::vector<double> tau = t.call("spring_forces");
      double sum = 0;
      for (std::size_t c = 0; c < tau.size(); ++c) {
        sum += tau[c] * t.state.v[c];
        size = std::max(size, std::abs(tau[c] * t.state.v[c]));
      }
      return sum;
    };
    const double expected = power(trial), found = power(other);
    power_.expect_equal(found, expected, size);
  }

 private:
  Comparison force_, energy_, power_;
};

/// The six forces of a free joint, changed from components in the frame D into components in the frame of the
/// joint: Ad_Dᵀ times them.
std::vector<double> seen_from(const SE3<>& D, const double* tau) {
  const Wrench<BodyFixed> W =
      coAd_inv(D, Wrench<Spatial>{{tau[0], tau[1], tau[2]}, {tau[3], tau[4], tau[5]}});
  return {W.m.x, W.m.y, W.m.z, W.f.x, W.f.y, W.f.z};
}

TEST_P(Invariance, BodyFramesMayLieAnywhere) {
  Comparison torque("torque", agreement), twist("twist", agreement);
  OfSprings springs(agreement);
  for_seeds(250, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const TreeRecipe recipe = elsewhere(seed);
    Mechanism drawn = random_mechanism(random, recipe);
    Description tree = sprung(drawn, random);
    remove_drives(tree, [](JointKind kind) { return kind == JointKind::free; });
    Shift to_new_frames;
    std::unordered_map<std::string, SE3<>> moved;  // D of each body: its new frame in its old frame
    for (DrawnBody& body : drawn.bodies) {
      SE3<> D{random.rotation(), random.vector(0.3)};
      to_new_frames.frames.emplace(body.name, inverse(D));
      body.A = body.A * D;
      if (body.kind == JointKind::free) body.J = body.A;
      D.r = recipe.scale * D.r;
      moved.emplace(body.name, D);
    }
    const Model other = built(recipe, with_parts_of(tree, described(drawn, random), to_new_frames));

    auto [scaled, model, state] = at_a_state(recipe, tree, random);
    make_loads_spatial(model, state);
    const Correspondence same(model, other);
    State<double> other_state = same.carry(state);
    Trial trial(GetParam(), model, state);
    std::vector<double> tau = trial.inverse_dynamics();
    for (int i = 1; i <= model.n_bodies(); ++i) {  // the coordinates of free joints depend on the body frame
      const Joint &joint = model.joint(i), &joint_other = other.joint(same.joint(i));
      if (joint.kind != Subgroup::free) continue;
      const SE3<> D = moved.at(model.body(i).name);
      const SE3<> q = inverse(D) * displacement(joint.kind, 0, &state.q[joint.iq]) * D;
      std::ranges::copy(coordinates(joint.kind, q), &other_state.q[joint_other.iq]);
      const auto seen = [&](const std::vector<double>& x, std::vector<double>& out) {
        const Screw<> X = Ad_inv(D, joint_screw(joint.kind, 0, &x[joint.iv]));
        std::ranges::copy(components(joint.kind, 0, X), &out[joint_other.iv]);
      };
      seen(state.v, other_state.v), seen(state.a, other_state.a);
      const std::vector<double> tau_i(tau.begin() + joint.iv, tau.begin() + joint.iv + 6);
      std::ranges::copy(seen_from(D, tau_i.data()), &tau[joint.iv]);
    }
    Trial other_trial(GetParam(), other, other_state);
    const auto [expected, found] = same.common(tau, other_trial.inverse_dynamics());
    torque.expect_equal(found, expected, terms_far_away(trial, recipe.far));
    springs.expect_equal_work(trial, other_trial);

    Trial spatial = trial.by(Representation::spatial),
          other_spatial = other_trial.by(Representation::spatial);
    twist.expect_equal(same.of_frames(other_spatial.twists()), spatial.twists());
  });
}

TEST_P(Invariance, NamesAndOrderOfDeclarationDoNotMatter) {
  Comparison torque("torque", agreement), transmitted("wrench", agreement);
  // Loops are solved to the accuracy that their conditions allow, so that they are compared in double alone.
  Comparison driven("torque with loops", 1e-8), borne("wrench with loops", 1e-8), moved("a with loops", 1e-8);
  OfSprings springs(agreement);
  int closed = 0;
  for_seeds(250, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const bool loops = !GetParam().single && seed % 5 == 1;
    // The least drive forces of loops weigh N against N m, so that their accuracy depends on the size.
    const TreeRecipe recipe = loops ? TreeRecipe{.loops = 1} : elsewhere(seed);
    const MechanismAtAState drawn = mechanism_at_a_state(random, recipe);
    Description description = drawn.description;
    const Model& model = drawn.model;

    const auto renamed = [](const std::string& name) { return name == "ground" ? name : "my " + name; };
    for (BodyDescription& body : description.bodies) {
      body.name = renamed(body.name), body.predecessor = renamed(body.predecessor);
      body.joint.name = renamed(body.joint.name);
      if (body.joint.coupling) body.joint.coupling->leader = renamed(body.joint.coupling->leader);
    }
    for (FrameDescription& frame : description.frames)
      frame.name = renamed(frame.name), frame.body = renamed(frame.body);
    const auto rename_joints = [&](auto& terms) {
      for (auto& [joint, factor] : terms) joint = renamed(joint);
    };
    for (SpringDescription& spring : description.springs) {
      for (std::string& end : spring.between) end = renamed(end);
      for (SpringDescription::Point& it : spring.path) it.on = renamed(it.on);
      rename_joints(spring.terms);
    }
    for (LoopDescription& loop : description.loops)
      for (std::string& end : loop.between) end = renamed(end);
    for (CouplingDescription& coupling : description.couplings) rename_joints(coupling.terms);
    const auto shuffle = [&](auto& list) {
      for (std::size_t k = list.size(); k > 1; --k)
        std::swap(list[k - 1], list[std::min(k - 1, static_cast<std::size_t>(random.number(0, double(k))))]);
    };
    shuffle(description.bodies), shuffle(description.frames);
    shuffle(description.springs), shuffle(description.loops), shuffle(description.couplings);
    const Model other = ModelBuilder(description).build();

    Trial trial(GetParam(), drawn);
    const Correspondence same(model, other, renamed);
    Trial other_trial(GetParam(), other, same.carry(trial.state));
    const auto refuses = [](Trial& t) {
      try {
        static_cast<void>(t.inverse_dynamics());
        return false;
      } catch (const std::invalid_argument& refusal) {  // in a closed mechanism the drives may be too few
        EXPECT_EQ(std::string_view(refusal.what()).substr(0, 18), "the drives cannot ");
        return true;
      }
    };
    if (loops && refuses(trial)) {
      EXPECT_TRUE(refuses(other_trial));
      return;
    }
    const auto [tau, tau_other] = same.common(trial.inverse_dynamics(), other_trial.inverse_dynamics());
    EXPECT_EQ(static_cast<int>(tau.size()), model.nv());
    const double size = terms_far_away(trial, recipe.far);
    (loops ? driven : torque).expect_equal(tau_other, tau, size);
    springs.expect_equal(same, trial, other_trial);
    const auto W = trial.joint_wrenches(), W_other = other_trial.joint_wrenches();
    std::vector<Six> in_order;
    for (int i = 1; i <= model.n_bodies(); ++i)
      in_order.push_back(W_other[static_cast<std::size_t>(same.joint(i) - 1)]);
    (loops ? borne : transmitted).expect_equal(in_order, W, size);
    if (!loops) return;
    ++closed;
    const auto accelerations = [&](Trial& t) {
      Ask ask = t.ask();
      ask.tau = t.inverse_dynamics();
      const std::vector<double> of_springs = t.call("spring_forces");
      for (std::size_t c = 0; c < ask.tau.size(); ++c) ask.tau[c] += of_springs[c];
      return t.call("forward_dynamics", ask);
    };
    const auto [a, a_other] = same.common(accelerations(trial), accelerations(other_trial));
    moved.expect_equal(a_other, a);
  });
  EXPECT_EQ(closed > 0, !GetParam().single);
}

/// A load after the whole scene was displaced. Components in inertial axes turn with the scene; components in
/// the axes of a frame stay.
AppliedWrench<> displaced(const SE3<>& D, const AppliedWrench<>& load) {
  const auto turned = [&](const auto& m, const auto& f) {
    return AppliedWrench<>(load.frame, load.representation, m, f);
  };
  switch (load.representation) {
    case Representation::body: return load;
    case Representation::spatial: return turned(D.R * load.m + cross(D.r, D.R * load.f), D.R * load.f);
    case Representation::hybrid: return turned(D.R * load.m, D.R * load.f);
    case Representation::mixed: break;
  }
  return turned(load.m, D.R * load.f);
}

TEST_P(Invariance, TheSceneMayStandAnywhere) {
  Comparison torque("torque", agreement), twist("twist", agreement), pose("pose", agreement);
  OfSprings springs(agreement);
  for_seeds(250, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const TreeRecipe recipe = elsewhere(seed);
    const Mechanism drawn = random_mechanism(random);
    const Description tree = sprung(drawn, random);
    Trial trial(GetParam(), at_a_state(recipe, tree, random));
    SE3<> D{random.rotation(), random.vector(std::max(1.0, recipe.far))};
    const Description there = described(displaced(D, drawn), random);
    const Model other = built(recipe, with_parts_of(tree, there, {D, {{"ground", D}}}));
    D.r = recipe.scale * D.r;
    // Frames on the ground move with the scene, but the ground's own frame does not, so that loads on it are
    // left out.
    State<double> state = trial.state;
    std::erase_if(state.wrenches, [](const AppliedWrench<>& load) { return load.frame == 0; });
    for (AppliedWrench<>& load : state.wrenches) load = displaced(D, load);
    Trial other_trial(GetParam(), other, state);
    torque.expect_equal(other_trial.inverse_dynamics(), trial.inverse_dynamics(),
                        terms_far_away(trial, recipe.far));
    springs.expect_equal(Correspondence(trial.model, other), trial, other_trial);

    Trial body_fixed = trial.by(Representation::body),
          other_body_fixed = other_trial.by(Representation::body);
    twist.expect_equal(other_body_fixed.twists(), body_fixed.twists());
    std::vector<SE3<>> C = trial.poses(), C_other = other_trial.poses();
    for (SE3<>& C_f : C) C_f = D * C_f;
    C[0] = C_other[0];
    pose.expect_equal(C_other, C);
  });
}

/// The body p, connected to its new predecessor by a joint that before connected that one to p. The joint
/// runs backwards: a joint with one velocity keeps its coordinate, the others get the inverse displacement.
DrawnBody with_joint(DrawnBody p, const DrawnBody& joint_of, int predecessor) {
  p.predecessor = predecessor;
  p.joint = joint_of.joint, p.kind = joint_of.kind, p.pitch = joint_of.pitch;
  p.dof = joint_of.dof, p.coupling = joint_of.coupling;
  p.J = joint_of.J;
  if (has_one_velocity(p.kind)) p.J.R = {p.J.R.x, -p.J.R.y, -p.J.R.z};
  if (p.kind == JointKind::free) p.J = p.A;
  return p;
}

/// The mechanism with body `base` as its free base in place of body 0. The joints between the two bodies run
/// backwards.
Mechanism rerooted(const Mechanism& mechanism, int base, std::vector<int>& path) {
  Mechanism out = mechanism;
  const auto body = [&](int i) -> const DrawnBody& { return mechanism.bodies[static_cast<std::size_t>(i)]; };
  DrawnBody free_base = body(base);
  free_base.predecessor = -1, free_base.joint = "new base", free_base.kind = JointKind::free;
  free_base.J = free_base.A, free_base.pitch = 0, free_base.dof = {}, free_base.coupling = {};
  out.bodies[static_cast<std::size_t>(base)] = free_base;
  for (int i = base; i != 0; i = body(i).predecessor) {
    path.push_back(i);
    const int p = body(i).predecessor;
    out.bodies[static_cast<std::size_t>(p)] = with_joint(body(p), body(i), i);
  }
  return out;
}

TEST_P(Invariance, AnyBodyOfAFloatingMechanismMayBeItsBase) {
  Comparison torque("torque", agreement), base_wrench("base wrench", agreement);
  OfSprings springs(agreement);
  for_seeds(250, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const TreeRecipe recipe{.composite = false, .one_free_root = true, .far = elsewhere(seed).far};
    const Mechanism drawn = random_mechanism(random, recipe);
    const int last = static_cast<int>(drawn.bodies.size()) - 1;
    if (last == 0) return;
    int base = last;
    while (drawn.bodies[static_cast<std::size_t>(base)].kind == JointKind::fixed) --base;
    if (base == 0) return;
    std::vector<int> path;
    const Mechanism other_way = rerooted(drawn, base, path);
    Description tree = sprung(drawn, random);
    remove_drives(tree, [](JointKind kind) { return !has_one_velocity(kind); });
    const Model model = ModelBuilder(tree).build();
    const Model other = ModelBuilder(with_parts_of(tree, described(other_way, random))).build();

    const Case body_double = in(Representation::body, in_double(GetParam()));
    // The forces of the base's joint become a load on the same body, so that the mechanism floats without
    // drive.
    State<double> state = random_state(model, random);
    Trial driven(body_double, model, state);
    const std::vector<double> W_0 = driven.inverse_dynamics();
    state.wrenches.emplace_back(1, Representation::body, Vec3<>{W_0[0], W_0[1], W_0[2]},
                                Vec3<>{W_0[3], W_0[4], W_0[5]});
    Trial exact(body_double, model, state);
    Trial trial(GetParam(), model, state);
    const std::vector<SE3<>> C = exact.poses();
    const std::vector<Six> V = exact.twists(), dV = exact.accelerations();
    const std::vector<double> tau = trial.inverse_dynamics();

    const Correspondence same(model, other);
    State<double> other_state = same.carry(state);
    const std::size_t f = static_cast<std::size_t>(model.frame_index(drawn.name(base)));
    const int new_base = other.joint_index("new base"), iv = other.joint(new_base).iv;
    std::ranges::copy(coordinates(Subgroup::free, inverse(drawn.A(base)) * C[f]),
                      &other_state.q[other.joint(new_base).iq]);
    std::ranges::copy(entries(V[f]), &other_state.v[iv]);
    std::ranges::copy(entries(dV[f]), &other_state.a[iv]);

    // For joints with several velocities on the path C_p = C_i B⁻¹ q' with q' = B q⁻¹ B⁻¹, so that v' =
    // -Ad_{B q} v.
    for (const int i : path) {
      const DrawnBody& body = drawn.bodies[static_cast<std::size_t>(i)];
      if (has_one_velocity(body.kind) || body.kind == JointKind::fixed) continue;
      const Joint& joint = model.joint(model.joint_index(body.joint));
      const Joint& joint_other = other.joint(other.joint_index(body.joint));
      const SE3<> B = body.kind == JointKind::free ? inverse(drawn.A(body.predecessor)) * body.A : SE3<>{};
      const SE3<> Bq = B * displacement(joint.kind, 0, &state.q[joint.iq]);
      std::ranges::copy(coordinates(joint.kind, B * inverse(Bq)), &other_state.q[joint_other.iq]);
      const auto reverse = [&](const std::vector<double>& x, std::vector<double>& out) {
        const Screw<> X = -Ad(Bq, joint_screw(joint.kind, 0, &x[joint.iv]));
        std::ranges::copy(components(joint.kind, 0, X), &out[joint_other.iv]);
      };
      reverse(state.v, other_state.v), reverse(state.a, other_state.a);
    }
    Trial other_trial(GetParam(), other, other_state);
    const std::vector<double> tau_other = other_trial.inverse_dynamics();
    std::vector<double> tau_back = tau_other;
    for (const int i : path) {  // τ = -Ad_{B q}ᵀ τ'
      const DrawnBody& body = drawn.bodies[static_cast<std::size_t>(i)];
      if (has_one_velocity(body.kind) || body.kind == JointKind::fixed) continue;
      const Joint& joint = model.joint(model.joint_index(body.joint));
      const Joint& joint_other = other.joint(other.joint_index(body.joint));
      const SE3<> B = body.kind == JointKind::free ? inverse(drawn.A(body.predecessor)) * body.A : SE3<>{};
      const SE3<> Bq = B * displacement(joint.kind, 0, &state.q[joint.iq]);
      const Screw<> W = joint_screw(joint.kind, 0, &tau_back[joint_other.iv]);  // a wrench with the forces τ'
      const Wrench<BodyFixed> back = coAd_inv(Bq, Wrench<Spatial>{W.w, W.v});
      std::ranges::copy(components(joint.kind, 0, -Screw<>{back.m, back.f}), &tau_back[joint_other.iv]);
    }
    const auto [expected, found] = same.common(tau, tau_back);
    const double scale = std::max({largest(tau), largest(W_0), terms_far_away(trial, recipe.far)});
    springs.expect_equal_work(trial, other_trial);
    torque.expect_equal(found, expected, scale);
    const auto begin = tau_other.begin() + iv;
    base_wrench.expect_equal(std::vector<double>(begin, begin + 6), std::vector<double>(6), scale);
  });
}

/// The mechanism with the frame of every body but those on free joints at another place, on a scene that was
/// displaced by D, together with where the old frames are in the new ones.
Mechanism redrawn(const SE3<>& D, const Mechanism& drawn, Shift& shift, Random<double>& random) {
  Mechanism out = displaced(D, drawn);
  shift = {D, {{"ground", D}}};
  for (DrawnBody& body : out.bodies) {
    if (body.kind == JointKind::free) continue;
    const SE3<> D_body{random.rotation(), random.vector(0.3)};
    shift.frames.emplace(body.name, inverse(D_body));
    body.A = body.A * D_body;
  }
  return out;
}

TEST(InvarianceWithLoops, AccelerationsUnderSpringsAndLoadsDependOnTheMechanismAlone) {
  Comparison acceleration("a", 1e-7);
  OfSprings springs(1e-11);
  int compared = 0;
  for_seeds(250, [&](std::uint64_t seed) {
    Random<double> random(seed);
    // The frame of the body between the parts of a composite joint would move with that of its body.
    const TreeRecipe recipe = elsewhere(seed, {.most_bodies = 12, .composite = false, .always_mass = true});
    const Mechanism drawn = random_mechanism(random, recipe);
    auto here = closed(sprung(drawn, random), recipe.length, random);
    if (!here) return;
    if (here->description.loops.empty()) return;
    ++compared;
    SE3<> D{random.rotation(), random.vector()};
    Shift shift;
    const Mechanism redrawn_there = redrawn(D, drawn, shift, random);
    const Description there = with_parts_of(here->description, described(redrawn_there, random), shift);
    const Model other = built(recipe, there);
    auto [scaled, model, state] = in_units({.length = recipe.scale}, *here);
    std::erase_if(state.wrenches, [](const AppliedWrench<>& load) { return load.frame == 0; });
    make_loads_spatial(model, state);
    const Correspondence same(model, other);
    State<double> other_state = same.carry(state);
    D.r = recipe.scale * D.r;
    for (AppliedWrench<>& load : other_state.wrenches) load = displaced(D, load);
    Trial trial(scalars()[0], model, state), other_trial(scalars()[0], other, other_state);
    springs.expect_equal(same, trial, other_trial);
    const auto accelerations = [&](Trial& t) {
      Ask ask = t.ask();
      ask.tau = t.call("spring_forces");
      return t.call("forward_dynamics", ask);
    };
    const auto [a, a_other] = same.common(accelerations(trial), accelerations(other_trial));
    acceleration.expect_equal(a_other, a);
  });
  EXPECT_GT(compared, 0);
}

}  // namespace
}  // namespace axode::test
