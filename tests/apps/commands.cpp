#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "axode/batch.hpp"
#include "axode/io.hpp"
#include "axode/model/configuration.hpp"
#include "tests/apps/run_command.hpp"

namespace axode::test {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;
using testing::Not;

// ----------------------------------------------------------------------------------------------- the program

TEST(Program, HelpListsTheCommandsAndTheExitCodes) {
  const Outcome outcome = axode({"--help"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.err, "");
  for (const char* said : {"info", "check", "convert", "eval", "linearize", "mobility", "contacts", "plot",
                           "view", "map", "codegen", "fmu", "study", "demo", "Exit codes:", "0  all is well",
                           "1  a file is missing", "2  the command line is wrong"})
    EXPECT_THAT(outcome.out, HasSubstr(said));
}

TEST(Program, VersionIsALineAndHowItWasBuiltTheNextOnes) {
  const Outcome outcome = axode({"--version"});
  EXPECT_EQ(outcome.code, 0);
  const std::string n = "[0-9]+\\.[0-9]+\\.[0-9]+";
  EXPECT_THAT(outcome.out, testing::MatchesRegex(
                               "axode " + n +
                               "\nrevision +([0-9a-f]+|unknown)\ncompiler +[A-Za-z]+ [0-9.]+, [A-Za-z]*\n"
                               "instructions +[a-z0-9-]+\n"
                               "libraries +Eigen " +
                               n + ", tinyxml2 " + n + ", CLI11 " + n + ", fmt " + n +
                               ", JSON for Modern C\\+\\+ " + n + ", libzip " + n + "\n"));
  EXPECT_THAT(outcome.out, HasSubstr(instruction_set()));
}

TEST(Program, ColoursAreForTerminalsWithoutNoColor) {
  const std::vector<std::string> right{"info", robot("arm7.toml")}, wrong{"info", "no.toml"};
  EXPECT_THAT(axode(right).out, Not(HasSubstr("\033")));
  EXPECT_THAT(axode(wrong).err, Not(HasSubstr("\033")));
  for (const std::vector<std::string>& arguments : {right, wrong, {}}) {
    EXPECT_THAT(axode_on_a_terminal(arguments, ""), HasSubstr("\033["));
    EXPECT_THAT(axode_on_a_terminal(arguments, "1"), Not(HasSubstr("\033")));
    EXPECT_THAT(axode_on_a_terminal(arguments, "", "dumb"), Not(HasSubstr("\033")));
  }
  const Outcome piped = run({"sh", "-c", "\"$0\" info \"$1\" | cat", AXODE_COMMAND, robot("arm7.toml")});
  EXPECT_THAT(piped.out, Not(HasSubstr("\033")));
}

/// The largest change of a coordinate in a table of a motion, as `axode simulate` writes it.
double largest_change_of_coordinates(const std::filesystem::path& table) {
  std::ifstream stream(table);
  const auto next_row = [&stream] {
    std::string line, cell;
    std::getline(stream, line);
    std::istringstream cells(line);
    std::vector<std::string> row;
    while (std::getline(cells, cell, ',')) row.push_back(cell);
    return row;
  };
  const std::vector<std::string> names = next_row(), first = next_row();
  double largest = 0;
  for (std::vector<std::string> row = next_row(); !row.empty(); row = next_row())
    for (std::size_t k = 0; k < row.size(); ++k)
      if (names[k].starts_with("\"q "))
        largest = std::max(largest, std::abs(std::stod(row[k]) - std::stod(first[k])));
  return largest;
}

TEST(Program, AloneShowsWhatOneCanDoInExamplesThatRun) {
  const Outcome outcome = axode({});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.err, "");
  const TemporaryFolder folder;
  for (const auto& robot : std::filesystem::directory_iterator(AXODE_SOURCE_DIR "/examples/robots"))
    std::filesystem::copy(robot.path(), folder.path());
  std::filesystem::remove(folder.path() / "humanoid.toml");
  std::istringstream lines(outcome.out);
  std::set<std::string> commands;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("  axode ")) continue;
    const std::string example = line.substr(2, line.find("  ", 2) - 2),
                      command = example.substr(6, example.find(' ', 6) - 6);
    EXPECT_TRUE(commands.insert(command).second) << line;
    const bool no_page = command == "view" && std::string_view(AXODE_PAGE).empty();
    if (command == "demo" || command == "study" || command == "manual" || command == "map" || no_page)
      continue;  // these take long or need another program
    const Outcome ran =
        run({"sh", "-c", "cd \"$0\" && axode() { \"" AXODE_COMMAND "\" \"$@\"; } && " + example,
             folder.path().string()});
    EXPECT_EQ(ran.code, 0) << example << ran.err;
  }
  EXPECT_GT(largest_change_of_coordinates(folder.path() / "run.csv"), 0.05);
  EXPECT_THAT(commands,
              testing::UnorderedElementsAre("info", "check", "convert", "eval", "simulate", "linearize",
                                            "mobility", "contacts", "plot", "view", "map", "codegen", "fmu",
                                            "study", "demo", "manual", "completion"));
}

