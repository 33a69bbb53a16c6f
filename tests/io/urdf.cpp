#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <locale>
#include <string>

#include "axode/io.hpp"
#include "axode/lie/screw_geometry.hpp"
#include "axode/model/building/builder.hpp"
#include "tests/io/same_mechanism.hpp"
#include "tests/support/counted_work.hpp"

namespace axode {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double infinity = std::numeric_limits<double>::infinity();

Model model_of_urdf(const std::string& elements) {
  const std::string text = "<robot name=\"r\">\n" + elements + "</robot>\n";
  return ModelBuilder(read_urdf_text(text, "test.urdf")).build();
}

std::string link(const std::string& name) {
  return "<link name=\"" + name + R"("><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
)";
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& inner = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + inner + "</joint>\n";
}

std::vector<std::string> messages(const Model& model) {
  std::vector<std::string> all;
  for (const Fault& fault : model.warnings()) all.push_back(to_string(fault));
  return all;
}

TEST(Urdf, TheJointFrameIsTheFrameOfTheChild) {
  const Model model =
      model_of_urdf(link("a") + link("b") +
                    joint("j", "continuous", "a", "b",
                          R"(<origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><axis xyz="0 2 0"/>)"));
  const Body& b = model.body(1);
  EXPECT_LT(norm(b.A.r - Vec3<>{1, 2, 3}), 1e-15);
  EXPECT_LT(norm(b.A.R.x - Vec3<>{0, 1, 0}), 1e-15);
  EXPECT_LT(test::disparity(b.X[0], Screw<>{{0, 1, 0}, {}}), 1e-15);
  EXPECT_LT(test::disparity(Ad(b.A, b.X[0]), screw(Vec3<>{-1, 0, 0}, Vec3<>{1, 2, 3})), 1e-15);
}

TEST(Urdf, RollPitchYawTurnAboutFixedAxesInThisOrder) {
  const Model model =
      model_of_urdf(link("a") + link("b") + joint("j", "fixed", "a", "b", R"(<origin rpy="0.3 -0.4 0.5"/>)"));
  const SO3<> expected =
      exp_SO3(Vec3<>{0, 0, 0.5}) * exp_SO3(Vec3<>{0, -0.4, 0}) * exp_SO3(Vec3<>{0.3, 0, 0});
  const SO3<>& R = model.frame(model.frame_index("b")).pose.R;
  EXPECT_LT(norm(R.x - expected.x) + norm(R.y - expected.y) + norm(R.z - expected.z), 1e-15);
}

TEST(Urdf, TheAxisIsXWhereNoneIsGiven) {
  const Model model = model_of_urdf(link("a") + link("b") + joint("j", "continuous", "a", "b"));
  EXPECT_EQ(norm(model.body(1).X[0].w - Vec3<>{1, 0, 0}), 0);
}

TEST(Urdf, BodiesFollowDepthFirstInTheOrderOfTheJoints) {
  const Model model = model_of_urdf(
      link("d") + link("c") + link("b") + link("a") + link("root") +
      joint("second", "continuous", "root", "b") + joint("third", "continuous", "root", "c") +
      joint("first of second", "continuous", "b", "d") + joint("fourth", "continuous", "root", "a"));
  std::vector<std::string> order;
  for (const Joint& j : model.joints()) order.push_back(j.name);
  EXPECT_THAT(order, ElementsAre("second", "first of second", "third", "fourth"));
}

