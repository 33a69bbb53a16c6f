#include "axode/constraints.hpp"
#include "axode/constraints/embedding/platform_placement.hpp"
#include "axode/constraints/embedding/task_rates.hpp"
#include "axode/constraints/higher_order/constrained_rates.hpp"
#include "axode/constraints/higher_order/inverse_kinematics_rates.hpp"
#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/drives/elastic_feed_forward.hpp"
#include "axode/io.hpp"
#include "tests/vectors/reference_state.hpp"

/// Motion of higher order: chains of hinges with the motion of a tool to the fourth derivative of its twist,
/// and parallel manipulators with the time derivatives of their drive forces.
namespace axode::test {
namespace {

std::filesystem::path questions_folder() { return vectors_folder() / "paper_questions"; }
/// The files of the folder whose states have a key.
std::vector<std::string> files_with(const char* key) {
  std::vector<std::string> names;
  for (const auto& file : files_ending_in(questions_folder(), ".json")) {
    const Json all = read_json(file);
    if (all.contains("states") && all.at("states").size() > 0 && all.at("states").at(0).contains(key))
      names.push_back(file.stem().string());
  }
  return names.empty() ? std::vector{none} : names;
}
class OfQuestions : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == none) GTEST_SKIP() << missing(questions_folder(), "AXODE_VECTORS");
    file = read_json(questions_folder() / (GetParam() + ".json"));
  }
  Json file;
};

/// f(Rep{}, "body") and so on.
template <class F> void each_representation_by_name(const F& f) {
  f(BodyFixed{}, "body"), f(Spatial{}, "spatial"), f(Hybrid{}, "hybrid"), f(Mixed{}, "mixed");
}
/// The twist and its derivatives, a list of six numbers each.
template <class Rep> std::vector<TwistRate<Rep>> twists_of(const Json& lists) {
  std::vector<TwistRate<Rep>> V;
  for (const Json& list : lists) {
    const Screw<> X = screw_of(list);
    V.push_back({X.w, X.v});
  }
  return V;
}

// ------------------------------------------------------------------------------------------ chains

class ChainsOfHinges : public OfQuestions {};
INSTANTIATE_TEST_SUITE_P(Vectors, ChainsOfHinges, testing::ValuesIn(files_with("joints")), name_of);

/// A chain of hinges with a frame "tool", and its coordinates with their derivatives.
struct Chain {
  explicit Chain(const Json& state) : model(drawn(state)), n(state.at("joints").size()) {
    q = numbers(state.at("q").at(0));
    for (std::size_t k = 1; k < state.at("q").size(); ++k)
      for (const double x : numbers(state.at("q").at(k))) rates.push_back(x);
  }
  static Model drawn(const Json& state) {
    Description d{.name = "chain", .bodies = {}, .frames = {}};
    std::string last = "ground";
    for (const Json& joint : state.at("joints")) {
      const std::string name = std::to_string(d.bodies.size() + 1);
      d.bodies.push_back({.name = name,
                          .predecessor = last,
                          .joint = {.kind = JointKind::revolute,
                                    .axis = vec3(joint.at("axis")),
                                    .point = vec3(joint.at("point"))},
                          .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1, 0, 0, 0}}});
      last = name;
    }
    d.frames.push_back({.name = "tool",
                        .body = last,
                        .pose = {{}, vec3(state.at("tool"))},
                        .in = GivenIn::construction_frame});
    return ModelBuilder(d).build();
  }
  int order() const { return static_cast<int>(rates.size() / n) - 1; }

  Model model;
  std::size_t n;
  std::vector<double> q, rates;
};