/// The lines of a help text from below `Example:` to the next empty line.
std::string example(const std::string& help) {
  std::istringstream lines(help.substr(std::min(help.find("Example:\n"), help.size())));
  std::string line, text;
  std::getline(lines, line);
  while (std::getline(lines, line) && !line.empty()) text += line + "\n";
  return text;
}

class Help : public testing::TestWithParam<const char*> {};

TEST_P(Help, ShowsAnExampleThatRuns) {
  if (GetParam() == std::string("view") && std::string_view(AXODE_PAGE).empty())
    GTEST_SKIP() << "this build has no viewer (AXODE_VIEWER is OFF)";
  const Outcome help = axode({GetParam(), "--help"});
  EXPECT_EQ(help.code, 0);
  const std::string shown = example(help.out);
  ASSERT_THAT(shown, HasSubstr("axode " + std::string(GetParam()))) << help.out;
  const TemporaryFolder folder;
  for (const auto& robot : std::filesystem::directory_iterator(AXODE_SOURCE_DIR "/examples/robots"))
    std::filesystem::copy(robot.path(), folder.path());
  const Outcome outcome =
      run({"sh", "-c", "cd \"$0\" && axode() { \"" AXODE_COMMAND "\" \"$@\"; } && " + shown,
           folder.path().string()});
  EXPECT_EQ(outcome.code, 0) << shown << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_NE(outcome.out, "");
  if (shown.find("run.csv") != std::string::npos) {
    EXPECT_GT(largest_change_of_coordinates(folder.path() / "run.csv"), 0.05)
        << "the motion stands still: " << shown;
  }
}
INSTANTIATE_TEST_SUITE_P(Commands, Help,
                         testing::Values("info", "check", "convert", "eval", "linearize", "simulate",
                                         "contacts", "plot", "view", "codegen", "fmu", "demo", "completion",
                                         "manual"),
                         [](const auto& p) { return std::string(p.param); });

TEST(Study, IsAProgramBesideTheCommand) {
  const TemporaryFolder folder;
  const std::string command = folder.file("axode"), study = folder.file("axode_study");
  std::filesystem::copy(AXODE_COMMAND, command);
  const Outcome without = run({command, "study", robot("arm7.toml")});
  EXPECT_EQ(without.code, 1);
  EXPECT_EQ(without.err, "axode study: " + study +
                             " cannot be run: No such file or directory; `make build` in the source tree of "
                             "axode builds it beside the command\n");
  folder.write("axode_study", "#!/bin/sh\nprintf '%s\\n' \"$@\"\n");
  std::filesystem::permissions(study, std::filesystem::perms::owner_all);
  EXPECT_EQ(run({command, "study", robot("arm7.toml"), "--counts"}).out,
            "study\n" + robot("arm7.toml") + "\n--counts\n");
}

// ----------------------------------------------------------------------------------------------------- map

/// `axode map` is run with a program in place of Python that prints its arguments. The part that Python runs
/// is tested in tests/python.
TEST(Map, HandsItsWordsToPython) {
  const TemporaryFolder folder;
  const std::string python = folder.write("python", "#!/bin/sh\nshift 2\nprintf '<%s>' \"$@\"\nexit 130\n");
  std::filesystem::permissions(python, std::filesystem::perms::owner_all);
  const Outcome outcome = run({"env", "AXODE_PYTHON=" + python, AXODE_COMMAND, "map", "jacobian",
                               "arm 7.toml", "--set", "frame=a b", "in", "--float", "out.parquet",
                               "--set=offset=[0, 0, -1]", "--keep", "t,id", "--threads=2"});
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(outcome.code, 130);
  EXPECT_EQ(outcome.out,
            "<map><--set=frame=a b><--set=offset=[0, 0, -1]><--keep=t,id><--float><--threads=2><--><jacobian>"
            "<arm 7.toml><in><out.parquet>");
}