TEST(Urdf, LimitsDampingAndFrictionAreKept) {
  const Model model = model_of_urdf(link("a") + link("b") +
                                    joint("j", "prismatic", "a", "b",
                                          R"(<limit lower="-1" upper="2" velocity="3" effort="4"/>
                                                                <dynamics damping="0.5" friction="0.6"/>)"));
  const Dof expected{-1, 2, 3, 4, 0.5, 0.6, 0};
  EXPECT_TRUE(test::same(model.joint(1).dof[0], expected));
  EXPECT_THAT(messages(model), ElementsAre());
}

TEST(Urdf, AContinuousJointHasNoLimitsOfPosition) {
  const Model model =
      model_of_urdf(link("a") + link("b") +
                    joint("j", "continuous", "a", "b", R"(<limit lower="0" upper="0" velocity="3"/>)"));
  const Dof expected{-infinity, infinity, 3, infinity, 0, 0, 0};
  EXPECT_TRUE(test::same(model.joint(1).dof[0], expected));
  EXPECT_THAT(messages(model), ElementsAre());
}

TEST(Urdf, MissingLimitsAreDoubtfulAndUnlimited) {
  const Model model = model_of_urdf(link("a") + link("b") + link("c") + joint("j", "revolute", "a", "b") +
                                    joint("k", "revolute", "b", "c", R"(<limit effort="1"/>)"));
  EXPECT_EQ(model.joint(1).dof[0].upper, infinity);
  EXPECT_EQ(model.joint(2).dof[0].upper, 0);
  EXPECT_EQ(model.joint(2).dof[0].velocity, infinity);
  EXPECT_THAT(messages(model), ElementsAre(HasSubstr("joint \"j\": is revolute and has no <limit>"),
                                           HasSubstr("joint \"k\": <limit> has no velocity"),
                                           HasSubstr("joint \"k\": <limit> has neither lower nor upper")));
}

TEST(Urdf, TheLargestDoubleAndInfMeanNoLimit) {
  const Model model = model_of_urdf(
      link("a") + link("b") +
      joint(
          "j", "revolute", "a", "b",
          R"(<limit lower="-1.7976931348623157e+308" upper="inf" velocity="1.7976931348623157e308" effort="7"/>)"));
  const Dof expected{-infinity, infinity, infinity, 7, 0, 0, 0};
  EXPECT_TRUE(test::same(model.joint(1).dof[0], expected));
}

TEST(Urdf, FloatingAndPlanarJointsHaveSixAndThreeDegreesOfFreedom) {
  const Model model =
      model_of_urdf(link("a") + link("b") + link("c") + joint("j", "floating", "a", "b") +
                    joint("k", "planar", "b", "c",
                          R"(<axis xyz="0 1 0"/><limit velocity="2" effort="3"/><dynamics damping="0.1"/>)"));
  EXPECT_EQ(model.joint(1).kind, Subgroup::free);
  EXPECT_EQ(model.joint(2).kind, Subgroup::planar);
  ASSERT_EQ(model.joint(2).dof.size(), 3U);
  for (const Dof& dof : model.joint(2).dof)
    EXPECT_TRUE(test::same(dof, Dof{-infinity, infinity, 2, 3, 0.1, 0, 0}));
  EXPECT_EQ(norm(model.body(2).X[0].w - Vec3<>{0, 1, 0}), 0);  // the normal
}

TEST(Urdf, LimitsTheWrongWayRoundAreNone) {
  const Model model = model_of_urdf(
      link("a") + link("b") +
      joint("j", "revolute", "a", "b", R"(<limit lower="1" upper="-1" velocity="2" effort="3"/>)"));
  EXPECT_TRUE(test::same(model.joint(1).dof[0], Dof{-infinity, infinity, 2, 3, 0, 0, 0}));
  EXPECT_THAT(messages(model),
              ElementsAre(HasSubstr("joint \"j\": lower limit 1 is above upper limit -1; it is "
                                    "taken as unlimited")));
}

TEST(Urdf, AJointThatFollowsOneWhichDoesNotExistMovesOnItsOwn) {
  const Model model =
      model_of_urdf(link("a") + link("b") + link("c") + joint("left", "continuous", "a", "b") +
                    joint("right", "continuous", "a", "c", R"(<mimic joint="lefd"/>)"));
  EXPECT_EQ(model.nq(), 2);
  EXPECT_THAT(messages(model),
              ElementsAre(HasSubstr("joint \"right\": follows joint \"lefd\", which is not "
                                    "described, and moves on its own; did you mean \"left\"?")));
}

TEST(Urdf, OfManyUnknownLeadersOnlyTheFirstGetASuggestion) {
  test::expect_work_in_proportion_to_size([](int n) {
    std::string elements = "<link name=\"base\"/>";
    for (int k = 0; k < n; ++k) {
      const std::string id = std::to_string(10'000 + k);
      elements += "<link name=\"l" + id + "\"/>" +
                  joint("joint_" + id, "continuous", "base", "l" + id, "<mimic joint=\"jiont_" + id + "\"/>");
    }
    const std::string text = "<robot name=\"r\">" + elements + "</robot>";
    for (const Strictness strictness : {Strictness::lenient, Strictness::strict}) {
      const std::vector<Fault> faults =
          ModelBuilder(read_urdf_text(text, "many.urdf", strictness)).check(strictness);
      ASSERT_GE(faults.size(), static_cast<std::size_t>(n));
      const auto suggestions = std::ranges::count_if(
          faults, [](const Fault& fault) { return fault.message.find("did you mean") != std::string::npos; });
      EXPECT_GT(suggestions, 0);
      EXPECT_LE(suggestions, 20);
    }
  });
}

TEST(Urdf, ASecondEqualElementAndAScaleOfFourNumbersAreDoubts) {
  const Model model = model_of_urdf(
      "<link name=\"a\"/>\n<link name=\"b\"><visual><geometry><mesh filename=\"b.stl\" scale=\"2 2 2 2\"/>"
      "</geometry></visual></link>\n" +
      joint("j", "continuous", "a", "b", R"(<axis xyz="0 0 1"/><axis xyz="0 0 1"/>)"));
  EXPECT_EQ(model.body(1).X[0].w.z, 1);
  EXPECT_EQ(model.description().bodies[1].shapes[0].scale.x, 1);
  EXPECT_THAT(
      messages(model),
      ElementsAre(HasSubstr("<mesh> scale is \"2 2 2 2\"; it needs 3 numbers and has 4; it is ignored"),
                  HasSubstr("joint \"j\": <joint> holds two equal <axis>"), HasSubstr("moves no mass")));
}

TEST(Urdf, MimicCouplesAJoint) {
  const Model model = model_of_urdf(
      link("a") + link("b") + link("c") + link("d") +
      joint("j", "continuous", "a", "b", R"(<mimic joint="l" multiplier="-2" offset="0.5"/>)") +
      joint("k", "continuous", "a", "c", R"(<mimic joint="l"/>)") + joint("l", "continuous", "a", "d"));
  EXPECT_EQ(model.nq(), 1);
  EXPECT_EQ(model.joint(1).leader->ratio, -2);
  EXPECT_EQ(model.joint(1).leader->offset, 0.5);
  EXPECT_EQ(model.joint(2).leader->ratio, 1);
  EXPECT_EQ(model.joint(2).leader->joint, 3);
}

TEST(Urdf, LoopJointsCloseLoopsBetweenFramesOfLinks) {
  const Model model = model_of_urdf(link("a") + link("b") + link("c") + joint("j", "continuous", "a", "b") +
                                    joint("k", "continuous", "a", "c") +
                                    R"(<loop_joint name="pin" type="spherical"><link1 link="b" xyz="1 0 0"/>
      <link2 link="c" xyz="0 1 0" rpy="0 0 -1.5707963267948966"/></loop_joint>
      <loop_joint name="axle" type="continuous"><link1 link="b"/><link2 link="a" xyz="0 0 1"/></loop_joint>)");
  ASSERT_EQ(model.loops().all.size(), 2U);
  const Loop &pin = model.loops().joints[0], &axle = model.loops().joints[1];
  EXPECT_EQ(pin.name, "pin");
  EXPECT_EQ(pin.kind, LoopKind::spherical);
  EXPECT_EQ(axle.kind, LoopKind::revolute);
  const auto& frames = *model.description().loops[0].frames;
  EXPECT_EQ(frames[0].r.x, 1);
  EXPECT_EQ(frames[1].r.y, 1);
  EXPECT_NEAR(frames[1].R.x.y, -1, 1e-15);
  EXPECT_THAT(messages(model), ElementsAre());
}

TEST(Urdf, FixedLinksAreMergedAndStayFrames) {
  const Model model = model_of_urdf(link("a") + link("b") + link("c") + joint("j", "continuous", "a", "b") +
                                    joint("k", "fixed", "b", "c", R"(<origin xyz="0 0 2"/>)"));
  EXPECT_EQ(model.n_bodies(), 1);
  EXPECT_EQ(model.body(1).M.m, 2);
  EXPECT_LT(norm(center_of_mass(model.body(1).M) - Vec3<>{0.1, 0, 1}), 1e-15);
  const Frame& c = model.frame(model.frame_index("c"));
  EXPECT_EQ(c.body, 1);
  EXPECT_EQ(c.pose.r.z, 2);
}

TEST(Urdf, TheInertiaIsTurnedIntoTheAxesOfTheLink) {
  const Model model = model_of_urdf(R"(<link name="a"/><link name="b"><inertial>
      <origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/><mass value="3"/>
      <inertia ixx="1" ixy="0.1" ixz="0" iyy="2" iyz="0" izz="2.5"/></inertial></link>)" +
                                    joint("j", "continuous", "a", "b"));
  const Inertia<>& M = model.body(1).M;
  const Sym3<> Theta_c = inertia_about_com(M);
  EXPECT_NEAR(Theta_c.xx, 2, 1e-14);
  EXPECT_NEAR(Theta_c.yy, 1, 1e-14);
  EXPECT_NEAR(Theta_c.xy, -0.1, 1e-14);
  EXPECT_NEAR(center_of_mass(M).z, 1, 1e-15);
}

TEST(Urdf, ALinkWithoutInertialIsMasslessAndZeroesAreOneDoubt) {
  const std::string zero = R"(<inertial><mass value="0"/>
    <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>)";
  const Model model = model_of_urdf("<link name=\"a\"/><link name=\"b\">" + zero + "<link name=\"c\">" +
                                    zero + link("d") + joint("j", "continuous", "a", "b") +
                                    joint("k", "continuous", "b", "c") + joint("l", "continuous", "c", "d"));
  EXPECT_EQ(model.total_mass(), 1);
  EXPECT_THAT(messages(model),
              ElementsAre(HasSubstr("mass and inertia are 0; a massless link needs no <inertial> (2 "
                                    "times, first here)")));
}

