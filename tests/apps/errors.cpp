#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/apps/run_command.hpp"

/// Every mistake is answered by one sentence on standard error that names the thing, the value and the rule.
namespace axode::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

struct Mistake {
  const char* name;
  std::vector<std::string> arguments;
  int code;
  std::string says;  ///< the whole of standard error
};

void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.name; }

class CommandLine : public testing::TestWithParam<Mistake> {};

TEST_P(CommandLine, IsRefusedInOneSentence) {
  const Mistake& mistake = GetParam();
  const Outcome outcome = axode(mistake.arguments);
  EXPECT_EQ(outcome.code, mistake.code);
  EXPECT_EQ(outcome.err, mistake.says + "\n");
  EXPECT_EQ(outcome.out, "");
}

const std::string arm = robot("arm7.toml");

INSTANTIATE_TEST_SUITE_P(
    Mistakes, CommandLine,
    testing::ValuesIn(std::vector<Mistake>{
        {"UnknownCommand",
         {"evla", arm},
         2,
         "axode: there is no command \"evla\"; there are info, check, convert, eval, linearize, simulate, "
         "plot, view, map, "
         "codegen, "
         "study, demo, completion, manual; "
         "did you "
         "mean "
         "\"eval\"? "
         "(see axode --help)"},
        {"UnknownOptionOfTheProgram",
         {"--colour"},
         2,
         "axode: \"--colour\" was not expected (see axode --help)"},
        {"UnknownOption",
         {"eval", arm, "--wnat", "poses"},
         2,
         "axode eval: \"--wnat\" was not expected; did you mean \"--want\"? (see axode eval --help)"},
        {"OneFileTooMany",
         {"info", arm, arm},
         2,
         "axode info: \"" + arm + "\" was not expected (see axode info --help)"},
        {"NoModel", {"eval"}, 2, "axode eval: MODEL is required (see axode eval --help)"},
        {"NoOutput", {"convert", arm}, 2, "axode convert: OUT is required (see axode convert --help)"},
        {"UnknownQuantity",
         {"eval", arm, "--want", "poses,twist"},
         2,
         "axode eval: --want: there is no quantity \"twist\"; did you mean \"twists\"? (see axode eval "
         "--help)"},
        {"PartOfAQuantity",
         {"eval", arm, "--want", "impulse"},
         2,
         "axode eval: --want: there is no quantity \"impulse\"; names that contain it: \"impulse_response\" "
         "(see axode eval "
         "--help)"},
        {"UnknownBase",
         {"eval", arm, "--base", "fre"},
         2,
         "axode eval: --base: \"fre\" is none of fixed, free; did you mean \"free\"? (see axode eval "
         "--help)"},
        {"UnknownRepresentation",
         {"eval", arm, "--representation", "Body"},
         2,
         "axode eval: --representation: \"Body\" is none of body, spatial, hybrid, mixed; did you mean "
         "\"body\"? "
         "(see axode eval --help)"},
        {"UnknownFormat",
         {"info", arm, "--format", "yaml"},
         2,
         "axode info: --format: \"yaml\" is none of table, json (see axode info --help)"},
        {"GravityOfTwoNumbers",
         {"eval", arm, "--gravity", "0,-9.81"},
         2,
         "axode eval: --gravity: \"0,-9.81\" is not three finite numbers in m/s^2, such as 0,0,-9.81 "
         "(see axode eval --help)"},
        {"GravityThatIsNotFinite",
         {"eval", arm, "--gravity", "0,0,inf"},
         2,
         "axode eval: --gravity: \"0,0,inf\" is not three finite numbers in m/s^2, such as 0,0,-9.81 "
         "(see axode eval --help)"},
        {"GravityThatIsNoNumber",
         {"eval", arm, "--gravity", "0,0,down"},
         2,
         "axode eval: --gravity: \"0,0,down\" is not three finite numbers in m/s^2, such as 0,0,-9.81 "
         "(see axode eval --help)"},
        {"UnknownFrame",
         {"eval", arm, "--want", "jacobian", "--frame", "flagne"},
         1,
         "axode eval: model \"arm7\" has no frame \"flagne\"; did you mean \"flange\"?"},
        {"UnknownObserver",
         {"eval", arm, "--want", "relative_jacobian", "--relative-to", "moon"},
         1,
         "axode eval: model \"arm7\" has no frame \"moon\""},
        {"OrderBelowZero",
         {"eval", arm, "--want", "twist_derivative", "--order", "-1"},
         2,
         "axode eval: --order: Value -1 not in range 0 to 12 (see axode eval --help)"},
        {"UnknownFormOfC",
         {"eval", arm, "--want", "coriolis_matrix", "--coriolis", "skewed"},
         2,
         "axode eval: --coriolis: \"skewed\" is none of paper, skew, spatial, christoffel; did you mean "
         "\"skew\"? "
         "(see axode eval --help)"},
        {"NoTargets",
         {"eval", arm, "--want", "inverse_kinematics"},
         1,
         "axode eval: inverse_kinematics: the state has no \"targets\"; give a list of {\"frame\", "
         "\"pose\"}"},
        {"AFrameThatCannotMoveEveryWay",
         {"eval", arm, "--want", "operational_space_inertia", "--frame", "link 3"},
         1,
         "axode eval: operational_space_inertia: frame \"link 3\": the frame can move in 2 of six "
         "directions, so that "
         "it shows no inertia to a wrench; ask for inverse_operational_space_inertia"},
        {"ANameOfAnotherLibrary",
         {"eval", arm, "--want", "poses,gravity_vector"},
         2,
         "axode eval: --want: there is no quantity \"gravity_vector\"; it is called \"gravity_torques\" here "
         "(see axode "
         "eval --help)"},
        {"AFunctionOfAnotherLibrary",
         {"codegen", arm, "--functions", "crba"},
         2,
         "axode codegen: --functions: \"crba\" is none of poses, pose, jacobian, inverse_dynamics, "
         "forward_dynamics, mass_matrix, inverse_mass_matrix, inverse_dynamics_derivatives, "
         "forward_dynamics_derivatives, inverse_dynamics_jvp, inverse_dynamics_vjp, forward_dynamics_jvp, "
         "forward_dynamics_vjp, inverse_dynamics_hessian, forward_dynamics_hessian; it is "
         "called \"mass_matrix\" here (see axode codegen --help)"},
        {"AnEmptyWord",
         {"codegen", arm, "--output", ""},
         2,
         "axode codegen: --output is empty (see axode codegen --help)"},
        {"UnknownEnding",
         {"convert", arm, "arm.tml"},
         2,
         "axode convert: OUT: arm.tml: \".tml\" is none of .toml, .urdf, .xml; did you mean \".toml\"? "
         "(see axode convert --help)"},
        {"UnknownFunction",
         {"codegen", arm, "--functions", "inverse_dynamics,mass_matrx"},
         2,
         "axode codegen: --functions: \"mass_matrx\" is none of poses, pose, jacobian, inverse_dynamics, "
         "forward_dynamics, mass_matrix, inverse_mass_matrix, inverse_dynamics_derivatives, "
         "forward_dynamics_derivatives, inverse_dynamics_jvp, inverse_dynamics_vjp, forward_dynamics_jvp, "
         "forward_dynamics_vjp, inverse_dynamics_hessian, forward_dynamics_hessian; did you mean "
         "\"mass_matrix\"? (see axode codegen --help)"},
        {"JacobianOfNothing",
         {"codegen", arm, "--functions", "jacobian"},
         2,
         "axode codegen: --functions: jacobian needs a frame: jacobian:FRAME or jacobian:FRAME:REP (see "
         "axode "
         "codegen --help)"},
        {"JacobianOfAnUnknownFrame",
         {"codegen", arm, "--functions", "jacobian:flagne"},
         1,
         "axode codegen: model \"arm7\" has no frame \"flagne\"; did you mean \"flange\"?"},
        {"JacobianInAnUnknownRepresentation",
         {"codegen", arm, "--functions", "jacobian:flange:hybird"},
         2,
         "axode codegen: --functions: flange:hybird: \"hybird\" is none of body, spatial, hybrid, mixed; did "
         "you mean \"hybrid\"? (see axode codegen --help)"},
        {"FrameOfAFunctionThatHasNone",
         {"codegen", arm, "--functions", "mass_matrix:flange"},
         2,
         "axode codegen: --functions: \"mass_matrix:flange\": only jacobian and pose are about a frame (see "
         "axode "
         "codegen "
         "--help)"},
        {"FunctionAskedForTwice",
         {"codegen", arm, "--functions", "mass_matrix,mass_matrix"},
         1,
         "axode codegen: arm7_mass_matrix is asked for twice"},
        {"NameThatIsNoIdentifier",
         {"codegen", arm, "--name", "arm-7"},
         2,
         "axode codegen: --name: \"arm-7\" is no C identifier: letters, digits and underscores, no digit "
         "first "
         "(see axode codegen --help)"},
        {"UnknownAbi",
         {"codegen", arm, "--abi", "cud"},
         2,
         "axode codegen: --abi: \"cud\" is none of plain, casadi, cuda; did you mean \"cuda\"? (see axode "
         "codegen "
         "--help)"},
        {"OutputThatCannotBeWritten",
         {"codegen", arm, "--output", "/nowhere/arm7.c"},
         1,
         "axode codegen: /nowhere/arm7.c: the file cannot be written: no file can be made in /nowhere: No "
         "such file or "
         "directory"},
        {"StudyOfNoModel", {"study"}, 2, "axode study: MODEL is required (see axode study --help)"},
        {"StudyInAnUnknownFormat",
         {"study", arm, "--format", "csv"},
         2,
         "axode study: --format: \"csv\" is none of table, json (see axode study --help)"},
        {"StudyOfAMissingModel",
         {"study", "nowhere.toml"},
         1,
         "nowhere.toml: error: the file cannot be read: No such file or directory"},
        {"StudyIntoNoFolder",
         {"study", robot("double_pendulum.toml"), "--csv", "nowhere/study.csv"},
         1,
         "axode study: nowhere/study.csv: the file cannot be written: no file can be made in nowhere: No "
         "such file or "
         "directory"},
        {"MissingModel",
         {"eval", "nowhere.toml"},
         1,
         "nowhere.toml: error: the file cannot be read: No such file or directory"},
        {"MissingState",
         {"eval", arm, "--state", "nowhere.json"},
         1,
         "axode eval: nowhere.json: the file cannot be read"},
        {"AModelWithoutEnd",
         {"info", "/dev/zero"},
         1,
         "/dev/zero: error: the file cannot be read: it has more than 256 MiB"},
        {"AStateWithoutEnd",
         {"eval", arm, "--state", "/dev/zero"},
         1,
         "axode eval: /dev/zero: the file has more than 256 MiB"},
        {"AStateThatBreaksOff",
         {"eval", arm, "--state", "/proc/self/mem"},
         1,
         "axode eval: /proc/self/mem: the file cannot be read"},
        {"AFolderAsState", {"eval", arm, "--state", "/"}, 1, "axode eval: /: the file cannot be read"},
    }),
    [](const auto& p) { return p.param.name; });