TEST(Map, SaysWhatItNeedsWhereThatIsMissing) {
  const std::vector<std::string> words{AXODE_COMMAND, "map",        "poses",
                                       "arm7.toml",   "in.parquet", "out.parquet"};
  const auto with = [&](const std::string& python) {
    std::vector<std::string> all{"env", "AXODE_PYTHON=" + python};
    all.insert(all.end(), words.begin(), words.end());
    return run(all);
  };
  const Outcome none = with("no-such-python");
  EXPECT_EQ(none.code, 1);
  EXPECT_EQ(none.err,
            "axode map: no-such-python cannot be run: No such file or directory; `axode map` needs Python; "
            "set AXODE_PYTHON to its program\n");
  const TemporaryFolder folder;
  const std::string bare = folder.write("python", "#!/bin/sh\nexec python3 -I -S \"$@\"\n");
  std::filesystem::permissions(bare, std::filesystem::perms::owner_all);
  const Outcome without = with(bare);
  EXPECT_EQ(without.code, 1);
  EXPECT_THAT(without.err, HasSubstr("has no package axode; install the Python package of axode there"));
}

// ---------------------------------------------------------------------------------------------------- info

TEST(Info, ListsSpringsAndStops) {
  const std::string file = AXODE_SOURCE_DIR "/tests/data/good/springs.toml";
  const Outcome shown = axode({"info", file});
  EXPECT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out,
              testing::ContainsRegex("springs and stops .*\n.*stiffness +rest +stop +its damping"));
  EXPECT_THAT(shown.out, testing::ContainsRegex("flap_joint +v\\[0\\] +40 +0.3 +10000 +0.5"));
  EXPECT_THAT(shown.out, testing::ContainsRegex("eye +drone +20 +0.70* +0.5"));
  const Json told = Json::parse(axode({"info", file, "--format", "json"}).out);
  EXPECT_EQ(told["joints"][0]["stiffness"], Json({40}));
  EXPECT_EQ(told["joints"][0]["stop_damping"], Json({0.5}));
  EXPECT_EQ(told["springs"][0]["between"], Json({"eye", "drone"}));
  EXPECT_EQ(told["springs"][0]["damping"], 0.5);
  EXPECT_THAT(axode({"info", robot("arm7.toml")}).out, Not(HasSubstr("spring")));
}

TEST(Info, ListsLoopsCouplingsAndPassiveJoints) {
  const std::string file = AXODE_SOURCE_DIR "/tests/data/good/loops.toml";
  const Outcome shown = axode({"info", file});
  EXPECT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, testing::ContainsRegex("coupler_joint +revolute, passive"));
  EXPECT_THAT(shown.out, testing::ContainsRegex("loops\n.*rows"));
  EXPECT_THAT(shown.out, testing::ContainsRegex("pin +revolute +coupler +rocker +5"));
  EXPECT_THAT(shown.out,
              testing::ContainsRegex("coupling 1 +1 q\\(crank_joint\\) - 1.5 q\\(rocker_joint\\) +0.5"));
  const Json told = Json::parse(axode({"info", file, "--format", "json"}).out);
  EXPECT_EQ(told["joints"][1]["passive"], true);
  EXPECT_FALSE(told["joints"][0].contains("passive"));
  EXPECT_EQ(told["loops"][0],
            Json({{"name", "pin"}, {"kind", "revolute"}, {"rows", 5}, {"between", {"coupler", "rocker"}}}));
  EXPECT_EQ(told["loops"][4]["terms"][1]["factor"], -1.5);
  EXPECT_THAT(axode({"info", robot("arm7.toml")}).out, Not(HasSubstr("loops")));
}

