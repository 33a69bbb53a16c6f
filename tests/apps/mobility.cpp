#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "axode/constraints/local_mobility/local_mobility.hpp"
#include "axode/io.hpp"
#include "axode/model/configuration.hpp"
#include "tests/apps/run_command.hpp"

/// `axode mobility` prints what local_mobility finds.
namespace axode::test {
namespace {

using testing::HasSubstr;

const char* const parallelogram = R"(format = "axode drawing 1"
name = "parallelogram"
[[body]]
name = "crank"
joint = { kind = "revolute", axis = "z", point = [0, 0, 0] }
mass = 1
com = [0.5, 0, 0]
inertia = [0, 0.1, 0.1]
[[body]]
name = "coupler"
on = "crank"
joint = { kind = "revolute", axis = "z", point = [1, 0, 0] }
mass = 1
com = [2, 0, 0]
inertia = [0, 0.1, 0.1]
[[body]]
name = "rocker"
joint = { kind = "revolute", axis = "z", point = [2, 0, 0] }
mass = 1
com = [2.5, 0, 0]
inertia = [0, 0.1, 0.1]
[[loop]]
name = "pin"
between = ["coupler", "rocker"]
kind = "revolute"
axis = "z"
point = [3, 0, 0]
)";

TEST(MobilityCommand, SaysInJsonWhatTheLibraryFinds) {
  const Outcome outcome = axode({"mobility", robot("bricard.toml"), "--order", "6", "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto shown = nlohmann::ordered_json::parse(outcome.out);
  const Model model = load(robot("bricard.toml"));
  const LocalMobility found = local_mobility(model, neutral(model), {.order = 6});
  EXPECT_EQ(shown["words"], mobility_words(model, found));
  EXPECT_EQ(shown["mobility_by_order"], found.mobility_by_order);
  EXPECT_EQ(shown["rank"], found.rank);
  EXPECT_EQ(shown["length"], found.length);
  EXPECT_EQ(shown["coordinates"].size(), found.coordinates.size());
  ASSERT_EQ(shown["branches"].size(), 1U);
  const auto& branch = shown["branches"][0];
  EXPECT_EQ(branch["points"].size(), found.branches[0].points.size());
  for (std::size_t c = 0; c < found.coordinates.size(); ++c) {
    EXPECT_EQ(branch["tangent"][0][c], found.branches[0].T(0, static_cast<Eigen::Index>(c)));
    EXPECT_EQ(branch["second_form"][0][c], found.branches[0].II(0, static_cast<Eigen::Index>(c)));
  }
}

TEST(MobilityCommand, PrintsBranchesAndTheLoopsTheyComeFrom) {
  const TemporaryFolder folder;
  const std::string file = folder.write("parallelogram.toml", parallelogram);
  const Outcome outcome = axode({"mobility", file});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  for (const char* const words :
       {"parallelogram: branch point, kinematic singularity", "mobility by order: 2, 1, 1",
        "a condition of degree 2 from pin", "branch 2: dimension 1; moves pin", "0 on no branch", "no proof"})
    EXPECT_THAT(outcome.out, HasSubstr(words));
  const Outcome opened = axode({"mobility", file, "--state", "-"}, R"({"q": [0.3, 0, 0]})");
  EXPECT_EQ(opened.code, 1);
  EXPECT_THAT(opened.err, HasSubstr("loop \"pin\" is open by"));
  const Outcome closed = axode({"mobility", file, "--state", "-", "--assemble", "--hold", "crank_joint"},
                               R"({"q": [0.3, -0.3, 0.3]})");
  EXPECT_EQ(closed.code, 0) << closed.err;
  EXPECT_THAT(closed.out, HasSubstr("parallelogram: regular"));
}

TEST(MobilityCommand, SaysThatATreeHasNoLoops) {
  const Outcome outcome = axode({"mobility", robot("arm7.toml")});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("arm7: no loops"));
}

}  // namespace
}  // namespace axode::test