struct BadState {
  const char* name;
  std::string state;
  std::string says;  ///< behind `axode eval: standard input: `, one line for each fault
};

void PrintTo(const BadState& bad, std::ostream* out) { *out << bad.name << " " << bad.state; }

class State : public testing::TestWithParam<BadState> {};

TEST_P(State, IsRefusedWithASentenceForEachFault) {
  const BadState& bad = GetParam();
  const Outcome outcome =
      axode({"eval", robot("machine.toml"), "--state", "-", "--format", "json"}, bad.state);
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.out, "");
  std::istringstream lines(outcome.err);
  std::string line, said;
  while (std::getline(lines, line)) {
    ASSERT_THAT(line, StartsWith("axode eval: standard input: "));
    said += (said.empty() ? "" : "\n") + line.substr(28);
  }
  EXPECT_EQ(said, bad.says);
}

INSTANTIATE_TEST_SUITE_P(
    Bad, State,
    testing::ValuesIn(std::vector<BadState>{
        {"NotJson", "{\"q\": [1, }",
         "this is not JSON: parse error at line 1, column 11: syntax error while parsing value - unexpected "
         "'}'; "
         "expected '[', '{', or a literal"},
        {"Empty", "",
         "this is not JSON: parse error at line 1, column 1: syntax error while parsing value - unexpected "
         "end of "
         "input; expected '[', '{', or a literal"},
        {"NumberTooLarge", "{\"q\": {\"feed\": 1e999}}", "this is not JSON: number overflow parsing '1e999'"},
        {"NotFinite", "{\"q\": {\"feed\": NaN}}",
         "this is not JSON: parse error at line 1, column 16: syntax error while parsing value - invalid "
         "literal; "
         "last read: '\"feed\": N'"},
        {"NotAnObject", "[1, 2]",
         "expected an object with the keys q, v, a, jerk, snap, tau, p, dq, dv, da, dtau, w, loads and "
         "targets, got [1,2]"},
        {"UnknownKey", "{\"qq\": []}",
         "the key \"qq\" is none of q, v, a, jerk, snap, tau, p, dq, dv, da, dtau, w, loads, targets; did "
         "you mean \"q\"?"},
        {"KeyTwice", "{\"v\": {\"feed\": 1, \"feed\": 2}}", "the key \"feed\" stands twice in one object"},
        {"TooFewCoordinates", "{\"q\": [1, 2]}", "q has 2 numbers; model \"machine\" takes nq = 20"},
        {"TooManyVelocities", "{\"v\": [0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]}",
         "v has 19 numbers; model \"machine\" takes nv = 18"},
        {"NoNumbers", "{\"a\": \"fast\"}",
         "a must be an array of numbers or an object keyed by joint name, got \"fast\""},
        {"UnknownJoint", "{\"q\": {\"jakc\": 1}}",
         "q: model \"machine\" has no joint \"jakc\"; did you mean \"jack\"?"},
        {"CoupledJoint", "{\"q\": {\"carriage slide\": 0.1}}",
         "q: joint \"carriage slide\" has no coordinate of its own; it follows joint \"feed\""},
        {"TooFewNumbersForAJoint", "{\"q\": {\"ball\": [0, 0, 1]}}",
         "q: joint \"ball\" takes 4 numbers, got [0,0,1]"},
        {"OneNumberForThree", "{\"v\": {\"ball\": 1}}", "v: joint \"ball\" takes 3 numbers, got 1"},
        {"AWordForANumber", "{\"v\": {\"feed\": \"1\"}}", "v: joint \"feed\" takes 1 number, got \"1\""},
        {"AWordAmongNumbers", "{\"v\": {\"ball\": [0, null, 0]}}",
         "v: joint \"ball\": entry 1 must be a number, got null"},
        {"QuaternionOffOne", "{\"q\": {\"ball\": [0, 0, 0, 2]}}",
         "q: the quaternion of joint \"ball\" has norm 2; it must be 1 to 1e-06"},
        {"LoadsNotAList", "{\"loads\": {\"frame\": \"table\"}}",
         "loads must be an array of objects, got {\"frame\":\"table\"}"},
        {"LoadNotAnObject", "{\"loads\": [7]}",
         "loads[0] must be an object with the keys frame, representation and wrench, got 7"},
        {"LoadWithoutAFrame", "{\"loads\": [{\"wrench\": [0,0,0,0,0,1]}]}",
         "loads[0]: the key \"frame\" is missing"},
        {"LoadWithoutAWrench", "{\"loads\": [{\"frame\": \"table\"}]}",
         "loads[0]: the key \"wrench\" is missing"},
        {"LoadOnAnUnknownFrame", "{\"loads\": [{\"frame\": \"tabel\", \"wrench\": [0,0,0,0,0,1]}]}",
         "loads[0]: model \"machine\" has no frame \"tabel\"; did you mean \"table\"?"},
        {"LoadInAnUnknownRepresentation",
         "{\"loads\": [{\"frame\": \"table\", \"representation\": \"bdy\", \"wrench\": [0,0,0,0,0,1]}]}",
         "loads[0]: representation: \"bdy\" is none of body, spatial, hybrid, mixed; did you mean \"body\"?"},
        {"LoadOfThreeNumbers", "{\"loads\": [{\"frame\": \"table\", \"wrench\": [0,0,1]}]}",
         "loads[0]: wrench takes 6 numbers, moment then force, got [0,0,1]"},
        {"LoadWithAnUnknownKey",
         "{\"loads\": [{\"frame\": \"table\", \"wrnch\": 1, \"wrench\": [0,0,0,0,0,1]}]}",
         "loads[0]: the key \"wrnch\" is none of frame, representation, wrench; did you mean \"wrench\"?"},
        {"LoadOfAWord", "{\"loads\": [{\"frame\": \"table\", \"wrench\": [0,0,0,0,0,\"up\"]}]}",
         "loads[0]: wrench: entry 5 must be a number, got \"up\""},
        {"TargetWithAWordForItsLastRow",
         "{\"targets\": [{\"frame\": \"table\", \"pose\": [[1,0,0,0],[0,1,0,0],[0,0,1,0],\"last\"]}]}",
         "targets[0]: row 3 of pose must be [0, 0, 0, 1], got \"last\""},
        {"TargetThatIsNoPose",
         "{\"targets\": [{\"frame\": \"table\", \"pose\": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,2]]}]}",
         "targets[0]: row 3 of pose must be [0, 0, 0, 1], got [0,0,0,2]"},
        {"SeveralFaults", "{\"q\": [1], \"v\": {\"nose\": 1}, \"x\": 0}",
         "q has 1 number; model \"machine\" takes nq = 20\nv: model \"machine\" has no joint \"nose\"\n"
         "the key \"x\" is none of q, v, a, jerk, snap, tau, p, dq, dv, da, dtau, w, loads, targets"},
    }),
    [](const auto& p) { return p.param.name; });