TEST(Info, CountsFreedomsAndDrives) {
  const auto says = [](const char* file, const char* said, int freedoms, int drives) {
    EXPECT_THAT(axode({"info", robot(file)}).out, HasSubstr(said)) << file;
    const Json told = Json::parse(axode({"info", robot(file), "--format", "json"}).out);
    EXPECT_EQ(told["degrees_of_freedom"], freedoms) << file;
    EXPECT_EQ(told["drives"], drives) << file;
  };
  says("four_bar.toml", "\n1 degree of freedom, 1 drive\n", 1, 1);
  says("gough.toml", "\n6 degrees of freedom, 6 drives\n", 6, 6);
  EXPECT_THAT(axode({"info", robot("arm7.toml")}).out, Not(HasSubstr("degrees of freedom")));
  EXPECT_FALSE(Json::parse(axode({"info", robot("arm7.toml"), "--format", "json"}).out).contains("drives"));
}

TEST(Info, ShowsEveryBodyJointAndFrame) {
  const Outcome outcome = axode({"info", robot("machine.toml")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Model model = load(robot("machine.toml"));
  for (int i = 1; i <= model.n_bodies(); ++i) {
    EXPECT_THAT(outcome.out, HasSubstr("─ " + model.body(i).name + " "));
    EXPECT_THAT(outcome.out, HasSubstr("<- " + model.joint(i).name + " "));
  }
  for (const Frame& frame : model.frames()) EXPECT_THAT(outcome.out, HasSubstr(frame.name));
  for (const char* said :
       {"nq = 20, nv = 18", "q[7:11] v[7:10]", "= 0.000795775 q(feed)", "45.702", "massless"})
    EXPECT_THAT(outcome.out, HasSubstr(said));
}

TEST(Info, InJsonHoldsTheModelsOwnNumbers) {
  const Outcome outcome = axode({"info", robot("machine.toml"), "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json out = Json::parse(outcome.out);
  const Model model = load(robot("machine.toml"));
  EXPECT_EQ(out["total_mass"], model.total_mass());
  ASSERT_EQ(out["joints"].size(), model.n_bodies());
  ASSERT_EQ(out["frames"].size(), model.n_frames());
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Json &joint = out["joints"][i - 1], &body = out["bodies"][i - 1];
    EXPECT_EQ(joint["name"], model.joint(i).name);
    EXPECT_EQ(joint["iq"], model.joint(i).iq);
    EXPECT_EQ(joint["nv"], model.joint(i).nv);
    EXPECT_EQ(joint.contains("follows"), model.joint(i).leader.has_value());
    EXPECT_EQ(body["mass"], model.body(i).M.m);
    for (std::size_t d = 0; d < model.joint(i).dof.size(); ++d) {
      const double upper = model.joint(i).dof[d].upper;
      EXPECT_EQ(joint["upper"][d], std::isfinite(upper) ? Json(upper) : Json(nullptr));
    }
  }
}

TEST(Info, SetsTheBaseFree) {
  EXPECT_THAT(axode({"info", robot("humanoid.urdf"), "--base", "free"}).out, HasSubstr("<- free_base "));
  EXPECT_THAT(axode({"info", robot("humanoid.urdf")}).out, Not(HasSubstr("free_base")));
}

// --------------------------------------------------------------------------------------------------- check

constexpr const char* link = R"(<link name="%"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
)";
constexpr const char* hinge =
    R"(<joint name="hinge" type="continuous"><parent link="a"/><child link="b"/></joint>
)";

std::string named(std::string text, const std::string& name) { return text.replace(text.find('%'), 1, name); }

std::string replaced(std::string text, const std::string& old, const std::string& now) {
  return text.replace(text.find(old), old.size(), now);
}

std::string two_links(const std::string& more = "") {
  return "<robot name=\"two\">\n" + named(link, "a") + named(link, "b") + hinge + more + "</robot>\n";
}

TEST(Check, EveryRobotThatTheProjectShipsIsClean) {
  for (const auto& file : std::filesystem::directory_iterator(AXODE_SOURCE_DIR "/examples/robots")) {
    const Outcome outcome = axode({"check", file.path().string()});
    EXPECT_EQ(outcome.code, 0) << outcome.out;
    EXPECT_EQ(outcome.out, file.path().string() + ": no errors, no warnings\n");
  }
}

TEST(Check, HarmlessWarningsAreToldAndPass) {
  const TemporaryFolder folder;
  const std::string file = folder.write("two.urdf", two_links("<gazebo/>\n"));
  const Outcome outcome = axode({"check", file});
  EXPECT_EQ(outcome.code, 0) << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr(file + ":7: warning: <gazebo>"));
  EXPECT_THAT(outcome.out, HasSubstr(file + ": no errors, 1 warning\n"));
}

