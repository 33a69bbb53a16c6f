#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/apps/run_command.hpp"
#include "tests/apps/texts_of_svg.hpp"

/// The output of `axode study`: its printed table, its file and its chart show the same numbers for every
/// algorithm, representation and choice of frames.
namespace axode::test {
namespace {

using Json = nlohmann::ordered_json;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr const char* header =
    "model,bodies,velocities,algorithm,frames,representation,mul,add,div,sqrt,sin_cos,screw_transformations,"
    "screw_rotations,screw_translations,tensor_transformations,tensor_rotations,tensor_translations,brackets,"
    "ns";

std::vector<std::string> split(const std::string& text, char separator) {
  std::istringstream in(text);
  std::vector<std::string> parts;
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

/// The number of rows of each algorithm: four choices of frames in four representations, and one row for the
/// fast path.
const std::map<std::string, int> rows_of{{"inverse_dynamics", 17}, {"forward_dynamics", 17},
                                         {"mass_matrix", 17},      {"inverse_mass_matrix", 17},
                                         {"accelerations", 16},    {"momentum_form", 16}};

TEST(Study, WritesARowForEveryWayToCompute) {
  const TemporaryFolder folder;
  const std::string csv = folder.file("study.csv");
  const Outcome outcome = axode({"study", robot("arm7.toml"), "--csv", csv});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "") << "progress is for terminals";
  for (const char* said : {"arm7: 7 moving bodies, nv = 7", "joint ", "user ", "com ", "construction", "body",
                           "spatial", "hybrid", "mixed", "fast", "mul", "add", "sin cos", "Ad_R", "M Ad"})
    EXPECT_THAT(outcome.out, HasSubstr(said));

  const std::vector<std::string> lines = split(contents(csv), '\n');
  EXPECT_EQ(lines.at(0), header);
  std::map<std::string, int> rows;
  std::set<std::string> ways;
  for (std::size_t k = 1; k < lines.size(); ++k) {
    const std::vector<std::string> cells = split(lines[k], ',');
    ASSERT_EQ(cells.size(), split(header, ',').size()) << lines[k];
    EXPECT_EQ(cells[0] + cells[1] + cells[2], "\"arm7\"77");
    ++rows[cells[3]];
    EXPECT_TRUE(ways.insert(cells[3] + cells[4] + cells[5]).second) << lines[k];
    EXPECT_GT(std::stol(cells[6]), 0);
    EXPECT_GT(std::stod(cells[18]), 0);
    EXPECT_THAT(outcome.out, HasSubstr(cells[3]));
  }
  EXPECT_EQ(rows, rows_of);
}

TEST(Study, CountsTheSameInJsonAndCsv) {
  const TemporaryFolder folder;
  const std::string csv = folder.file("study.csv");
  const Outcome outcome =
      axode({"study", robot("double_pendulum.toml"), robot("arm7.toml"), "--csv", csv, "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::vector<std::string> lines = split(contents(csv), '\n'), names = split(header, ',');
  std::size_t line = 1;
  for (const Json& study : Json::parse(outcome.out))
    for (const Json& effort : study["efforts"]) {
      const std::vector<std::string> cells = split(lines.at(line++), ',');
      EXPECT_EQ(cells[0], '"' + study["model"].get<std::string>() + '"');
      for (std::size_t k = 3; k < names.size(); ++k) {
        const Json& value = effort[names[k]];
        if (value.is_string())
          EXPECT_EQ(cells[k], value.get<std::string>());
        else
          EXPECT_EQ(std::stod(cells[k]), value.get<double>());
      }
    }
  EXPECT_EQ(line, lines.size());
}

TEST(Study, CountsForASingleHingeWhatThePaperCounts) {
  const TemporaryFolder folder;
  const std::string drawing = folder.write("door.toml", R"(format = "axode drawing 1"
name = "a \"door\" & <hinge>"
[[body]]
name = "leaf"
joint = { kind = "revolute", axis = "z", point = [0, 0, 0] }
mass = 20
com = [0.4, 0, 1]
inertia = [7, 8, 1]
)");
  const std::string csv = folder.file("door.csv");
  const Outcome outcome = axode({"study", drawing, "--csv", csv});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(contents(csv), HasSubstr("\n\"a \"\"door\"\" & <hinge>\",1,1,inverse_dynamics,joint,body,"));
  EXPECT_THAT(contents(csv), HasSubstr(",2,3,0,0,0,0,0,2,"));
}

TEST(Study, LeavesOutWhatASingularMassMatrixForbids) {
  const TemporaryFolder folder;
  const std::string drawing = folder.write("weightless.toml", R"(format = "axode drawing 1"
name = "weightless"
[[body]]
name = "pointer"
joint = { kind = "revolute", axis = "z", point = [0, 0, 0] }
)");
  const std::string csv = folder.file("study.csv");
  const Outcome outcome = axode({"study", drawing, "--csv", csv});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              HasSubstr("forward_dynamics, inverse_mass_matrix and momentum_form are left out: "));
  EXPECT_THAT(contents(csv), HasSubstr(",inverse_dynamics,"));
  EXPECT_THAT(contents(csv), Not(HasSubstr(",forward_dynamics,")));
}

TEST(Study, CountsWithoutTimes) {
  const TemporaryFolder folder;
  const std::string csv = folder.file("study.csv");
  const Outcome outcome = axode({"study", robot("arm7.toml"), "--counts", "--csv", csv, "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json study = Json::parse(outcome.out)[0];
  for (const Json& effort : study["efforts"]) EXPECT_FALSE(effort.contains("ns"));
  for (const std::string& line : split(contents(csv), '\n'))
    EXPECT_TRUE(line.ends_with(',') || line == header) << line;
  for (const Json& effort : study["ways"]) EXPECT_FALSE(effort.contains("ns"));
  EXPECT_EQ(study["ways"][0]["mul"], study["efforts"][0]["mul"]) << "the library's way comes first";
  EXPECT_EQ(study["contraction"][0]["compressions"], 0);
  EXPECT_EQ(study["contraction"][0]["rounds"], 7);
  EXPECT_LT(study["contraction"][0]["longest_path"], study["contraction"][0]["operations"]);
  EXPECT_EQ(axode({"study", robot("arm7.toml"), "--counts", "--plot", folder.file("x.svg")}).code, 1);
}

TEST(Study, LosesDigitsWithTheDistanceOnlyAboutTheInertialOrigin) {
  const Outcome outcome = axode({"study", robot("arm7.toml"), "--counts", "--rounding", "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json study = Json::parse(outcome.out)[0];
  ASSERT_EQ(study["rounding"].size(), 12U);
  for (const Json& row : study["rounding"]) {
    for (const char* representation : {"body", "spatial", "hybrid", "mixed"})
      EXPECT_LT(row["inverse_dynamics"][representation], 1e-13) << row.dump();
    if (row["heaviness"] != 1) continue;
    for (const char* representation : {"body", "spatial", "hybrid", "mixed"})
      EXPECT_LT(row["forward_dynamics"][representation], 1e-11) << row.dump();
    if (row["distance"] < 1e4) continue;
    EXPECT_GT(row["inverse_dynamics"]["inertial"], 1e-10) << row.dump();
    EXPECT_GT(row["forward_dynamics"]["inertial"], 1e-9) << row.dump();
  }
}

TEST(Study, KeepsJointsOnTheGroundClosedOnSE3WithoutProjection) {
  const Outcome outcome =
      axode({"study", robot("double_pendulum.toml"), "--counts", "--drift", "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json drift = Json::parse(outcome.out)[0]["drift"];
  ASSERT_EQ(drift.size(), 5U);
  for (const char* group : {"SE3", "by_joint"})
    for (const Json& row : drift) EXPECT_LT(row[group]["joints_on_ground"], 1e-13) << row.dump();
  EXPECT_GT(drift[0]["SO3xR3"]["joints_on_ground"], 1e-6);
  const double order =
      std::log2(double(drift[0]["SO3xR3"]["all_joints"]) / double(drift[1]["SO3xR3"]["all_joints"]));
  EXPECT_NEAR(order, 4, 0.5);
}

TEST(Study, IsDrawnWithEveryAlgorithmByTheExampleOfTheHelp) {
  const std::string example = "axode study double_pendulum.toml --csv study.csv --plot study.svg";
  EXPECT_THAT(axode({"study", "--help"}).out, HasSubstr("Example:\n  " + example + "\n\n"));
  const TemporaryFolder folder;
  std::filesystem::copy(robot("double_pendulum.toml"), folder.path());
  const std::string in_folder = "cd \"$0\" && axode() { \"" AXODE_COMMAND "\" \"$@\"; } && ";
  const Outcome outcome = run({"sh", "-c", in_folder + example, folder.path().string()});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  const std::vector<std::string> texts = texts_of(folder.file("study.svg"));
  for (const auto& [algorithm, rows] : rows_of) EXPECT_THAT(texts, Contains("double pendulum: " + algorithm));
  for (const char* said :
       {"µs", "body", "spatial", "hybrid", "mixed", "fast", "operations", "joint", "constr."})
    EXPECT_THAT(texts, Contains(said));
}

TEST(Study, IntoNoFolderIsRefused) {
  const Outcome outcome = axode({"study", robot("double_pendulum.toml"), "--csv", "nowhere/study.csv"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err,
            "axode study: nowhere/study.csv: the file cannot be written: no file can be made in nowhere: "
            "No such file or directory\n");
}

TEST(Study, SetsTheBaseFree) {
  const TemporaryFolder folder;
  const std::string csv = folder.file("study.csv");
  ASSERT_EQ(axode({"study", robot("humanoid.urdf"), "--base", "free", "--csv", csv}).code, 0);
  EXPECT_THAT(contents(csv), HasSubstr("\"humanoid\",32,37,inverse_dynamics,construction,mixed,"));
}

}  // namespace
}  // namespace axode::test