TEST(Urdf, AnInertiaOfNoDensityIsAWarning) {
  const Model model = model_of_urdf(R"(<link name="a"/><link name="b"><inertial><mass value="1"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="3"/></inertial></link>)" +
                                    joint("j", "continuous", "a", "b"));
  EXPECT_THAT(messages(model), ElementsAre(HasSubstr("no density can produce its inertia")));
}

TEST(Urdf, ShapesKeepWhatIsSaidOfThem) {
  const Model model = model_of_urdf(R"(<link name="a"><visual><origin xyz="1 2 3"/><geometry>
      <mesh filename="package://robot/a.dae" scale="0.001 0.001 0.002"/></geometry><material name="red"/></visual>
      <collision name="hull"><geometry><mesh filename="a.stl"/></geometry></collision>
      <collision><geometry><box size="1 2 3"/></geometry></collision>
      <visual><geometry><capsule radius="1" length="2"/></geometry>
      <material name=""><color rgba="0 1 0 0.5"/></material></visual>
      <visual><geometry><sphere radius="4"/></geometry></visual></link><material name="red"><color rgba="1 0 0 1"/>
      </material>)");
  const auto& shapes = model.description().bodies[0].shapes;
  ASSERT_EQ(shapes.size(), 5U);
  EXPECT_EQ(shapes[0].kind, ShapeKind::mesh);
  EXPECT_EQ(shapes[0].file, "package://robot/a.dae");
  EXPECT_EQ(shapes[0].role, ShapeDescription::Role::visual);
  EXPECT_EQ(shapes[0].pose.r.y, 2);
  EXPECT_EQ(shapes[0].scale.z, 0.002);
  EXPECT_EQ(shapes[0].color, (std::array<double, 4>{1, 0, 0, 1}));  // the file uses the name of this material
                                                                    // before it defines it
  EXPECT_EQ(shapes[1].name, "hull");
  EXPECT_EQ(shapes[1].file, "a.stl");
  EXPECT_EQ(shapes[1].role, ShapeDescription::Role::collision);
  EXPECT_EQ(shapes[1].scale.x, 1);
  EXPECT_FALSE(shapes[1].color);
  EXPECT_EQ(shapes[2].kind, ShapeKind::box);
  EXPECT_EQ(shapes[2].size.y, 2);
  EXPECT_EQ(shapes[3].kind, ShapeKind::capsule);
  EXPECT_EQ(shapes[3].length, 2);
  EXPECT_EQ(shapes[3].color, (std::array<double, 4>{0, 1, 0, 0.5}));
  EXPECT_EQ(shapes[4].radius, 4);
  EXPECT_THAT(messages(model), ElementsAre());
}