TEST(Check, AJointThatMovesNoMassIsToldAndPasses) {
  const TemporaryFolder folder;
  const std::string file = folder.write("two.urdf", "<robot name=\"two\">\n" + named(link, "a") +
                                                        "<link name=\"b\"/>\n" + hinge + "</robot>\n");
  const Outcome outcome = axode({"check", file});
  EXPECT_EQ(outcome.code, 0) << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr("warning: joint \"hinge\": moves no mass"));
}

TEST(Check, TheBaseIsHeldAsForEveryOtherCommand) {
  const Outcome outcome = axode({"check", robot("double_pendulum.toml"), "--base", "free"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.out, HasSubstr("0 bodies are fixed to the ground"));
  EXPECT_EQ(axode({"check", robot("arm7.toml"), "--base", "free"}).code, 0);
}

TEST(Doubts, AreWarningsForEveryCommandAndErrorsWithStrict) {
  const TemporaryFolder folder;
  const std::string urdf = folder.write("two.urdf", replaced(two_links(), "ixx=\"1\"", "ixx=\"3\""));
  const std::string drawing = folder.file("two.toml"), out = folder.file("out.urdf");
  const char* doubt = "body \"a\": no density can produce its inertia";
  ASSERT_EQ(axode({"convert", urdf, drawing}).code, 0);
  for (const std::string& file : {urdf, drawing}) {
    const std::vector<std::vector<std::string>> commands{{"info", file},
                                                         {"check", file},
                                                         {"convert", file, out, "--force"},
                                                         {"eval", file},
                                                         {"codegen", file}};
    for (std::vector<std::string> words : commands) {
      const Outcome lenient = axode(words);
      EXPECT_EQ(lenient.code, 0) << words[0] << lenient.err;
      words.emplace_back("--strict");
      const Outcome strict = axode(words);
      EXPECT_EQ(strict.code, 1) << words[0];
      EXPECT_THAT(strict.out + strict.err, HasSubstr(std::string("error: ") + doubt)) << words[0];
    }
    EXPECT_THAT(axode({"check", file}).out, HasSubstr(std::string("warning: ") + doubt));
  }
}

TEST(Check, EveryFileIsJudgedAndOneErrorFailsAll) {
  const TemporaryFolder folder;
  const std::string good = folder.write("good.urdf", two_links());
  const std::string bad =
      folder.write("bad.urdf", replaced(two_links(), "child link=\"b\"", "child link=\"c\""));
  const std::string missing = folder.file("missing.urdf");
  const Outcome outcome = axode({"check", good, bad, missing});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(outcome.out, HasSubstr(good + ": no errors, no warnings\n"));
  EXPECT_THAT(outcome.out, HasSubstr(bad + ":6: error: "));
  EXPECT_THAT(outcome.out, HasSubstr(missing + ": error: the file cannot be read"));

  const Json json = Json::parse(axode({"check", good, bad, missing, "--format", "json"}).out)["files"];
  ASSERT_EQ(json.size(), 3);
  EXPECT_EQ(json[0]["errors"], 0);
  EXPECT_TRUE(std::ranges::any_of(json[1]["faults"], [](const Json& fault) {
    return fault["line"] == 6 && fault["severity"] == "error" && fault["rule"] == "unknown_predecessor";
  })) << json[1];
  EXPECT_EQ(json[2]["faults"][0]["rule"], "unreadable_file");
}

TEST(Check, EveryMalformedFileFails) {
  const std::filesystem::path folder = AXODE_SOURCE_DIR "/tests/data/bad";
  std::vector<std::string> arguments{"check", "--format", "json", "--strict"};
  for (const auto& file : std::filesystem::directory_iterator(folder))
    if (file.path().extension() == ".toml" || file.path().extension() == ".urdf")
      arguments.push_back(file.path().string());
  ASSERT_GE(arguments.size(), 60U);
  const Outcome outcome = axode(arguments);
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.err, "");
  arguments.erase(arguments.begin() + 1, arguments.begin() + 4);
  const Json files = Json::parse(outcome.out)["files"];
  EXPECT_EQ(files.size(), arguments.size() - 1);
  for (const Json& file : files) EXPECT_GE(file["errors"], 1) << file["file"];
}

