#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "axode/contact.hpp"
#include "axode/integration.hpp"
#include "axode/io.hpp"
#include "axode/model/configuration.hpp"
#include "tests/apps/run_command.hpp"
#include "tests/support/shared_files.hpp"

/// `axode contacts`, and contacts in `axode simulate` and `axode view`.
namespace axode::test {
namespace {

using nlohmann::ordered_json;
using testing::HasSubstr;

const std::string quadruped = robot("quadruped.toml");

TEST(ContactsCommand, GivesThePointsOfTheLibrary) {
  const Outcome outcome = axode({"contacts", quadruped, "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const ordered_json shown = ordered_json::parse(outcome.out);
  const Model model = load(quadruped);
  const ContactShapes shapes(model);
  const ContactsAtRest found = contacts_at_rest(model, shapes, neutral(model));
  ASSERT_EQ(shown["contacts"].size(), found.contacts.size());
  ASSERT_EQ(found.contacts.size(), 4u) << "the four feet";
  for (std::size_t k = 0; k < 4; ++k) {
    const ordered_json& contact = shown["contacts"][k];
    EXPECT_EQ(contact["a"], "floor");
    EXPECT_EQ(contact["b"], shapes[found.contacts[k].b].name);
    EXPECT_EQ(contact["force"][2], found.contacts[k].force.z);
    EXPECT_EQ(contact["status"], std::string(to_string(found.contacts[k].branch)));
  }
  EXPECT_EQ(shown["at_rest"], false) << "its knees give way without drives";
  EXPECT_LE(shown["certificate"], 1e-12);
}

TEST(ContactsCommand, SaysWhetherItStaysAtRestAndWhatIsMissing) {
  const TemporaryFolder folder;
  const std::string ball = folder.write("ball.urdf", R"(<robot name="ball"><link name="ball"><inertial>
    <mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>)");
  const Outcome alone = axode({"contacts", ball, "--base", "free"});
  EXPECT_EQ(alone.code, 0) << alone.err;
  EXPECT_THAT(alone.out, HasSubstr("no collision shapes can touch; --floor"));
  const Outcome above = axode({"contacts", ball, "--base", "free", "--floor", "-0.5"});
  EXPECT_THAT(above.out, HasSubstr("no shapes are nearer than the margin of 0.01 m"));
  EXPECT_THAT(above.out, HasSubstr("starts to move, with accelerations of up to 9.81"));
  const Outcome on_floor = axode({"contacts", ball, "--base", "free", "--floor", "-0.1"});
  EXPECT_THAT(on_floor.out, HasSubstr("stick"));
  EXPECT_THAT(on_floor.out, HasSubstr("the mechanism stays at rest; certificate "));
  const Outcome refused = axode({"contacts", ball, "--floor", "nan"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, HasSubstr("the height is nan m; it must be finite"));
}

/// A foot on a rail above a floor.
constexpr const char* foot = R"(format = "axode drawing 1"
name = "foot"
contact = {}
shape = [{ name = "floor", kind = "plane", role = "collision" }]
[[body]]
name = "cart"
joint = { name = "rail", kind = "prismatic", axis = "x" }
[[body]]
name = "foot"
on = "cart"
joint = { name = "down", kind = "prismatic", axis = "z" }
mass = 1
com = [0, 0, 0.1]
inertia = [1, 1, 1]
shape = [{ kind = "sphere", role = "collision", radius = 0.1, position = [0, 0, 0.1] }]
)";

TEST(ContactsCommand, RefusesWhatActsAndIsNotCounted) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& more) {
    const Outcome outcome = axode({"contacts", folder.write("foot.toml", foot + more)});
    EXPECT_EQ(outcome.code, 1) << outcome.out;
    return outcome.err;
  };
  EXPECT_THAT(refusal(R"([[drive]]
name = "motor"
kind = "dc_motor"
joint = "rail"
resistance = 1
inductance = 0.01
torque_constant = 0.1
input = 12
initial = { current = 50 })"),
              HasSubstr("contacts_at_rest does not count drives with states, and model \"foot\" has 1"));
  EXPECT_THAT(refusal(R"([[coupling]]
name = "gear"
terms = { rail = 1, down = -1 }
play = 0.02)"),
              HasSubstr("contacts_at_rest does not count couplings with play, and model \"foot\" has 1; "
                        "simulate without contact"));
  const Outcome no_margin = axode({"contacts", folder.write("foot.toml", foot), "--margin", "nan"});
  EXPECT_EQ(no_margin.code, 1) << no_margin.out;
  EXPECT_THAT(no_margin.err, HasSubstr("margin is nan m; it must be finite and not negative"));
}

TEST(ContactsCommand, RefusesAStateThatIsNotAtRest) {
  const TemporaryFolder folder;
  const std::string drawing = folder.write("foot.toml", foot);
  EXPECT_EQ(
      axode({"contacts", drawing, "--state", folder.write("at_rest.json", R"({"v": {"rail": 0}})")}).code, 0);
  const Outcome moving =
      axode({"contacts", drawing, "--state", folder.write("moving.json", R"({"v": {"rail": 1}})")});
  EXPECT_EQ(moving.code, 1);
  EXPECT_THAT(moving.err, HasSubstr("STATE has velocities, v; contacts finds forces at rest"));
}

TEST(ContactsCommand, FindsForcesOfClosedLoopsOnly) {
  const std::string four_bar = robot("four_bar.toml"), open = R"({"q": {"crank_joint": 0.5}})";
  EXPECT_EQ(axode({"contacts", four_bar}).code, 0);
  EXPECT_EQ(axode({"contacts", four_bar, "--state", "-", "--assemble"}, open).code, 0);
  const Outcome refused = axode({"contacts", four_bar, "--state", "-"}, open);
  EXPECT_EQ(refused.code, 1);
  EXPECT_EQ(refused.out, "");
  EXPECT_THAT(refused.err, testing::StartsWith("axode contacts: q leaves loop \"pin\" open by "));
}

TEST(ContactsCommand, SaysThatWhatIsFixedStaysAtRest) {
  const TemporaryFolder folder;
  const std::string head = "format = \"axode drawing 1\"\n", post = R"([[body]]
name = "post"
joint = { kind = "fixed" }
mass = 1
com = [0, 0, 0]
inertia = [1, 1, 1]
)";
  for (const std::string& drawing : {head, head + post}) {
    const Outcome outcome = axode({"contacts", folder.write("fixed.toml", drawing), "--floor", "0"});
    EXPECT_EQ(outcome.code, 0) << outcome.err << drawing;
    EXPECT_THAT(outcome.out, HasSubstr("the mechanism stays at rest; certificate 0"));
  }
}

TEST(SimulateCommand, PutsAUrdfOnAFloorWithStepsOfAMillisecond) {
  const TemporaryFolder folder;
  const std::string urdf = (folder.path() / "quadruped.urdf").string();
  ASSERT_EQ(axode({"convert", quadruped, urdf}).code, 0);
  const Outcome outcome = axode({"simulate", urdf, "--contact", "--base", "free", "--floor", "0", "--until",
                                 "0.02", "--pd", "40,0.8", "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const ordered_json motion = ordered_json::parse(outcome.out);
  EXPECT_EQ(motion["steps"], 20);
  ASSERT_EQ(motion["contacts"].size(), 21u);
  EXPECT_TRUE(motion["contacts"][0].empty());
  EXPECT_EQ(motion["contacts"][20].size(), 4u);
  const Outcome nothing = axode({"simulate", robot("arm7.toml"), "--contact", "--until", "0.01"});
  EXPECT_EQ(nothing.code, 0);
  EXPECT_THAT(nothing.err, HasSubstr("no collision shapes can touch; --floor"));
}

TEST(SimulateCommand, DrawsContactForcesAndTheViewerReadsThem) {
  const TemporaryFolder folder;
  const std::string json = (folder.path() / "run.json").string(), svg = (folder.path() / "run.svg").string(),
                    page = (folder.path() / "page.html").string();
  const Outcome outcome =
      axode({"simulate", quadruped, "--until", "0.05", "--pd", "40,0.8", "--output", json, "--plot", svg});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("largest certificate of contact"));
  const std::string drawn = contents(svg);
  for (const char* words : {"normal force, N", "friction force, N", "floor and FL foot"})
    EXPECT_THAT(drawn, HasSubstr(words));
  if (std::string_view(AXODE_PAGE).empty()) return;
  const Outcome shown = axode({"view", quadruped, "--motion", json, "--output", page});
  ASSERT_EQ(shown.code, 0) << shown.err;
  const std::string html = contents(page);
  EXPECT_THAT(html, HasSubstr(R"("contact_shapes":["floor","belly","FL foot")"));
  EXPECT_THAT(html, HasSubstr("normal forces of contacts"));

  ordered_json wrong = ordered_json::parse(contents(json));
  wrong["contacts"][3][0]["status"] = "glue";
  std::ofstream(json) << wrong;
  const Outcome refused = axode({"view", quadruped, "--motion", json, "--output", page});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, HasSubstr("contacts: there is no status glue"));
}

}  // namespace
}  // namespace axode::test