TEST_P(ChainsOfHinges, MoveTheirToolsInEveryRepresentation) {
  Comparison pose_of("pose", bound), twist("twist", bound);
  for (const Json& state : file.at("states")) {
    const Chain chain(state);
    Workspace<> workspace(chain.model);
    const SE3<> C{so3(state.at("R")), vec3(state.at("r"))};
    std::vector<SE3<>> frames(static_cast<std::size_t>(chain.model.n_frames()));
    poses<double>(chain.model, workspace, chain.q, frames);
    pose_of.expect_equal(frames[static_cast<std::size_t>(chain.model.frame_index("tool"))], C);
    HigherOrderMotion<> motion(chain.model, chain.order());
    motion.evaluate(chain.q, chain.rates);
    each_representation_by_name([&](auto rep, const char* name) {
      using Rep = decltype(rep);
      const std::vector<TwistRate<Rep>> V = twists_of<Rep>(state.at("V").at(name));
      for (int k = 0; k < static_cast<int>(V.size()); ++k)
        twist.expect_equal(motion.twist_derivative<Rep>("tool", k), V[static_cast<std::size_t>(k)]);
    });
  }
}

TEST_P(ChainsOfHinges, FollowTheirToolsInEveryRepresentation) {
  Comparison rates_of("rates", 1e-8), back("twist", 1e-11);  // conditioned by powers of that of J
  for (const Json& state : file.at("states")) {
    const Chain chain(state);
    each_representation_by_name([&](auto rep, const char* name) {
      using Rep = decltype(rep);
      const std::vector<TwistRate<Rep>> V = twists_of<Rep>(state.at("V").at(name));
      const TwistTarget<Rep> target{"tool", V};
      std::vector<double> found(V.size() * chain.n);
      const RatesReached reached =
          inverse_kinematics_rates<Rep>(chain.model, chain.q, std::span(&target, 1), found);
      ASSERT_EQ(reached.orders, static_cast<int>(V.size()));
      const auto row = [&](const std::vector<double>& all, std::size_t k) {
        const auto first = all.begin() + static_cast<std::ptrdiff_t>(k * chain.n);
        return std::vector<double>(first, first + static_cast<std::ptrdiff_t>(chain.n));
      };
      HigherOrderMotion<> motion(chain.model, static_cast<int>(V.size()) - 1);
      motion.evaluate(chain.q, found);
      for (std::size_t k = 0; k < V.size(); ++k) {
        rates_of.expect_equal(row(found, k), row(chain.rates, k));
        back.expect_equal(motion.twist_derivative<Rep>("tool", static_cast<int>(k)), V[k]);
      }
    });
  }
}

// -------------------------------------------------------------------------- parallel manipulators

class ParallelManipulators : public OfQuestions {};
INSTANTIATE_TEST_SUITE_P(Vectors, ParallelManipulators, testing::ValuesIn(files_with("lengths")), name_of);

/// A platform on legs with drives, in a pose of the platform.
struct Platform {
  Platform(const Json& file, const Json& state)
      : model(load(std::filesystem::path(AXODE_SOURCE_DIR "/examples/robots") / file.at("mechanism").text())),
        workspace(model) {
    const Joint& base = model.joint(model.body_index("platform"));
    const SE3<> C{so3(state.at("R")), vec3(state.at("r"))};
    q = neutral(model);
    const Quaternion<> a = quaternion(C.R);
    const double numbers_of_pose[]{a.x, a.y, a.z, a.w, C.r.x, C.r.y, C.r.z};
    std::copy_n(numbers_of_pose, 7, q.begin() + base.iq);
    for (int c = 0; c < 6; ++c) own.push_back(base.iv + c);
    for (int c = 0; c < model.nv(); ++c)
      if (model.loops().driven[static_cast<std::size_t>(c)]) drives.push_back(c);
    AssemblyResult closed = assemble(model, q, {}, {.tolerance = 1e-15, .held = own});
    EXPECT_EQ(closed.status, AssemblyStatus::closed) << to_string(model, closed);
    q = closed.q;
  }
  /// The distances from the feet to the balls at the tops of the legs.
  std::vector<double> leg_lengths() {
    LoopSystem<double>& system = workspace.system(model);
    system.update_kinematics(q.data());
    std::vector<double> all;
    for (const Loop& ball : model.loops().joints) {
      const auto& [rod, F] = ball.ends[0];
      const int lower = model.topology().parent[rod];  // whose internal frame is at the foot
      all.push_back(norm(system.link(rod).C * F.r - system.link(lower).C.r));
    }
    return all;
  }
  /// The entries of x that belong to velocities with drives.
  std::vector<double> of_drives(std::span<const double> x) const {
    std::vector<double> out;
    for (const int c : drives) out.push_back(x[static_cast<std::size_t>(c)]);
    return out;
  }
  Model model;
  LoopWorkspace<> workspace;
  std::vector<double> q;
  std::vector<int> own, drives;  ///< velocities of the platform and of the drives
};

