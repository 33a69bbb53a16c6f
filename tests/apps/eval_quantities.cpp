#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "axode/catalog.hpp"
#include "axode/drives/elastic_feed_forward.hpp"
#include "axode/dynamics.hpp"
#include "axode/io.hpp"
#include "tests/apps/run_command.hpp"
#include "tests/support/comparison.hpp"

/// Every quantity that `axode eval --help` lists, computed for a mechanism with all kinds of joints and for
/// an arm. The numbers are compared with those of the Python package in tests/python/test_table.py.
namespace axode::test {
namespace {

using Json = nlohmann::ordered_json;

/// The names of the quantities that the help lists.
std::vector<std::string> quantities() {
  std::istringstream help(axode({"eval", "--help"}).out);
  std::vector<std::string> names;
  bool listing = false;
  for (std::string line; std::getline(help, line);) {
    if (line.starts_with("Quantities for --want")) {
      listing = true;
    } else if (listing && line.empty()) {
      break;
    } else if (listing) {
      std::istringstream words(line);
      std::string name;
      words >> name;
      names.push_back(name);
    }
  }
  return names;
}

/// A state in which no quantity is zero.
Json moving(const Model& model) {
  std::vector<double> v, a;
  for (int c = 0; c < model.nv(); ++c) v.push_back(std::sin(1.0 + c)), a.push_back(std::cos(2.0 + c));
  const std::string tool = model.frame(model.n_frames() - 1).name;
  Json pose = Json::array({{1, 0, 0, 0.3}, {0, 1, 0, 0.1}, {0, 0, 1, 0.5}, {0, 0, 0, 1}});
  return {{"q", random_configuration(model, 4)},
          {"v", v},
          {"a", a},
          {"jerk", v},
          {"snap", a},
          {"tau", v},
          {"loads", Json::array({{{"frame", tool}, {"wrench", {1, 2, 3, 4, 5, 6}}}})},
          {"targets", Json::array({{{"frame", tool}, {"pose", pose}}})}};
}

bool finite(const Json& value) {
  if (value.is_structured()) return std::all_of(value.begin(), value.end(), finite);
  return value.is_string() || (value.is_number() && std::isfinite(value.get<double>()));
}

std::vector<double> flat(const Json& value) {
  if (!value.is_structured()) return {value.get<double>()};
  std::vector<double> out;
  for (const Json& entry : value)
    for (const double x : flat(entry)) out.push_back(x);
  return out;
}

Json answer(const std::string& file, const Json& state, const std::string& want,
            std::vector<std::string> options = {}) {
  options.insert(options.begin(), {"eval", file, "--state", "-", "--format", "json", "--want", want});
  const Outcome outcome = axode(options, state.dump());
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return outcome.code == 0 ? Json::parse(outcome.out).at("results") : Json();
}

TEST(EvalQuantities, AllAnswerInJsonAndAsATable) {
  ASSERT_GE(quantities().size(), 40u);
  const std::string arm = robot("arm7.toml"), machine = robot("machine.toml");
  for (const std::string& file : {arm, machine}) {
    const Json state = moving(load(file));
    for (const std::string& name : quantities()) {
      SCOPED_TRACE(file + ", " + name);
      std::vector<std::string> options;
      if (name == "operational_space_inertia") {
        if (file == machine) continue;  // no frame of this mechanism can move in every direction
        options = {"--frame", "flange"};
      }
      const Json results = answer(file, state, name, options);
      ASSERT_TRUE(results.contains(name));
      EXPECT_TRUE(finite(results.at(name))) << results.at(name).dump();
      options.insert(options.begin(), {"eval", file, "--state", "-", "--want", name});
      const Outcome table = axode(options, state.dump());
      EXPECT_EQ(table.code, 0) << table.err;
      EXPECT_THAT(table.out, testing::HasSubstr("\n" + name + ": "));
      if (const auto* row = catalog::find<BodyFixed>(name); row && row->symbols.size() > 1)
        for (const std::string_view symbol : row->symbols) {
          EXPECT_THAT(results.dump(), testing::HasSubstr("\"" + std::string(symbol) + "\":"));
          EXPECT_THAT(table.out, testing::HasSubstr(" " + std::string(symbol)));
        }
    }
  }
}

TEST(EvalQuantities, JointWrenchesCountLoops) {
  const Model model = load(robot("four_bar.toml"));
  LoopWorkspace<> loops(model);
  const std::vector<double> q = neutral(model), rest(q.size());
  for (const auto& [point, at] : {std::pair{"body", WrenchPoint::body}, {"joint", WrenchPoint::joint}}) {
    std::vector<Wrench<Hybrid>> W(3);
    EXPECT_LT(joint_wrenches<Hybrid>(model, loops, q, rest, rest, W, {}, {}, at), 1e-9);
    const Outcome outcome = axode({"eval", robot("four_bar.toml"), "--want", "joint_wrenches",
                                   "--representation", "hybrid", "--at", point, "--format", "json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const Json told = Json::parse(outcome.out);
    EXPECT_THAT(told["labels"]["joint_wrenches"].get<std::string>(),
                testing::HasSubstr(std::string("about the ") +
                                   (at == WrenchPoint::body ? "body's origin" : "joint's point")));
    for (int i = 1; i <= 3; ++i) {
      const auto& [m, f] = W[static_cast<std::size_t>(i - 1)];
      const Json& found = told["results"]["joint_wrenches"][model.joint(i).name];
      EXPECT_EQ(found, Json({m.x, m.y, m.z, f.x, f.y, f.z}));
      if (at == WrenchPoint::joint && model.joint(i).passive) {
        EXPECT_NEAR(found[2].get<double>(), 0, 1e-9);
      }
    }
  }
}

TEST(EvalQuantities, FormsOfCDifferAndMakeTheSameForces) {
  const std::string arm = robot("arm7.toml");
  const Json state = moving(load(arm));
  std::vector<std::vector<double>> C;
  for (const char* form : {"paper", "skew", "spatial", "christoffel"})
    C.push_back(flat(answer(arm, state, "coriolis_matrix", {"--coriolis", form}).at("coriolis_matrix")));
  const auto distance = [](const std::vector<double>& a, const std::vector<double>& b) {
    double largest = 0;
    for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, std::abs(a[k] - b[k]));
    return largest;
  };
  EXPECT_GT(distance(C[0], C[1]), 1e-3);
  EXPECT_LT(distance(C[1], C[2]), 1e-12);
  EXPECT_GT(distance(C[2], C[3]), 1e-3);
}

TEST(EvalQuantities, MomentaOfTheStateComeBeforeItsVelocities) {
  const std::string arm = robot("arm7.toml");
  Json state = moving(load(arm));
  state["p"] = std::vector<double>{1, 0, 0, 0, 0, 0, 0};
  const Json form = answer(arm, state, "momentum_form").at("momentum_form");
  EXPECT_EQ(flat(form.at("p")), flat(state.at("p")));
  const Json again = answer(arm, {{"q", state.at("q")}, {"v", form.at("v")}}, "momenta");
  EXPECT_NEAR(flat(again.at("momenta"))[0], 1, 1e-12);
}

void expect_motors(const Json& found, const MotorMotion& expected) {
  Comparison same("motors", 1e-12);
  for (const auto& [key, numbers] : {std::pair("position", &expected.position),
                                     {"velocity", &expected.velocity},
                                     {"force", &expected.force}})
    same.expect_equal(flat(found.at(key)), *numbers);
}

TEST(EvalQuantities, MotorsOfAnArmFollowFromItsMotionAndTheOptions) {
  const Model model = load(robot("arm7.toml"));
  const Json state = moving(model);
  std::vector<ElasticDrive> drives(7, {2000, 0.3});
  drives[3].stiffness = 500;
  std::vector<double> rates;
  for (const char* row : {"v", "a", "jerk", "snap"})
    for (const double x : flat(state.at(row))) rates.push_back(x);
  const Json loaded = answer(robot("arm7.toml"), state, "elastic_feed_forward",
                             {"--stiffness", "2000,A4=500", "--inertia", "0.3"});
  Json free = state;
  free.erase("loads");
  const Json found = answer(robot("arm7.toml"), free, "elastic_feed_forward",
                            {"--stiffness", "2000,A4=500", "--inertia", "0.3"})
                         .at("elastic_feed_forward");
  MotorMotion motors;
  ElasticFeedForward(model, drives).evaluate(flat(state.at("q")), rates, motors);
  expect_motors(found, motors);
  EXPECT_NE(loaded.at("elastic_feed_forward"), found);

  // A sweep over one state gives the same numbers, and writes them to a file.
  const TemporaryFolder folder;
  std::string names = "t", numbers = "0";
  for (const char* key : {"q", "v", "a", "jerk", "snap"})
    for (int k = 0; k < 7; ++k) {
      names += "," + std::string(key) + " A" + std::to_string(k + 1);
      numbers += "," + state.at(key)[static_cast<std::size_t>(k)].dump();
    }
  const std::string motion = folder.write("motion.csv", names + "\n" + numbers + "\n"),
                    file = folder.file("motors.csv");
  const Outcome sweep =
      axode({"eval", robot("arm7.toml"), "--state", motion, "--want", "elastic_feed_forward", "--stiffness",
             "2000,A4=500", "--inertia", "0.3", "--output", file});
  EXPECT_EQ(sweep.code, 0) << sweep.err;
  std::istringstream lines(contents(file));
  std::string head, cell;
  std::getline(lines, head);
  EXPECT_THAT(head,
              testing::StartsWith("\"t\",\"A1 position\",\"A1 velocity\",\"A1 force\",\"A2 position\""));
  std::vector<double> written;
  while (std::getline(lines, cell, ',')) written.push_back(std::stod(cell));
  ASSERT_EQ(written.size(), 22U);
  for (std::size_t k = 0; k < 7; ++k) EXPECT_NEAR(written[3 + 3 * k], motors.force[k], 1e-9);
}

/// The motors of a parallel manipulator follow from the motion of its platform alone.
TEST(EvalQuantities, MotorsOfAParallelManipulatorFollowFromItsPlatform) {
  const Model model = load(robot("gough.toml"));
  const std::vector<double> q = neutral(model), rates = {0.1, 0, 0.2, 0.3, 0, -0.4, 1, 2,  3, 0, 1, 2,
                                                         5,   6, 7,   8,   9, 1,    2, -3, 4, 5, 6, 7};
  Json state;
  for (const auto& [row, key] : {std::pair(0, "v"), {1, "a"}, {2, "jerk"}, {3, "snap"}})
    state[key]["platform_joint"] = std::vector(rates.begin() + 6 * row, rates.begin() + 6 * row + 6);
  TaskSpace space(model, q);
  ASSERT_EQ(space.freedom(), 6);
  MotorMotion motors;
  ElasticFeedForward drives(model,
                            std::vector<ElasticDrive>(static_cast<std::size_t>(model.nv()), {5e5, 20}));
  ASSERT_TRUE(drives.evaluate(space, q, rates, motors).ok());
  expect_motors(
      answer(robot("gough.toml"), state, "elastic_feed_forward", {"--stiffness", "5e5", "--inertia", "20"})
          .at("elastic_feed_forward"),
      motors);
}

/// A series-elastic drive of a drawing has a stiffness and, behind its gear, an inertia.
TEST(EvalQuantities, MotorsOfADrawingAreThoseOfItsDrives) {
  const TemporaryFolder folder;
  const auto drawing = [&](const std::string& more) {
    return folder.write("servo.toml",
                        "format = \"axode drawing 1\"\nname = \"servo\"\n[[body]]\nname = \"rod\"\n"
                        "joint = { name = \"hinge\", kind = \"revolute\", axis = \"y\", point = [0, 0, 0] }\n"
                        "mass = 1\ncom = [0.3, 0, 0]\ninertia = [0.01, 0.02, 0.02]\n"
                        "[[drive]]\nname = \"motor\"\nkind = \"series_elastic\"\njoint = \"hinge\"\n"
                        "resistance = 1\ninductance = 0.01\ntorque_constant = 0.2\nratio = 10\n"
                        "rotor_inertia = 0.001\nstiffness = 50\ninput = 0\n" +
                            more);
  };
  const Json state{{"q", {0.4}}, {"v", {1.5}}, {"a", {2}}, {"jerk", {3}}, {"snap", {4}}};
  const std::string file = drawing("");
  const Json found = answer(file, state, "elastic_feed_forward").at("elastic_feed_forward");
  MotorMotion motors;
  ElasticFeedForward(load(file), {{50, 0.1}})
      .evaluate(std::vector{0.4}, std::vector<double>{1.5, 2, 3, 4}, motors);
  expect_motors(found, motors);
  const Outcome damped = axode({"eval", drawing("damping = 1\n"), "--want", "elastic_feed_forward"});
  EXPECT_EQ(damped.code, 1);
  EXPECT_THAT(damped.err, testing::HasSubstr("the drive \"motor\" has damping or viscous friction"));
}

TEST(EvalQuantities, FramesOrdersAndObserversAreChosen) {
  const std::string arm = robot("arm7.toml");
  const Json state = moving(load(arm));
  const Json one =
      answer(arm, state, "jacobian,jerk,twist_derivative,jacobian_derivative,jacobian_rate,relative_jacobian",
             {"--frame", "flange", "--order", "2", "--relative-to", "link 2"});
  ASSERT_EQ(one.at("jacobian").size(), 1u);
  EXPECT_EQ(one.at("jerk"), one.at("twist_derivative")) << "jerk is of order 2";
  EXPECT_NE(one.at("jacobian_derivative"), one.at("jacobian_rate"));
  const Json first = answer(arm, state, "jacobian_derivative", {"--frame", "flange", "--order", "1"});
  EXPECT_THAT(flat(first.at("jacobian_derivative").at("flange")),
              testing::Pointwise(testing::DoubleNear(1e-14), flat(one.at("jacobian_rate").at("flange"))));
  EXPECT_EQ(answer(arm, state, "poses,twists,accelerations", {"--frame", "flange"}).at("twists").size(), 1u);
  const Json J = one.at("relative_jacobian").at("flange");
  for (const Json& row : J) EXPECT_EQ(row.at(0), 0) << "joint A1 moves the observer along";
  const Json two = answer(arm, state, "jacobian", {"--frame", "flange", "--frame", "link 3"});
  EXPECT_EQ(two.at("jacobian").size(), 2u);
}

}  // namespace
}  // namespace axode::test
