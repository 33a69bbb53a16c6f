#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "axode/dynamics.hpp"
#include "axode/io.hpp"
#include "axode/lie/representation_change.hpp"
#include "tests/apps/run_command.hpp"
#include "tests/support/comparison.hpp"

namespace axode::test {
namespace {

using Json = nlohmann::ordered_json;
using Numbers = std::vector<double>;

constexpr std::array representation_names{"body", "spatial", "hybrid", "mixed"};
constexpr std::array representation_values{Representation::body, Representation::spatial,
                                           Representation::hybrid, Representation::mixed};

/// A state in which every joint moves; its numbers are the same on every machine.
struct Moving {
  Numbers q, v, a;
  explicit Moving(const Model& model) : q(random_configuration(model, 11)), v(model.nv()), a(model.nv()) {
    for (std::size_t k = 0; k < v.size(); ++k) {
      v[k] = std::sin(1.0 + static_cast<double>(k));
      a[k] = 3 * std::cos(2.0 + static_cast<double>(k));
    }
  }
  Json json() const { return {{"q", q}, {"v", v}, {"a", a}}; }
};

Json eval(const std::string& file, const Json& state, std::vector<std::string> options) {
  options.insert(options.begin(), {"eval", file, "--state", "-", "--format", "json"});
  const Outcome outcome = axode(options, state.dump());
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  return outcome.code == 0 ? Json::parse(outcome.out) : Json();
}

Numbers drive_forces(const std::string& file, const Json& state, std::vector<std::string> options = {}) {
  options.insert(options.end(), {"--want", "inverse_dynamics"});
  return eval(file, state, std::move(options))["results"]["inverse_dynamics"];
}

template <class Six> Numbers six(const Six& x) {
  const auto& [a, b] = x;
  return {a.x, a.y, a.z, b.x, b.y, b.z};
}

double difference(const Numbers& x, const Numbers& y) {
  EXPECT_EQ(x.size(), y.size());
  double largest = 0;
  for (std::size_t k = 0; k < std::min(x.size(), y.size()); ++k)
    largest = std::max(largest, std::abs(x[k] - y[k]));
  return largest;
}

TEST(Eval, NamesTheModelItsSizesAndItsJointsInOrder) {
  const Json out = eval(robot("arm7.toml"), Json::object(), {});
  EXPECT_EQ(out["model"], "arm7");
  EXPECT_EQ(out["nq"], 7);
  EXPECT_EQ(out["nv"], 7);
  EXPECT_EQ(out["joints"], (Json{"A1", "A2", "A3", "A4", "A5", "A6", "A7"}));
  EXPECT_TRUE(out["results"].is_object());
}

/// Every number that `axode eval` prints equals that of the library to the last bit, in every representation.
class EvalInRepresentation : public testing::TestWithParam<int> {};

TEST_P(EvalInRepresentation, GivesTheNumbersOfTheLibrary) {
  const Model model = load(robot("machine.toml"));
  const Moving state(model);
  const Json out = eval(robot("machine.toml"), state.json(),
                        {"--representation", representation_names[GetParam()], "--want",
                         "inverse_dynamics,poses,twists,accelerations,joint_wrenches,center_of_mass"});
  EXPECT_EQ(out["representation"], representation_names[GetParam()]);
  const Json& results = out["results"];
  Workspace<> workspace(model);
  with_representation(representation_values[GetParam()], [&](auto rep) {
    using Rep = decltype(rep);
    Numbers tau(model.nv());
    inverse_dynamics<Rep>(model, workspace, state.q, state.v, state.a, tau);
    EXPECT_EQ(results["inverse_dynamics"].get<Numbers>(), tau);

    std::vector<SE3<>> C(model.n_frames());
    std::vector<Twist<Rep>> V(model.n_frames());
    std::vector<TwistRate<Rep>> dV(model.n_frames());
    poses(model, workspace, state.q, C);
    twists<Rep>(model, workspace, state.q, state.v, V);
    accelerations<Rep>(model, workspace, state.q, state.v, state.a, dV);
    ASSERT_EQ(results["poses"].size(), C.size());
    for (int f = 0; f < model.n_frames(); ++f) {
      const std::string& name = model.frame(f).name;
      const auto& [R, r] = C[f];
      EXPECT_EQ(results["poses"][name], (Json{{R.x.x, R.y.x, R.z.x, r.x},
                                              {R.x.y, R.y.y, R.z.y, r.y},
                                              {R.x.z, R.y.z, R.z.z, r.z},
                                              {0.0, 0.0, 0.0, 1.0}}));
      EXPECT_EQ(results["twists"][name].get<Numbers>(), six(V[f]));
      EXPECT_EQ(results["accelerations"][name].get<Numbers>(), six(dV[f]));
    }
    std::vector<Wrench<Rep>> W(model.n_bodies());
    joint_wrenches<Rep>(model, workspace, state.q, state.v, state.a, W);
    ASSERT_EQ(results["joint_wrenches"].size(), W.size());
    for (int i = 1; i <= model.n_bodies(); ++i)
      EXPECT_EQ(results["joint_wrenches"][model.joint(i).name].get<Numbers>(), six(W[i - 1]));
    const Vec3<> c = center_of_mass(model, workspace, state.q);
    EXPECT_EQ(results["center_of_mass"].get<Numbers>(), (Numbers{c.x, c.y, c.z}));
  });
}
INSTANTIATE_TEST_SUITE_P(Four, EvalInRepresentation, testing::Range(0, 4),
                         [](const auto& p) { return representation_names[p.param]; });

TEST(Eval, ResultsComeInTheOrderInWhichTheyWereAskedFor) {
  const Json out = eval(robot("arm7.toml"), Json::object(), {"--want", "twists,inverse_dynamics,poses"});
  std::vector<std::string> names;
  for (const auto& item : out["results"].items()) names.push_back(item.key());
  EXPECT_THAT(names, testing::ElementsAre("twists", "inverse_dynamics", "poses"));
}

TEST(Eval, TakesStatesByJointNameInAnyOrderAsWellAsArrays) {
  const Model model = load(robot("machine.toml"));
  const Moving state(model);
  Json by_name;
  for (int i = model.n_bodies(); i > 0; --i) {
    const Joint& joint = model.joint(i);
    if (joint.leader) continue;
    const auto part = [](const Numbers& x, int first, int count) {
      return count == 1 ? Json(x[first]) : Json(Numbers(x.begin() + first, x.begin() + first + count));
    };
    by_name["q"][joint.name] = part(state.q, joint.iq, joint.nq);
    by_name["v"][joint.name] = part(state.v, joint.iv, joint.nv);
    by_name["a"][joint.name] = part(state.a, joint.iv, joint.nv);
  }
  EXPECT_EQ(drive_forces(robot("machine.toml"), by_name), drive_forces(robot("machine.toml"), state.json()));
}

TEST(Eval, OneNumberMayStandInAnArray) {
  EXPECT_EQ(drive_forces(robot("arm7.toml"), {{"q", {{"A4", {0.5}}}}}),
            drive_forces(robot("arm7.toml"), {{"q", {{"A4", 0.5}}}}));
}

TEST(Eval, MissingJointsAreNeutralOrAtRest) {
  const Model model = load(robot("humanoid.urdf"), Base::free);
  Numbers q = neutral(model);
  q[model.joint(model.joint_index("left_knee")).iq] = 0.7;
  const Json by_name{{"q", {{"left_knee", 0.7}}}};
  EXPECT_EQ(drive_forces(robot("humanoid.urdf"), by_name, {"--base", "free"}),
            drive_forces(robot("humanoid.urdf"), {{"q", q}}, {"--base", "free"}));
}

TEST(Eval, WithoutAStateTheModelIsNeutralAndAtRest) {
  const Outcome outcome = axode({"eval", robot("double_pendulum.toml"), "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(Json::parse(outcome.out),
            eval(robot("double_pendulum.toml"), {{"q", {0, 0}}, {"v", {0, 0}}}, {}));
}

TEST(Eval, ReadsTheStateFromAFileOrFromStandardInput) {
  const TemporaryFolder folder;
  const std::string state = folder.write("state.json", R"({"q": {"elbow": 0.5}})");
  const Outcome outcome =
      axode({"eval", robot("double_pendulum.toml"), "--state", state, "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(Json::parse(outcome.out), eval(robot("double_pendulum.toml"), {{"q", {{"elbow", 0.5}}}}, {}));
}

TEST(Eval, AFreeBaseComesFirstWithSevenCoordinatesAndSixVelocities) {
  const Json out = eval(robot("humanoid.urdf"), Json::object(), {"--base", "free"});
  const Json fixed = eval(robot("humanoid.urdf"), Json::object(), {"--base", "fixed"});
  EXPECT_EQ(out["joints"][0], "free_base");
  EXPECT_EQ(out["nq"], fixed["nq"].get<int>() + 7);
  EXPECT_EQ(out["nv"], fixed["nv"].get<int>() + 6);
}

TEST(Eval, CoupledJointsAreNamedApartAndHaveNoNumbers) {
  const Json out = eval(robot("machine.toml"), Json::object(), {});
  EXPECT_EQ(out["coupled_joints"], Json::array({"carriage slide"}));
  EXPECT_EQ(std::count(out["joints"].begin(), out["joints"].end(), "carriage slide"), 0);
  int nq = 0, nv = 0;
  for (const Json& joint : out["joints"]) {
    const Json& layout = out["layout"][joint.get<std::string>()];
    EXPECT_EQ(layout["iq"], nq);
    EXPECT_EQ(layout["iv"], nv);
    nq += layout["nq"].get<int>(), nv += layout["nv"].get<int>();
  }
  EXPECT_EQ(out["nq"], nq);
  EXPECT_EQ(out["nv"], nv);
  EXPECT_EQ(out["results"]["inverse_dynamics"].size(), nv);
}

/// A load gives the same drive forces in whichever of the four representations it is given, and these are the
/// forces that the library computes.
TEST(Eval, ALoadIsTheSameInWhicheverRepresentationItIsGiven) {
  const Model model = load(robot("arm7.toml"));
  const Moving state(model);
  const int flange = model.frame_index("flange");
  Workspace<> workspace(model);
  std::vector<SE3<>> C(model.n_frames());
  poses(model, workspace, state.q, C);
  const Wrench<BodyFixed> W{{1, -2, 3}, {10, 20, -30}};
  Numbers expected(model.nv());
  const std::vector<AppliedWrench<>> loads{{flange, W}};
  inverse_dynamics(model, workspace, state.q, state.v, state.a, expected, {.wrenches = loads});
  const Numbers unloaded = drive_forces(robot("arm7.toml"), state.json());
  EXPECT_GT(difference(unloaded, expected), 1);

  for (std::size_t r = 0; r < representation_names.size(); ++r) {
    with_representation(representation_values[r], [&](auto rep) {
      Json loaded = state.json();
      loaded["loads"] = {{{"frame", "flange"},
                          {"representation", representation_names[r]},
                          {"wrench", six(change<decltype(rep)>(C[flange], W))}}};
      EXPECT_LE(difference(drive_forces(robot("arm7.toml"), loaded), expected), 1e-13 * largest(expected))
          << representation_names[r];
    });
  }
}

TEST(Eval, ALoadThatDoesNotSayIsBodyFixedAndLoadsAdd) {
  Json state{{"q", {{"A2", 0.4}, {"A4", -0.8}}}};
  state["loads"] = {{{"frame", "flange"}, {"representation", "body"}, {"wrench", {0, 3, 0, 4, 0, -10}}}};
  const Numbers once = drive_forces(robot("arm7.toml"), state);
  state["loads"][0].erase("representation");
  EXPECT_EQ(drive_forces(robot("arm7.toml"), state), once);
  state["loads"] = {{{"frame", "flange"}, {"wrench", {0, 3, 0, 0, 0, 0}}},
                    {{"frame", "flange"}, {"wrench", {0, 0, 0, 4, 0, -10}}}};
  EXPECT_LE(difference(drive_forces(robot("arm7.toml"), state), once), 1e-13 * largest(once));
}

TEST(Eval, GravityCanBeReplaced) {
  const Json bent{{"q", {{"A2", 1.0}}}};
  EXPECT_GT(largest(drive_forces(robot("arm7.toml"), bent)), 10);
  EXPECT_EQ(largest(drive_forces(robot("arm7.toml"), bent, {"--gravity", "0,0,0"})), 0);
  Numbers doubled = drive_forces(robot("arm7.toml"), bent, {"--gravity", "0,0,-19.62"});
  for (double& x : doubled) x /= 2;
  EXPECT_LE(difference(doubled, drive_forces(robot("arm7.toml"), bent)), 1e-13 * largest(doubled));
  EXPECT_EQ(eval(robot("arm7.toml"), bent, {"--gravity", "-1.5,0,2"})["gravity"], (Json{-1.5, 0.0, 2.0}));
}

TEST(Eval, DampingAndFrictionCountOnlyWhenAsked) {
  const Json moving{{"v", {{"feed", 10.0}}}};
  const Model model = load(robot("machine.toml"));
  const int feed = model.joint(model.joint_index("feed")).iv;
  const Numbers without = drive_forces(robot("machine.toml"), moving);
  const Numbers with = drive_forces(robot("machine.toml"), moving, {"--joint-losses"});
  EXPECT_NEAR(with[feed] - without[feed], 0.002 * 10, 1e-12);
}

TEST(Eval, TheTableNamesEveryJointAndSaysInWhichAxes) {
  const Outcome outcome = axode({"eval", robot("machine.toml"), "--want",
                                 "inverse_dynamics,poses,twists,accelerations,joint_wrenches,center_of_mass",
                                 "--representation", "hybrid"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Model model = load(robot("machine.toml"));
  for (const Joint& joint : model.joints()) EXPECT_THAT(outcome.out, testing::HasSubstr(joint.name));
  for (const Frame& frame : model.frames()) EXPECT_THAT(outcome.out, testing::HasSubstr(frame.name));
  for (const char* said :
       {"hybrid: in inertial axes, v = r' of the frame's origin; rad/s, m/s",
        "v' = r'' of the frame's origin; rad/s^2, m/s^2", "about the body's origin; N m, N", "quaternion x",
        "N m for angles, N for lengths"})
    EXPECT_THAT(outcome.out, testing::HasSubstr(said));
}

TEST(Eval, SaysThatALoopIsOpenAtTheState) {
  const std::string file = robot("four_bar.toml");
  const Json open{{"q", {{"crank_joint", 0.5}}}}, parting{{"v", {{"crank_joint", 0.5}}}};
  EXPECT_FALSE(eval(file, Json::object(), {}).contains("warnings"));
  EXPECT_FALSE(eval(file, open, {"--assemble"}).contains("warnings"));
  for (const auto& [state, what] : {std::pair{open, "q leaves loop \"pin\" open by "},
                                    {parting, "v does not keep loop \"pin\" closed"}}) {
    const std::vector<std::string> mass{"eval", file, "--state", "-", "--want", "mass_matrix"};
    EXPECT_THAT(eval(file, state, {"--want", "mass_matrix"})["warnings"][0].get<std::string>(),
                testing::HasSubstr(what));
    const Outcome shown = axode(mass, state.dump());
    EXPECT_EQ(shown.code, 0);
    EXPECT_THAT(shown.out, testing::HasSubstr(std::string("warning: ") + what));
    std::vector<std::string> strict = mass;
    strict.push_back("--strict");
    const Outcome refused = axode(strict, state.dump());
    EXPECT_EQ(refused.code, 1);
    EXPECT_THAT(refused.err, testing::HasSubstr(what));
  }
  const TemporaryFolder folder;
  const std::string sweep = folder.write("sweep.csv",
                                         "t,q crank_joint,q coupler_joint,q rocker_joint\n"
                                         "0,0,0,0\n0.1,0.5,0,0\n");
  std::vector<std::string> mass{"eval", file, "--state", sweep, "--want", "mass_matrix"};
  EXPECT_THAT(axode(mass).out, testing::HasSubstr("warning: state 1: q leaves loop \"pin\" open by "));
  mass.emplace_back("--strict");
  EXPECT_THAT(axode(mass).err, testing::StartsWith("axode eval: state 1: q leaves loop \"pin\" open by "));
}

/// The loops of the second state cannot be closed, and the second quantity has no value at the first state.
TEST(Eval, ASweepClosesTheLoopsOfAStateOnceForAllQuantities) {
  const TemporaryFolder folder;
  const std::string sweep = folder.write("sweep.csv",
                                         "t,q crank_joint,q coupler_joint,q rocker_joint,a crank_joint\n"
                                         "0,0,0,0,1\n0.1,0.5,0,0,0\n");
  std::vector<std::string> words{"eval", robot("four_bar.toml"), "--state", sweep, "--assemble"};
  for (const char* joint : {"crank_joint", "coupler_joint", "rocker_joint"})
    words.insert(words.end(), {"--hold", joint});
  words.emplace_back("--want");
  const auto error = [&](const char* quantities) {
    words.emplace_back(quantities);
    const Outcome outcome = axode(words);
    words.pop_back();
    EXPECT_EQ(outcome.code, 1) << outcome.out;
    return outcome.err;
  };
  EXPECT_THAT(error("mass_matrix"), testing::AllOf(testing::StartsWith("axode eval: state 1: "),
                                                   testing::HasSubstr("stays open by ")));
  EXPECT_THAT(error("mass_matrix,inverse_dynamics"),
              testing::StartsWith("axode eval: state 0: a does not keep loop \"pin\" closed"));
  *std::ranges::find(words, "crank_joint") = "crank";
  EXPECT_THAT(error("mass_matrix"),
              testing::StartsWith("axode eval: model \"four-bar\" has no joint \"crank\""));
}

TEST(Eval, DistancesHaveNearestPointsCertificatesAndJacobians) {
  const std::string file = AXODE_SOURCE_DIR "/tests/data/good/contact.toml";
  const Json out = eval(file, {{"q", {{"finger_joint", 0.1}}}}, {"--want", "distances"});
  const Json& found = out["results"]["distances"];
  ASSERT_EQ(found.size(), 2U);  // the table ignores the puck
  EXPECT_EQ(found[0]["a"], "table");
  EXPECT_NEAR(found[0]["distance"].get<double>(), -0.02, 1e-15);
  EXPECT_EQ(found[1]["b"], "puck shape 1");
  EXPECT_NEAR(found[1]["distance"].get<double>(), 0.16, 1e-15);
  EXPECT_NEAR(found[1]["point_b"][2].get<double>(), 0.02, 1e-15);
  EXPECT_LT(found[1]["residual"].get<double>(), 1e-15);
  EXPECT_LT(difference(found[1]["jacobian"].get<Numbers>(), {1, 0, 0, 0}), 1e-14);
}

TEST(Eval, EveryJsonResultSaysWhatItIs) {
  const Json out =
      eval(robot("arm7.toml"), Json::object(), {"--want", "poses,twists,accelerations,joint_wrenches"});
  for (const auto& item : out["results"].items())
    EXPECT_GT(out["labels"][item.key()].get<std::string>().size(), 20U) << item.key();
}

TEST(Eval, TenThousandBodiesInOneChain) {
  constexpr int n = 10000;
  const TemporaryFolder folder;
  std::ostringstream text;
  text << "<robot name=\"chain\">\n<link name=\"l0\"/>\n";
  for (int i = 1; i <= n; ++i)
    text << "<link name=\"l" << i << "\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" "
         << "ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\n<joint name=\"j" << i
         << "\" type=\"continuous\"><parent link=\"l" << i - 1 << "\"/><child link=\"l" << i
         << "\"/><origin xyz=\"0 0 0.1\"/><axis xyz=\"0 1 0\"/></joint>\n";
  text << "</robot>\n";
  const std::string file = folder.write("chain.urdf", text.str());
  // The first joint turns the chain by 90 degrees, so that it is level. Its drive then carries the moments of
  // the weights of all bodies.
  const Json out = eval(file, {{"q", {{"j1", M_PI / 2}}}}, {"--want", "inverse_dynamics"});
  const Numbers tau = out["results"]["inverse_dynamics"];
  ASSERT_EQ(tau.size(), n);
  const double expected = -9.81 * 0.1 * (n - 1.0) * n / 2;
  EXPECT_NEAR(tau[0], expected, 1e-9 * std::abs(expected));
  EXPECT_EQ(axode({"info", file}).code, 0);
}

}  // namespace
}  // namespace axode::test