TEST_P(ParallelManipulators, HaveTheirJacobiansForcesAndTimeDerivatives) {
  Comparison lengths("lengths", bound), J("J", bound), M("M", bound), bias("bias", bound),
      forces("forces", 1e-11);
  for (const Json& state : file.at("states")) {
    Platform at(file, state);
    const Model& model = at.model;
    const std::size_t nv = static_cast<std::size_t>(model.nv());
    std::vector<TwistRate<BodyFixed>> V;
    for (const char* const key : {"V", "dV", "ddV", "dddV"}) {
      const Screw<> X = screw_of(state.at(key));
      V.push_back({X.w, X.v});
    }
    const TwistTarget<BodyFixed> target{"platform", V};
    std::vector<double> rates(4 * nv), tau(3 * nv);
    ASSERT_EQ(inverse_kinematics_rates<BodyFixed>(model, at.q, std::span(&target, 1), rates).orders, 4);
    lengths.expect_equal(at.leg_lengths(), numbers(state.at("lengths")));
    const IndependentEquations equations =
        independent_equations(model, at.q, std::span(rates).first(nv), at.own);
    Eigen::MatrixXd legs(6, 6);
    for (std::size_t k = 0; k < 6; ++k)
      legs.row(static_cast<Eigen::Index>(k)) = equations.N.row(at.drives[k]);
    const auto rows = [](const Eigen::MatrixXd& A) { return entries(Eigen::MatrixXd(A.transpose())); };
    J.expect_equal(rows(legs), numbers(state.at("J")));
    M.expect_equal(rows(equations.M), numbers(state.at("M")));
    bias.expect_equal(entries(equations.h), numbers(state.at("bias")));
    EXPECT_LT(inverse_dynamics_rates(model, at.workspace, at.q, rates, tau), 1e-9);
    std::size_t k = 0;
    for (const char* const key : {"Q", "dQ", "ddQ"})
      forces.expect_equal(at.of_drives(std::span<const double>(tau).subspan(nv * k++, nv)),
                          numbers(state.at(key)));
  }
}