TEST(Urdf, ShapesThatNobodyCanDrawAreDoubts) {
  const Model model = model_of_urdf(R"(<link name="a"><visual><geometry><box size="1 1"/></geometry></visual>
      <visual><geometry><sphere/></geometry></visual><collision><geometry><cylinder radius="-1" length="0"/></geometry>
      </collision><visual><geometry><sphere radius="1"/></geometry><material name="m"><color rgba="1 2 3 1"/></material>
      </visual></link><link name="ground"/>)" +
                                    joint("j", "fixed", "ground", "a"));
  ASSERT_EQ(model.description().bodies[0].shapes.size(), 2U);
  EXPECT_THAT(messages(model),
              ElementsAre(HasSubstr("<box> size is \"1 1\"; it needs 3 numbers and has 2; it is ignored"),
                          HasSubstr("<sphere> has no attribute radius"),
                          HasSubstr("the radius of a cylinder is -1 m; it must be positive"),
                          HasSubstr("the length of a cylinder is 0 m; it must be positive"),
                          HasSubstr("the color of a sphere is not between 0 and 1")));
}

TEST(Urdf, EachKindOfUnknownElementIsOneWarningWithItsFirstLine) {
  const Model model = model_of_urdf(R"(<material name="red"><color rgba="1 0 0 1"/></material>
<transmission name="s"/>
<transmission name="t"/>
<gazebo/>
<xacro:include filename="x"/>
<link name="a" colour="red">left over</link>
)");
  EXPECT_THAT(
      messages(model),
      ElementsAre(HasSubstr("test.urdf:3: warning: <transmission>: says nothing about the mechanism and is "
                            "ignored (2 times, first here)"),
                  HasSubstr("test.urdf:5: warning: <gazebo>"),
                  HasSubstr("test.urdf:6: warning: <xacro:include>"), HasSubstr("attribute colour of <link>"),
                  HasSubstr("text in <link>")));
}