// -------------------------------------------------------------------------------------------------- convert

/// Every frame's pose and all drive forces at a moving state, as JSON.
Json answers(const std::string& file, const std::string& base) {
  const Model model = load(file, base == "free" ? Base::free : Base::fixed);
  std::vector<double> v(model.nv()), a(model.nv());
  for (std::size_t k = 0; k < v.size(); ++k)
    v[k] = std::sin(static_cast<double>(k)), a[k] = std::cos(3.0 * static_cast<double>(k));
  const Json state{{"q", random_configuration(model, 3)}, {"v", v}, {"a", a}};
  const Outcome outcome = axode({"eval", file, "--base", base, "--state", "-", "--format", "json", "--want",
                                 "inverse_dynamics,poses,twists,accelerations"},
                                state.dump());
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return Json::parse(outcome.out);
}

/// Expects that two JSON values have the same shape, the same words, and numbers that differ by rounding
/// only.
void expect_equal(const Json& x, const Json& y, const std::string& where) {
  ASSERT_EQ(x.type(), y.type()) << where;
  if (x.is_structured()) {
    ASSERT_EQ(x.size(), y.size()) << where;
    for (const auto& [key, entry] : x.items())
      expect_equal(entry, x.is_object() ? y[key] : y[std::stoul(key)], where + "/" + key);
  } else if (x.is_number_float()) {
    EXPECT_NEAR(x.get<double>(), y.get<double>(), 1e-10 * std::max(1.0, std::abs(x.get<double>()))) << where;
  } else {
    EXPECT_EQ(x, y) << where;
  }
}

TEST(Convert, ThereAndBackMovesAlike) {
  const TemporaryFolder folder;
  const std::string urdf = robot("humanoid.urdf"), drawing = folder.file("h.toml"),
                    again = folder.file("h.urdf");
  ASSERT_EQ(axode({"convert", urdf, drawing}).code, 0);
  ASSERT_EQ(axode({"convert", drawing, again}).code, 0);
  for (const char* base : {"fixed", "free"}) {
    const Json original = answers(urdf, base);
    expect_equal(original, answers(drawing, base), "");
    expect_equal(original, answers(again, base), "");
  }
}

TEST(Convert, DoesNotOverwriteUnlessForced) {
  const TemporaryFolder folder;
  const std::string out = folder.write("arm.toml", "precious");
  const Outcome refused = axode({"convert", robot("arm7.toml"), out});
  EXPECT_EQ(refused.code, 1);
  EXPECT_EQ(refused.err, "axode convert: " + out + ": the file exists; --force replaces it\n");
  EXPECT_EQ(contents(out), "precious");
  EXPECT_EQ(axode({"convert", robot("arm7.toml"), out, "--force"}).code, 0);
  EXPECT_EQ(axode({"info", out}).code, 0);
}

TEST(Convert, WhatUrdfHasNoWordsForIsAnErrorAndNothingIsWritten) {
  const TemporaryFolder folder;
  const std::string out = folder.file("machine.urdf");
  const Outcome outcome = axode({"convert", robot("machine.toml"), out});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("joint \"jack\": is helical"));
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(Convert, WhatTheFormatHasNoWordsForIsLeftOutUnlessItIsStrict) {
  const TemporaryFolder folder;
  const std::string in = robot("four_bar.toml"), out = folder.file("four_bar.urdf");
  const Outcome strict = axode({"convert", in, out, "--strict"});
  EXPECT_EQ(strict.code, 1);
  EXPECT_THAT(strict.err, HasSubstr("error: joint \"rocker_joint\": is passive; URDF has no word for it\n"));
  EXPECT_FALSE(std::filesystem::exists(out));
  const Outcome lenient = axode({"convert", in, out});
  EXPECT_EQ(lenient.code, 0);
  EXPECT_THAT(lenient.err,
              HasSubstr("warning: joint \"rocker_joint\": is passive; URDF has no word for it, and "
                        "it is left out\n"));
  EXPECT_EQ(axode({"info", out}).code, 0);
}