TEST(Errors, AStateThatIsNestedDeeplyIsRefused) {
  const std::size_t depth = 100'000;
  std::string lists = std::string(depth, '[') + std::string(depth, ']'), objects;
  for (std::size_t k = 0; k < depth; ++k) objects += "{\"q\":";
  objects += '1' + std::string(depth, '}');
  for (const std::string& state : {lists, objects, "{\"q\": " + lists + '}'}) {
    const Outcome outcome = axode({"eval", arm, "--state", "-"}, state);
    EXPECT_EQ(outcome.code, 1);
    EXPECT_EQ(outcome.err, "axode eval: standard input: it is nested deeper than 16 levels\n");
  }
}

TEST(Errors, AResultThatIsNotFiniteIsAnErrorAndNotAResult) {
  const Outcome outcome = axode({"eval", robot("arm7.toml"), "--state", "-", "--format", "json"},
                                R"({"v": {"A1": 1e200}, "q": {"A2": 1}})");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(
      outcome.err,
      "axode eval: inverse_dynamics is not finite; the numbers of the state or the model are too large\n");
}

TEST(Errors, AModelWithFaultsIsAnsweredByALineForEach) {
  const TemporaryFolder folder;
  const std::string file = folder.write("bad.toml", R"(format = "axode drawing 1"
[[body]]
name = "a"
on = "b"
joint = { kind = "revolute", axis = [0, 0, 0], point = [0, 0, 0] }
)");
  const Outcome outcome = axode({"eval", file});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.out, "");
  std::istringstream lines(outcome.err);
  std::string line;
  int n = 0;
  for (; std::getline(lines, line); ++n) EXPECT_THAT(line, StartsWith(file + ":"));
  EXPECT_EQ(n, 2) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("\"b\", which is not described"));
  EXPECT_THAT(outcome.err, HasSubstr("an axis is (0, 0, 0)"));
}

TEST(Errors, ABaseThatCannotBeSetFreeIsSaid) {
  const TemporaryFolder folder;
  const std::string file = folder.write("two.toml", R"(format = "axode drawing 1"
name = "two"
[[body]]
name = "a"
joint = { kind = "revolute", axis = "z", point = [0, 0, 0] }
mass = 1
com = [0, 0, 0]
inertia = [1, 1, 1]
)");
  const Outcome outcome = axode({"eval", file, "--base", "free"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err,
              HasSubstr("0 bodies are fixed to the ground; a free base needs exactly one to set free"));
}

TEST(Errors, OutputThatCannotBeWrittenIsAnError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this machine has no /dev/full";
  const Outcome outcome =
      run({"sh", "-c", "\"$0\" info \"$1\" > /dev/full", AXODE_COMMAND, robot("arm7.toml")});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, StartsWith("axode"));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
}

}  // namespace
}  // namespace axode::test