TEST(Urdf, SafetyControllerAndCalibrationAreKnown) {
  const Model model =
      model_of_urdf(link("a") + link("b") +
                    joint("j", "continuous", "a", "b",
                          R"(<safety_controller k_velocity="1" k_position="2" soft_lower_limit="0"/>
                                        <calibration rising="0.1"/>)"));
  EXPECT_THAT(messages(model), ElementsAre());
}

TEST(Urdf, TheRootIsFixedSetFreeOrTheGround) {
  const std::string chain = link("a") + link("b") + joint("j", "continuous", "a", "b");
  const Description d = read_urdf_text("<robot name=\"r\">" + chain + "</robot>", "test.urdf");
  EXPECT_EQ(d.bodies[0].joint.name, "fixed_base");
  EXPECT_EQ(ModelBuilder(d).build().n_bodies(), 1);
  const Model free = ModelBuilder(with_free_base(d)).build();
  EXPECT_EQ(free.n_bodies(), 2);
  EXPECT_EQ(free.joint(1).name, "free_base");
  const Model on_ground =
      model_of_urdf("<link name=\"ground\"/>" + link("b") + joint("j", "continuous", "ground", "b"));
  EXPECT_EQ(on_ground.n_frames(), 2);
  EXPECT_EQ(on_ground.body(1).predecessor, 0);
}

TEST(Urdf, ALinkCalledGroundThatIsNoRootHasAnotherName) {
  const std::string names = link("base") + link("ground") + link("ground_2") + link("arm");
  const Model model = model_of_urdf(names + joint("j", "continuous", "base", "ground") +
                                    joint("k", "continuous", "ground", "arm") +
                                    joint("l", "continuous", "ground", "ground_2"));
  EXPECT_EQ(model.body(model.joint_index("j")).name, "ground_3");
  EXPECT_EQ(model.body(model.joint_index("k")).predecessor, model.joint_index("j"));
  EXPECT_EQ(model.body(model.joint_index("l")).name, "ground_2");
  EXPECT_THAT(messages(model),
              ElementsAre(HasSubstr("link \"ground\": is called \"ground_3\" here, where \"ground\" is the "
                                    "inertial frame")));
}

TEST(Urdf, NumbersDoNotDependOnTheLocale) {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale(), new Comma));
  const Model model = model_of_urdf(
      link("a") + link("b") + joint("j", "continuous", "a", "b", R"(<origin xyz="1234.5 +2.25 -1e-3"/>)"));
  const std::string drawing = test::drawing_of(model), urdf = test::urdf_of(model);
  const Model again = ModelBuilder(read_drawing_text(drawing, "again.toml")).build();
  std::locale::global(before);
  EXPECT_EQ(norm(model.body(1).A.r - Vec3<>{1234.5, 2.25, -1e-3}), 0);
  EXPECT_EQ(norm(again.body(1).A.r - Vec3<>{1234.5, 2.25, -1e-3}), 0);
  EXPECT_THAT(drawing, HasSubstr("[1234.5, 2.25, -0.001]"));
  EXPECT_THAT(urdf, HasSubstr("xyz=\"1234.5 2.25 -0.001\""));
}

}  // namespace
}  // namespace axode