TEST(Convert, WritesMjcfAndDoesNotReadIt) {
  const TemporaryFolder folder;
  const std::string out = folder.file("arm.xml");
  ASSERT_EQ(axode({"convert", robot("arm7.toml"), out}).code, 0);
  EXPECT_THAT(contents(out), testing::StartsWith("<mujoco model=\"arm7\">"));
  const Outcome back = axode({"convert", out, folder.file("arm.urdf")});
  EXPECT_EQ(back.code, 1);
  EXPECT_THAT(back.err, HasSubstr("the file is MJCF, which is read by MuJoCo itself: load it in Python"));
}

TEST(Convert, WarningsGoToStandardError) {
  const TemporaryFolder folder;
  const std::string in = folder.write("two.urdf", two_links("<gazebo/>\n")), out = folder.file("two.toml");
  const Outcome outcome = axode({"convert", in, out});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr(in + ":7: warning: <gazebo>"));
  EXPECT_EQ(outcome.out, out + ": 1 moving bodies, nq = 1, nv = 1\n");
}

// -------------------------------------------------------------------------------------------------- codegen

TEST(Codegen, WritesToStandardOutputOrToAFileAndThenSaysWhatItCosts) {
  const TemporaryFolder folder;
  const std::string out = folder.file("arm.c");
  const std::vector<std::string> arguments{"codegen",     robot("arm7.toml"),
                                           "--functions", "forward_dynamics,jacobian:flange:hybrid",
                                           "--name",      "arm"};
  const Outcome shown = axode(arguments);
  EXPECT_EQ(shown.code, 0);
  EXPECT_EQ(shown.err, "");
  EXPECT_THAT(shown.out, HasSubstr("int arm_forward_dynamics(\n    const double *"));
  EXPECT_THAT(shown.out, HasSubstr("void arm_jacobian_flange_hybrid("));
  EXPECT_THAT(shown.out, HasSubstr("A7     revolute   6         6"));
  std::vector<std::string> with_output = arguments;
  with_output.insert(with_output.end(), {"--output", out});
  const Outcome written = axode(with_output);
  EXPECT_EQ(written.code, 0);
  EXPECT_EQ(written.out, "");
  EXPECT_THAT(written.err,
              testing::MatchesRegex("arm_forward_dynamics: [0-9]+ products, [0-9]+ sums, [0-9]+ divisions, "
                                    "[0-9]+ sines and cosines\narm_jacobian_flange_hybrid: .*\n"));
  EXPECT_EQ(contents(out), shown.out);
}

TEST(Codegen, WritesFloatsAndTheBaseThatIsAskedFor) {
  const Outcome outcome =
      axode({"codegen", robot("humanoid.urdf"), "--base", "free", "--float", "--functions", "mass_matrix"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("q has 38 entries; v, a and tau have 37"));
  EXPECT_THAT(outcome.out, HasSubstr("void humanoid_mass_matrix(\n    const float *"));
}

TEST(Codegen, WritesKernelsForAGpu) {
  const Outcome outcome = axode({"codegen", robot("arm7.toml"), "--abi", "cuda", "--float"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.out,
              HasSubstr("__global__ __launch_bounds__(128) void arm7_inverse_dynamics_states(\n    "
                        "const float *"));
}

// ----------------------------------------------------------------------------------------------------- demo

/// The demo, run once as a command and once as the program that `make demo` builds.
class Demo : public testing::TestWithParam<std::vector<std::string>> {};
INSTANTIATE_TEST_SUITE_P(, Demo,
                         testing::Values(std::vector<std::string>{AXODE_COMMAND, "demo"},
                                         std::vector<std::string>{AXODE_DEMO}),
                         [](const auto& info) { return info.index == 0 ? "command" : "program"; });

TEST_P(Demo, RunsBothRobotsEveryWay) {
  const Outcome outcome = run(GetParam());
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  for (const char* said :
       {"arm7: 7 moving bodies", "humanoid: 32 moving bodies", "body-fixed", "spatial", "hybrid", "mixed",
        "fast", "microseconds", "The four representations agree to rounding."})
    EXPECT_THAT(outcome.out, HasSubstr(said));
}

}  // namespace
}  // namespace axode::test
