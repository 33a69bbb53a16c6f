#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "axode/dynamics.hpp"
#include "axode/integration.hpp"
#include "axode/io.hpp"
#include "axode/model/configuration.hpp"
#include "tests/apps/run_command.hpp"

/// `axode simulate` prints and writes the motions that the library computes.
namespace axode::test {
namespace {

using Motion = nlohmann::ordered_json;
using testing::StartsWith;

const std::string swinging = robot("double_pendulum.toml");
const std::string raised = R"({"q": {"pin": 2, "elbow": 0.5}, "v": [0.1, 0.2]})";

Motion motion_of(std::vector<std::string> more) {
  std::vector<std::string> words{"simulate", swinging, "--state", "-", "--format", "json"};
  words.insert(words.end(), more.begin(), more.end());
  const Outcome outcome = axode(words, raised);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return outcome.code == 0 ? Motion::parse(outcome.out) : Motion();
}

TEST(SimulateCommand, GivesTheMotionOfTheLibrary) {
  const Model model = load(swinging);
  std::vector<double> q = neutral(model), v{0.1, 0.2};
  const auto at = [&](const char* joint) {
    return static_cast<std::size_t>(model.joint(model.joint_index(joint)).iq);
  };
  q[at("pin")] = 2, q[at("elbow")] = 0.5;
  const Trajectory expected = simulate(model, q, v, 2.0);
  const Motion found = motion_of({"--until", "2"});
  ASSERT_EQ(found.at("t").size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k)
    for (std::size_t c = 0; c < 2; ++c) {
      EXPECT_EQ(found.at("q")[k][c].get<double>(), expected.q(k)[c]);
      EXPECT_EQ(found.at("v")[k][c].get<double>(), expected.v(k)[c]);
    }
  EXPECT_EQ(found.at("steps"), expected.steps);
  const std::vector<double> energy = found.at("energy").get<std::vector<double>>();
  EXPECT_LE(*std::ranges::max_element(energy) - *std::ranges::min_element(energy), 1e-5);
  std::vector<double> q_half(2), v_half(2);
  expected.at(0.5, q_half, v_half);
  for (const char* method : {"rk4", "euler"}) {
    const Motion other = motion_of({"--until", "0.5", "--method", method, "--step", "0.0005"});
    EXPECT_EQ(other.at("t").size(), 1001u);
    EXPECT_NEAR(other.at("q").back()[0].get<double>(), q_half[0], std::string(method) == "rk4" ? 1e-6 : 0.01);
  }
}

TEST(SimulateCommand, PrintsTheEnergyAtTheStartAndAtTheEndAndItsLargestDeviation) {
  const std::vector<std::string> braked{"--until", "2", "--pd", "1,3"};
  const std::vector<double> energy = motion_of(braked).at("energy").get<std::vector<double>>();
  std::vector<std::string> words{"simulate", swinging, "--state", "-"};
  words.insert(words.end(), braked.begin(), braked.end());
  const std::string shown = axode(words, raised).out;
  double start = 0, end = 0, deviation = 0;
  const std::size_t at = shown.find("; energy ");
  ASSERT_NE(at, std::string::npos) << shown;
  ASSERT_EQ(std::sscanf(shown.c_str() + at,
                        "; energy %lf J at the start, %lf J at the end, at most %lf J off the start", &start,
                        &end, &deviation),
            3)
      << shown;
  EXPECT_LT(end, start - 1);
  EXPECT_NEAR(start, energy.front(), 1e-5 * std::abs(energy.front()));
  EXPECT_NEAR(end, energy.back(), 1e-5 * std::abs(energy.back()));
  double largest = 0;
  for (const double x : energy) largest = std::max(largest, std::abs(x - energy.front()));
  EXPECT_NEAR(deviation, largest, 0.06 * largest);
}

TEST(SimulateCommand, LeadsTheJointsWhereItIsTold) {
  TemporaryFolder folder;
  const std::string target = folder.file("target.json");
  std::ofstream(target) << R"({"q": {"pin": 1}, "v": [0.5, 0]})";
  const Model model = load(swinging);
  std::vector<double> q = neutral(model), q_d = q;
  const auto at = [&](const char* joint) {
    return static_cast<std::size_t>(model.joint(model.joint_index(joint)).iq);
  };
  q[at("pin")] = 2, q[at("elbow")] = 0.5, q_d[at("pin")] = 1;
  SimulationOptions options;
  const std::vector<double> kp{300}, kd{40};
  options.drive = ProportionalDerivative(model, {kp, kd}, {model, q_d, std::vector<double>{0.5, 0}});
  const Trajectory expected = simulate(model, q, std::vector<double>{0.1, 0.2}, 1.0, {}, options);
  const Motion found = motion_of({"--pd", "300,40", "--target", target});
  for (std::size_t c = 0; c < 2; ++c)
    EXPECT_NEAR(found.at("q").back()[c].get<double>(), expected.q(expected.size() - 1)[c], 1e-12);
}

TEST(SimulateCommand, WritesFiles) {
  TemporaryFolder folder;
  const std::string csv = folder.file("run.csv"), npz = folder.file("run.npz"),
                    json = folder.file("run.json");
  const Outcome outcome = axode({"simulate", swinging, "--state", "-", "--until", "1", "--samples", "10",
                                 "--output", csv, "--output", npz, "--output", json},
                                raised);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, testing::HasSubstr("at t = 1 s after "));
  const std::string text = contents(csv);
  EXPECT_THAT(
      text,
      StartsWith(
          "\"t\",\"q pin\",\"q elbow\",\"v pin\",\"v elbow\",\"a pin\",\"a elbow\",\"tau pin\",\"tau elbow\","
          "\"energy\"\n0,2,0.5,0.1,0.2,"));
  EXPECT_EQ(std::ranges::count(text, '\n'), 12);
  for (const char* array : {"t.npy", "q.npy", "v.npy", "a.npy", "tau.npy", "energy.npy"})
    EXPECT_THAT(contents(npz), testing::HasSubstr(array));
  EXPECT_THAT(contents(npz), testing::HasSubstr("'shape': (11, 2)"));
  EXPECT_THAT(contents(npz), testing::HasSubstr("'shape': (11,)"));
  const Motion found = Motion::parse(contents(json));
  EXPECT_EQ(found.at("t").back(), 1.0);
  EXPECT_EQ(found.at("velocities"), Motion({"pin", "elbow"}));
}

TEST(SimulateCommand, ClosesTheLoopsOfItsStartWhereAsked) {
  const std::string spun = R"({"v": {"crank_joint": 1}})";
  std::vector<std::string> words{"simulate", robot("four_bar.toml"), "--state", "-", "--format", "json"};
  words.emplace_back("--assemble");
  const Outcome outcome = axode(words, spun);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Motion found = Motion::parse(outcome.out);
  for (const double energy : found.at("energy"))
    EXPECT_NEAR(energy, found.at("energy")[0].get<double>(), 1e-6);
}

TEST(SimulateCommand, HoldsJointsAsItClosesLoops) {
  const std::string turned = R"({"q": {"crank_joint": 0.3, "coupler_joint": 0.1}})";
  std::vector<std::string> words{
      "simulate", robot("four_bar.toml"), "--state", "-", "--format", "json", "--until", "0.01"};
  const Outcome open = axode(words, turned);
  EXPECT_THAT(open.err, StartsWith("axode simulate: q leaves loop \"pin\" open by"));
  EXPECT_THAT(open.err, testing::HasSubstr("--assemble"));
  words.insert(words.end(), {"--hold", "crank_joint"});
  EXPECT_THAT(axode(words, turned).err, testing::HasSubstr("give --assemble as well"));
  words.emplace_back("--assemble");
  const Outcome outcome = axode(words, turned);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Motion found = Motion::parse(outcome.out);
  EXPECT_EQ(found.at("q")[0][0], 0.3);
  EXPECT_NE(found.at("q")[0][1], 0.1);
  words.back() = "--assemble", words[words.size() - 2] = "crank";
  EXPECT_THAT(axode(words, turned).err, testing::HasSubstr("has no joint \"crank\""));

  const Outcome asked = axode({"eval", robot("four_bar.toml"), "--state", "-", "--want", "loop_residual",
                               "--format", "json", "--assemble", "--hold", "crank_joint"},
                              turned);
  ASSERT_EQ(asked.code, 0) << asked.err;
  for (const auto& r : Motion::parse(asked.out)["results"]["loop_residual"]["pin"])
    EXPECT_NEAR(r.get<double>(), 0, 1e-11);
}

TEST(SimulateCommand, GivesPassiveJointsNoForce) {
  const Outcome outcome =
      axode({"simulate", robot("four_bar.toml"), "--pd", "10,1", "--format", "json", "--until", "0.1"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Motion found = Motion::parse(outcome.out);
  for (const auto& tau : found.at("tau"))
    for (std::size_t c = 1; c < 3; ++c) EXPECT_EQ(tau[c], 0);
  EXPECT_NE(found.at("tau").back()[0], 0);
}

TEST(SimulateCommand, MovesInAbsoluteCoordinates) {
  const Motion joints = motion_of({"--rtol", "1e-10"});
  for (const std::string kind : {"absolute", "absolute_SO3xR3", "absolute_by_joint"}) {
    for (const auto& [method, tolerance] :
         {std::pair{"rk4", 1e-6}, {"rattle_suzuki4", 1e-6}, {"half_explicit", 1e-3}}) {
      const Motion bodies = motion_of({"--coordinates", kind, "--method", method, "--step", "0.002"});
      EXPECT_EQ(bodies.at("computed_in"), kind);
      for (std::size_t c = 0; c < 2; ++c)
        EXPECT_NEAR(bodies.at("q").back()[c].get<double>(), joints.at("q").back()[c].get<double>(), tolerance)
            << method;
    }
  }
  const auto end_with = [](const char* radius) {
    return motion_of({"--method", "generalized_alpha", "--step", "0.01", "--spectral-radius", radius})
        .at("q")
        .back();
  };
  EXPECT_NE(end_with("0.5"), end_with("0.9"));
}

/// A pendulum on a slider, with lines that a drawing may have besides.
std::string shaken(const std::string& more) {
  return R"(format = "axode drawing 1"
name = "shaken pendulum"
[[body]]
name = "shaker"
joint = { name = "shake", kind = "prismatic", axis = "x" }
mass = 1
com = [0, 0, 0]
inertia = [0.1, 0.1, 0.1]
[[body]]
name = "rod"
on = "shaker"
joint = { name = "pin", kind = "revolute", axis = "-y", point = [0, 0, 0] }
mass = 1.2
com = [0, 0, -0.5]
inertia = [0.1, 0.1, 0]
)" + more;
}
Outcome simulated(const TemporaryFolder& folder, const std::string& more, std::vector<std::string> options) {
  const std::string file = folder.file("drawing.toml");
  std::ofstream(file) << shaken(more);
  options.insert(options.begin(), {"simulate", file});
  return axode(options);
}

TEST(SimulateCommand, BeginsInTheInitialStateOfTheDrawing) {
  const TemporaryFolder folder;
  const Motion motion = Motion::parse(
      simulated(folder, "[state]\nq = { pin = 0.2 }\nv = { shake = 3 }\n", {"--format", "json"}).out);
  EXPECT_EQ(motion.at("q")[0], (std::vector<double>{0, 0.2}));
  EXPECT_EQ(motion.at("v")[0], (std::vector<double>{3, 0}));
}

TEST(SimulateCommand, SaysThatNothingMoves) {
  const TemporaryFolder folder;
  const char* const said = "nothing moves: the mechanism is at rest, in equilibrium";
  EXPECT_THAT(simulated(folder, "", {}).out, testing::HasSubstr(said));
  EXPECT_THAT(simulated(folder, "[state]\nq = { pin = 0.2 }\n", {}).out, Not(testing::HasSubstr(said)));
}

TEST(SimulateCommand, FollowsMotionsAndGivesTheirForces) {
  const TemporaryFolder folder;
  const std::string moved =
      "[[motion]]\nof = \"shake\"\nkind = \"harmonic\"\noffset = 0.3\namplitude = 0.1\nfrequency = 1\n";
  const Outcome outcome = simulated(folder, moved, {"--format", "json", "--samples", "4"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Motion motion = Motion::parse(outcome.out);
  for (std::size_t k = 0; k <= 4; ++k)
    EXPECT_NEAR(motion.at("q")[k][0].get<double>(), 0.3 + 0.1 * std::sin(M_PI / 2 * static_cast<double>(k)),
                1e-9);
  EXPECT_EQ(motion.at("motions"), std::vector<std::string>{"motion of shake"});
  EXPECT_EQ(motion.at("v")[0][1], 0);  // the pendulum does not feel that the motion begins
  EXPECT_THAT(
      simulated(folder, moved + "[state]\nq = { shake = 0.2 }\n", {}).err,
      testing::HasSubstr("[state]: q of joint \"shake\" is 0.2, but its [[motion]] starts with q = 0.3; "
                         "remove \"shake\" from q in [state]"));
  EXPECT_GT(std::abs(motion.at("motion_forces")[1][0].get<double>()), 0.1);
}

TEST(SimulateCommand, CountsTheForcesOfContactsInThoseOfMotions) {
  const TemporaryFolder folder;
  const std::string belt = R"([[body]]
name = "belt"
joint = { name = "run", kind = "prismatic", axis = "x" }
mass = 1
com = [0, 0, 0]
inertia = [0.1, 0.1, 0.1]
[[body.shape]]
kind = "plane"
role = "collision"
friction = 0.3
[[body]]
name = "ball"
joint = { name = "ball", kind = "free" }
mass = 2
com = [0, 0, 0]
inertia = [0.008, 0.008, 0.008]
[[body.shape]]
kind = "sphere"
radius = 0.1
role = "collision"
friction = 0.3
[[motion]]
of = "run"
kind = "polynomial"
coefficients = [0, 1]
[state]
q = { ball = [0, 0, 0, 1, 0, 0, 0.1] }
[contact]
)";
  for (const char* method : {"contact", "contact_exact"}) {
    const Outcome outcome =
        simulated(folder, belt, {"--method", method, "--until", "0.2", "--format", "json", "--samples", "4"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto force = Motion::parse(outcome.out).at("motion_forces");
    EXPECT_NEAR(force[1][0].get<double>(), 0.3 * 2 * 9.81, 1e-9);  // the ball slides
    EXPECT_NEAR(force[4][0].get<double>(), 0, 1e-9);               // it rolls
  }
}

TEST(SimulateCommand, LeavesOutTheForcesOfMotionsThatHardStopsMayResist) {
  const TemporaryFolder folder;
  const std::string driven = R"([[body]]
name = "tip"
on = "rod"
joint = { name = "wrist", kind = "revolute", axis = "y", point = [0, 0, -1], limits = [-0.1, 0.1], stop = "hard" }
mass = 0.2
com = [0, 0, -1.2]
inertia = [0.01, 0.01, 0.01]
[[motion]]
of = "shake"
kind = "harmonic"
amplitude = 0.1
frequency = 1
)";
  const auto moved = [&](const std::string& method, const std::string& format) {
    return simulated(folder, driven, {"--method", method, "--until", "0.2", "--format", format});
  };
  for (const char* method : {"contact", "contact_exact"}) {
    const Outcome outcome = moved(method, "json");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_FALSE(Motion::parse(outcome.out).contains("motion_forces"));
    EXPECT_THAT(moved(method, "table").out,
                testing::HasSubstr("the forces of prescribed motions are left out: those of the hard stops"));
  }
}

TEST(SimulateCommand, WritesTheStatesOfDrives) {
  const TemporaryFolder folder;
  const std::string driven =
      "[[drive]]\nname = \"motor\"\nkind = \"dc_motor\"\njoint = \"pin\"\nresistance = 2\n"
      "inductance = 0.1\ntorque_constant = 0.5\ninput = 3\n";
  const std::string csv = folder.file("run.csv");
  const Outcome outcome = simulated(folder, driven, {"--format", "json", "--samples", "2", "--output", csv});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Motion motion = Motion::parse(outcome.out);
  EXPECT_EQ(motion.at("drive_states"), std::vector<std::string>{"motor.current"});
  EXPECT_EQ(motion.at("x")[0][0], 0);
  EXPECT_GT(motion.at("x")[2][0].get<double>(), 0.1);
  EXPECT_NEAR(motion.at("tau")[2][1].get<double>(), 0.5 * motion.at("x")[2][0].get<double>(), 1e-12);
  EXPECT_THAT(contents(csv), testing::HasSubstr(",\"energy\",\"x motor.current\"\n"));
  for (const char* method : {"midpoint", "contact"}) {
    const Outcome other = simulated(
        folder, driven, {"--method", method, "--step", "1e-3", "--format", "json", "--samples", "2"});
    ASSERT_EQ(other.code, 0) << other.err;
    EXPECT_NEAR(Motion::parse(other.out).at("x")[2][0].get<double>(), motion.at("x")[2][0].get<double>(),
                1e-3);
  }
}

TEST(SimulateCommand, MovesWithoutDynamicsIfMotionsUseUpTheMobility) {
  const TemporaryFolder folder;
  const std::string one = "[[motion]]\nof = \"shake\"\nkind = \"polynomial\"\ncoefficients = [0, 1, 2, 3]\n",
                    both = one + "[[motion]]\nof = \"pin\"\nkind = \"ramp\"\nto = 1\nend = 2\n",
                    csv = folder.file("run.csv");
  const Outcome outcome = simulated(folder, both, {"--kinematic", "--samples", "2", "--output", csv});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, testing::HasSubstr("at t = 1 s, without dynamics"));
  const std::string text = contents(csv);
  EXPECT_THAT(text, StartsWith("\"t\",\"q shake\",\"q pin\",\"v shake\",\"v pin\",\"a shake\",\"a pin\","
                               "\"jerk shake\",\"jerk pin\"\n0,0,0,1,0,4,"));
  EXPECT_THAT(simulated(folder, one, {"--kinematic"}).err,
              testing::HasSubstr("the motions leave the mechanism 1 velocity"));
}

}  // namespace
}  // namespace axode::test