/// With springs the motors have θ = q + Q/k, θ' = v + Q'/k and u = Q + I (a + Q''/k), from the reference
/// values of lengths, Jacobians and forces.
TEST_P(ParallelManipulators, AreFlatWithElasticDrives) {
  const double k = 1e5, I = 20;
  Comparison position("θ", bound), velocity("θ'", 1e-11), force("u", 1e-11);
  for (const Json& state : file.at("states")) {
    Platform at(file, state);
    const std::size_t nv = static_cast<std::size_t>(at.model.nv());
    TaskSpace space(at.model, neutral(at.model), "platform");
    std::vector<double> rates;
    for (const char* const key : {"V", "dV", "ddV", "dddV"})
      for (const double x : numbers(state.at(key))) rates.push_back(x);
    ElasticFeedForward drives(at.model, std::vector<ElasticDrive>(nv, {k, I}));
    MotorMotion motors;
    ASSERT_TRUE(drives.evaluate(space, at.q, rates, motors).ok());

    std::vector<double> v(nv), a(nv);
    ASSERT_TRUE(space.velocities(at.q, numbers(state.at("V")), v).ok());
    ASSERT_TRUE(space.accelerations(at.q, v, numbers(state.at("dV")), a).ok());
    const std::vector<double> Q = numbers(state.at("Q")), dQ = numbers(state.at("dQ")),
                              ddQ = numbers(state.at("ddQ")), lengths = numbers(state.at("lengths")),
                              legs = at.leg_lengths(), v_d = at.of_drives(v), a_d = at.of_drives(a);
    std::vector<double> theta, rate, u;
    for (std::size_t d = 0; d < at.drives.size(); ++d) {
      const double wanted = lengths[d] + Q[d] / k;  // the coordinate of a drive is the length less a constant
      for (const Joint& joint : at.model.joints())
        if (joint.iv == at.drives[d] && joint.nq == 1)
          theta.push_back(wanted - legs[d] + at.q[static_cast<std::size_t>(joint.iq)]);
      rate.push_back(v_d[d] + dQ[d] / k);
      u.push_back(Q[d] + I * (a_d[d] + ddQ[d] / k));
    }
    position.expect_equal(at.of_drives(motors.position), theta, 1);
    velocity.expect_equal(at.of_drives(motors.velocity), rate);
    force.expect_equal(at.of_drives(motors.force), u);
  }
}

/// Limb by limb, from the pose of the platform alone.
TEST_P(ParallelManipulators, AreResolvedLimbByLimb) {
  Comparison lengths("lengths", bound), J("J", bound), M("M", bound), bias("bias", bound),
      forces("forces", 1e-11), accelerations("dV", 1e-11);
  for (const Json& state : file.at("states")) {
    Platform at(file, state);
    const Model& model = at.model;
    const std::size_t nv = static_cast<std::size_t>(model.nv());
    TaskSpace space(model, neutral(model), "platform");
    ASSERT_EQ(space.freedom(), 6);
    at.q = neutral(model);
    ASSERT_TRUE(place_platform(space, {so3(state.at("R")), vec3(state.at("r"))}, at.q).reached);
    lengths.expect_equal(at.leg_lengths(), numbers(state.at("lengths")));

    const std::vector<double> V = numbers(state.at("V")), dV = numbers(state.at("dV"));
    std::vector<double> rates, v(nv), a(nv), tau(nv), dV_found(6);
    for (const char* const key : {"V", "dV", "ddV", "dddV"})
      for (const double x : numbers(state.at(key))) rates.push_back(x);
    ASSERT_TRUE(space.velocities(at.q, V, v).ok());
    ASSERT_TRUE(space.accelerations(at.q, v, dV, a).ok());
    const TaskEquations equations = space.equations(at.q, v);
    const auto rows = [](const Eigen::MatrixXd& A) { return entries(Eigen::MatrixXd(A.transpose())); };
    J.expect_equal(rows(equations.J), numbers(state.at("J")));
    M.expect_equal(rows(equations.M), numbers(state.at("M")));
    bias.expect_equal(entries(equations.h), numbers(state.at("bias")));

    ASSERT_TRUE(space.inverse_dynamics(at.q, v, dV, tau).ok());
    forces.expect_equal(at.of_drives(tau), numbers(state.at("Q")));
    EXPECT_EQ(inverse_dynamics<double>(model, at.workspace, at.q, v, a, tau), 0);
    forces.expect_equal(at.of_drives(tau), numbers(state.at("Q")));
    ASSERT_TRUE(space.forward_dynamics(at.q, v, tau, dV_found).ok());
    accelerations.expect_equal(dV_found, dV);
    std::vector<double> all(3 * nv);
    ASSERT_TRUE(inverse_dynamics_rates(space, at.q, rates, all).ok());
    std::size_t k = 0;
    for (const char* const key : {"Q", "dQ", "ddQ"})
      forces.expect_equal(at.of_drives(std::span<const double>(all).subspan(nv * k++, nv)),
                          numbers(state.at(key)));
  }
}

}  // namespace
}  // namespace axode::test
