#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "axode/io.hpp"
#include "axode/kinematics.hpp"
#include "axode/lie/screw_geometry.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/model/building/placement.hpp"
#include "tests/io/same_mechanism.hpp"
#include "tests/support/counted_work.hpp"

namespace axode::sdf_files {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string in_model(const std::string& elements, const std::string& version = "1.9") {
  return "<sdf version=\"" + version + "\"><model name=\"m\">" + elements + "</model></sdf>";
}
Model model_of(const std::string& text) { return ModelBuilder(read_sdf_text(text, "test.sdf")).build(); }

std::string link(const std::string& name, const std::string& inner = "") {
  return "<link name=\"" + name + "\">" + inner +
         "<inertial><pose>0.1 0 0 0 0 0</pose><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz>"
         "</inertia></inertial></link>";
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& inner = "<axis><xyz>0 0 1</xyz></axis>") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent>" + parent + "</parent><child>" + child +
         "</child>" + inner + "</joint>";
}
std::string pose(const std::string& numbers, const std::string& attributes = "") {
  return "<pose " + attributes + ">" + numbers + "</pose>";
}
std::string held(const std::string& link) { return joint("hold " + link, "fixed", "world", link, ""); }

SE3<> at_zero(const Model& model, const std::string& frame) { return test::frames_at_zero(model).at(frame); }
SO3<> turn(double x, double y, double z) { return exp_SO3(Vec3<>{x, y, z}); }

std::vector<std::string> messages(const Model& model) {
  std::vector<std::string> all;
  for (const Fault& fault : model.warnings()) all.push_back(to_string(fault));
  return all;
}

// ---------------------------------------------------------------- the base

TEST(Sdf, ALinkThatNoJointCarriesIsFree) {
  const Model model =
      model_of(in_model(pose("1 2 3 0 0 0") + link("a") + link("b") + joint("j", "revolute", "a", "b")));
  EXPECT_EQ(model.joint(1).name, "free_base");
  EXPECT_EQ(model.joint(1).kind, Subgroup::free);
  EXPECT_EQ(test::disparity(model.body(1).A, SE3<>{{}, {1, 2, 3}}), 0);
  EXPECT_EQ(model.nv(), 7);
}

TEST(Sdf, AJointToTheWorldHoldsTheBase) {
  const Model model =
      model_of(in_model(link("a") + link("b") + joint("j", "revolute", "a", "b") + held("a")));
  EXPECT_EQ(model.nv(), 1);
  EXPECT_EQ(model.body(1).predecessor, 0);
}

TEST(Sdf, TheBaseIsWhatOneAsksFor) {
  const std::string loose = in_model(link("a") + link("b") + joint("j", "revolute", "a", "b"));
  const Description free = read_sdf_text(loose, "test.sdf");
  EXPECT_EQ(ModelBuilder(with_fixed_base(free)).build().nv(), 1);
  EXPECT_EQ(ModelBuilder(with_free_base(free)).build().nv(), 7);
  const Description fixed = read_sdf_text(
      in_model(link("a") + link("b") + joint("j", "revolute", "a", "b") + held("a")), "test.sdf");
  EXPECT_EQ(ModelBuilder(with_free_base(fixed)).build().nv(), 7);
}

TEST(Sdf, AStaticModelStandsStill) {
  const Model model = model_of(in_model("<static>true</static>" + link("a") + link("b", pose("0 0 1 0 0 0")) +
                                        joint("j", "revolute", "a", "b")));
  EXPECT_EQ(model.nv(), 0);
  EXPECT_EQ(at_zero(model, "b").r.z, 1);
  EXPECT_THAT(messages(model), ElementsAre(HasSubstr("joint of a static model")));
}

TEST(Sdf, WhatStandsStillIsOfTheGround) {
  const std::string floor =
      "<model name='floor'>" + pose("0 0 1 0 0 0") + "<static>1</static>" +
      link("a", "<visual name='v'>" + pose("0 0 2 0 0 0") +
                    "<geometry><sphere><radius>1</radius></sphere></geometry></visual>") +
      "</model>";
  const Description d =
      read_sdf_text("<sdf version='1.9'><world name='w'>" + floor + "<model name='m'>" + link("a") +
                        "</model><joint name='j' type='revolute'><parent>floor::a</parent>"
                        "<child>m::a</child><axis/></joint></world></sdf>",
                    "test.sdf");
  ASSERT_EQ(d.bodies.size(), 1u);
  EXPECT_EQ(d.bodies[0].predecessor, "ground");
  EXPECT_EQ(d.shapes.at(0).pose.r.z, 3);
  EXPECT_EQ(d.frames.at(0).body, "ground");
  const Model loose = model_of("<sdf version='1.9'><world name='w'>" + floor + "<model name='m'>" +
                               link("a") + "</model></world></sdf>");
  EXPECT_EQ(ModelBuilder(with_free_base(loose.description())).build().nv(), 6);
}

// ---------------------------------------------------------------- where things are

TEST(Sdf, PosesAreRelativeToWhatTheyName) {
  const Model model = model_of(in_model(
      link("a", pose("1 0 0 0 0 1.5707963267948966")) + link("b", pose("1 0 0 0 0 0", "relative_to='a'")) +
      "<frame name='f' attached_to='b'>" + pose("0 0 1 0 0 0") + "</frame>" +
      "<frame name='g' attached_to='f'>" + pose("0 0 2 0 0 0", "relative_to='__model__'") + "</frame>" +
      link("c", pose("5 0 0 0 0 0", "relative_to='j'")) +
      joint("j", "revolute", "a", "b", pose("0 0 3 0 0 0", "relative_to='f'") + "<axis/>")));
  EXPECT_LT(norm(at_zero(model, "b").r - Vec3<>{1, 1, 0}), 1e-15);
  EXPECT_LT(norm(at_zero(model, "f").r - Vec3<>{1, 1, 1}), 1e-15);
  EXPECT_LT(norm(at_zero(model, "g").r - Vec3<>{0, 0, 2}), 1e-15);
  EXPECT_LT(norm(at_zero(model, "c").r - Vec3<>{1, 6, 4}), 1e-15);
  EXPECT_EQ(model.frame(model.frame_index("g")).body, model.body_index("b"));
}

TEST(Sdf, RotationsComeInDegreesAndAsQuaternions) {
  const Model model = model_of(in_model(link("a", pose("0 0 0 17 -23 29", "degrees='true'")) +
                                        link("b", pose("0 0 0 0 0.6 0 0.8", "rotation_format='quat_xyzw'")) +
                                        link("c", pose(" \n "))));
  const double unit = std::numbers::pi / 180;
  EXPECT_LT(
      test::disparity(at_zero(model, "a"),
                      SE3<>{turn(0, 0, 29 * unit) * turn(0, -23 * unit, 0) * turn(17 * unit, 0, 0), {}}),
      1e-15);
  EXPECT_LT(test::disparity(at_zero(model, "b"), SE3<>{turn(0, 2 * std::atan2(0.6, 0.8), 0), {}}), 1e-15);
  EXPECT_EQ(test::disparity(at_zero(model, "c"), SE3<>{}), 0);
}

TEST(Sdf, NestedModelsAreNamedByTheirPaths) {
  const Model model = model_of(
      in_model(link("a") + "<model name='n'>" + pose("0 0 1 0 0 0") + link("a", pose("1 0 0 0 0 0")) +
               "<model name='o'>" + pose("0 1 0 0 0 0", "relative_to='a'") + link("a") + "</model>" +
               joint("j", "prismatic", "a", "o::a") + "</model>" + joint("k", "revolute", "a", "n::a")));
  EXPECT_EQ(model.joint(2).name, "k");
  EXPECT_EQ(model.joint(3).name, "n::j");
  EXPECT_EQ(model.body(3).name, "n::o::a");
  EXPECT_LT(norm(at_zero(model, "n::o::a").r - Vec3<>{1, 1, 1}), 1e-15);
}

TEST(Sdf, APlacementFrameIsWhatThePoseOfItsModelIsAbout) {
  const std::string tool = "<frame name='tool' attached_to='b'>" + pose("0 0 1 0 0 1") + "</frame>";
  const Model model =
      model_of("<sdf version='1.9'><model name='m' placement_frame='tool'>" + pose("1 2 3 0 0.5 0") +
               link("a") + link("b", pose("0.3 0.2 0 1 0 0")) + tool + "</model></sdf>");
  EXPECT_LT(test::disparity(at_zero(model, "tool"), SE3<>{turn(0, 0.5, 0), {1, 2, 3}}), 1e-15);
}

TEST(Sdf, ModelsOfAWorldAreNamedApart) {
  const Model model =
      model_of("<sdf version='1.9'><world name='w'><gravity>0 0 -1.6</gravity><model name='m'>" + link("a") +
               held("a") + "</model><model name='n'>" + link("a") + "</model></world></sdf>");
  EXPECT_EQ(model.name(), "w");
  EXPECT_EQ(model.gravity().z, -1.6);
  EXPECT_EQ(model.body(1).name, "n::a");
  EXPECT_EQ(model.frame(model.frame_index("m::a")).body, 0);
}

TEST(Sdf, AWorldHasAGravityOfItsOwnAndAModelOurs) {
  EXPECT_EQ(
      model_of("<sdf version='1.9'><world name='w'><model name='m'>" + link("a") + "</model></world></sdf>")
          .gravity()
          .z,
      -9.8);
  EXPECT_EQ(model_of(in_model(link("a"))).gravity().z, -9.81);
}

// ---------------------------------------------------------------- joints

/// The axis in the world frame of a revolute joint whose child link is turned by 90 degrees about x, in a
/// model that is turned about y.
Vec3<> axis_of(const std::string& version, const std::string& axis) {
  const Model model = model_of(in_model(pose("0 0 0 0 1.5707963267948966 0") + link("a") +
                                            link("b", pose("0 0 0 1.5707963267948966 0 0")) + held("a") +
                                            joint("j", "revolute", "a", "b", "<axis>" + axis + "</axis>"),
                                        version));
  return model.body(1).A.R * model.body(1).X[0].w;
}

TEST(Sdf, AnAxisIsExpressedAsTheVersionSays) {
  const Vec3<> in_joint{0, -1, 0}, in_model_frame{1, 0, 0};
  const std::string z = "<xyz>0 0 1</xyz>";
  EXPECT_LT(norm(axis_of("1.4", z) - in_model_frame), 1e-15);
  EXPECT_LT(norm(axis_of("1.5", z) - in_joint), 1e-15);
  EXPECT_LT(norm(axis_of("1.9", z) - in_joint), 1e-15);
  EXPECT_LT(norm(axis_of("1.6", z + "<use_parent_model_frame>1</use_parent_model_frame>") - in_model_frame),
            1e-15);
  EXPECT_LT(norm(axis_of("1.4", z + "<use_parent_model_frame>0</use_parent_model_frame>") - in_joint), 1e-15);
  EXPECT_LT(norm(axis_of("1.9", "<xyz expressed_in='a'>0 0 1</xyz>") - in_model_frame), 1e-15);
}

TEST(Sdf, WhatAnAxisSaysIsKept) {
  const Model model = model_of(in_model(
      link("a") + link("b") + held("a") +
      joint(
          "j", "revolute", "a", "b",
          "<axis><xyz>0 2 0</xyz><limit><lower>-1</lower><upper>1e16</upper><effort>-1</effort>"
          "<velocity>3</velocity></limit><dynamics><damping>4</damping><friction>5</friction>"
          "<spring_stiffness>6</spring_stiffness><spring_reference>7</spring_reference></dynamics></axis>")));
  EXPECT_TRUE(test::same(model.joint(1).dof[0], Dof{-1, infinity, 3, infinity, 4, 5, 0, 6, 7}));
  EXPECT_THAT(messages(model), ElementsAre());
}

TEST(Sdf, ThreadsHaveAPitchInMetresForEachTurnAndAnOlderOneInRadiansForEachMetre) {
  const auto pitch = [](const std::string& thread) {
    return model_of(in_model(link("a") + link("b") + held("a") +
                             joint("j", "screw", "a", "b", "<axis/>" + thread)))
        .joint(1)
        .pitch;
  };
  EXPECT_DOUBLE_EQ(pitch("<screw_thread_pitch>0.5</screw_thread_pitch>"), 0.5 / (2 * std::numbers::pi));
  EXPECT_DOUBLE_EQ(pitch("<thread_pitch>4</thread_pitch>"), -0.25);
  EXPECT_DOUBLE_EQ(pitch(""), 1 / (2 * std::numbers::pi));
}

TEST(Sdf, JointsOfSeveralDegreesOfFreedomBecomeOurs) {
  const std::string axes = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>";
  const Model model = model_of(in_model(
      link("a") + link("b") + link("c") + link("d") + held("a") + joint("u", "universal", "a", "b", axes) +
      joint("s", "ball", "b", "c", "") + joint("r", "revolute2", "c", "d", axes)));
  std::vector<std::string> kinds;
  for (const Joint& j : model.joints()) kinds.push_back(j.name + " " + std::string(to_string(j.kind)));
  EXPECT_THAT(kinds, ElementsAre("u.first revolute", "u.second revolute", "s spherical", "r.first revolute",
                                 "r.second revolute"));
  EXPECT_EQ(norm(model.body(2).X[0].w - Vec3<>{0, 1, 0}), 0);
}

TEST(Sdf, AMimicFollows) {
  const std::string follows =
      "<axis><xyz>0 0 1</xyz><mimic joint='j' axis='axis'><multiplier>2</multiplier>"
      "<offset>0.5</offset><reference>0.1</reference></mimic></axis>";
  const Model model =
      model_of(in_model(link("a") + link("b") + link("c") + held("a") + joint("j", "revolute", "a", "b") +
                            joint("k", "prismatic", "b", "c", follows),
                        "1.11"));
  EXPECT_EQ(model.nq(), 1);
  EXPECT_EQ(model.joint(2).leader->ratio, 2);
  EXPECT_DOUBLE_EQ(model.joint(2).leader->offset, 0.3);
}

TEST(Sdf, AnAxisOfTwoThatFollowsIsACoupling) {
  const Model model = model_of(
      in_model(link("a") + link("b") + link("c") + held("a") +
               joint("u", "universal", "a", "b",
                     "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz><mimic joint='j'/></axis2>") +
               joint("j", "revolute", "b", "c", "<axis/>")));
  ASSERT_EQ(model.description().couplings.size(), 1u);
  EXPECT_THAT(
      model.description().couplings[0].terms,
      UnorderedElementsAre(std::pair{std::string("u.second"), 1.0}, std::pair{std::string("j"), -1.0}));
}

TEST(Sdf, AGearboxCouplesTheAnglesAgainstItsReference) {
  const auto terms = [](const std::string& one, const std::string& other) {
    const Model model = model_of(in_model(
        link("frame") + link("a") + link("b") + held("frame") + one + other +
        joint("g", "gearbox", "a", "b",
              "<axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 0 2</xyz></axis2><gearbox_ratio>3</gearbox_ratio>"
              "<gearbox_reference_body>frame</gearbox_reference_body>")));
    return model.description().couplings.at(0).terms;
  };
  const std::string down = "<axis><xyz>0 0 -1</xyz></axis>";
  using ::testing::Pair;
  EXPECT_THAT(terms(joint("j", "revolute", "frame", "a"), joint("k", "continuous", "frame", "b")),
              ElementsAre(Pair("j", 3), Pair("k", 1)));
  EXPECT_THAT(terms(joint("j", "revolute", "frame", "a", down), joint("k", "revolute", "frame", "b")),
              ElementsAre(Pair("j", -3), Pair("k", 1)));
}

TEST(Sdf, AGearOfAHingeThatIsToldFromTheOtherSideTurnsTheOtherWay) {
  const Model model = model_of(in_model(
      link("frame") + link("a") + link("b") + held("frame") + joint("j", "revolute", "a", "frame") +
      joint("k", "revolute", "frame", "b") +
      joint("g", "gearbox", "a", "b",
            "<axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 0 1</xyz></axis2><gearbox_ratio>3</gearbox_ratio>"
            "<gearbox_reference_body>frame</gearbox_reference_body>")));
  EXPECT_EQ(model.description().couplings.at(0).terms[0].second, -3);
}

// ---------------------------------------------------------------- loops and joints that are turned round

TEST(Sdf, TheLastJointOfALoopClosesIt) {
  const std::string y = "<axis><xyz>0 1 0</xyz></axis>";
  const Model model = model_of(in_model(
      link("crank") + link("coupler", pose("0 0 1 0 0 0")) + link("rocker", pose("2 0 0 0 0 0")) +
      joint("one", "revolute", "world", "crank", y) + joint("two", "revolute", "crank", "coupler", y) +
      joint("three", "revolute", "world", "rocker", y) +
      joint("pin", "revolute", "coupler", "rocker", pose("0 0 1 0 0 0") + y)));
  const Model drawn =
      ModelBuilder("m")
          .add({.name = "crank",
                .joint = {.name = "one", .kind = JointKind::revolute, .axis = {0, 1, 0}},
                .geometry = InBodyFrame{},
                .inertia = MassProperties{1, {0.1, 0, 0}, {1, 1, 1, 0, 0, 0}}})
          .add({.name = "coupler",
                .predecessor = "crank",
                .joint = {.name = "two", .kind = JointKind::revolute, .axis = {0, 1, 0}},
                .geometry = InBodyFrame{{{}, {0, 0, 1}}},
                .inertia = MassProperties{1, {0.1, 0, 0}, {1, 1, 1, 0, 0, 0}}})
          .add({.name = "rocker",
                .joint = {.name = "three", .kind = JointKind::revolute, .axis = {0, 1, 0}},
                .geometry = InBodyFrame{{{}, {2, 0, 0}}},
                .inertia = MassProperties{1, {0.1, 0, 0}, {1, 1, 1, 0, 0, 0}}})
          .add(LoopDescription{
              .name = "pin", .between = {"coupler", "rocker"}, .axis = {0, 1, 0}, .point = {2, 0, 1}})
          .build();
  EXPECT_EQ(model.loops().all.size(), 1u);
  EXPECT_LT(test::disparity(model, drawn), 1e-15);
}

TEST(Sdf, AJointIsTurnedRoundWhereOnlySoALinkIsReached) {
  const std::string universal = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>",
                    where = pose("0.1 0.2 0.3 0.4 0.5 0.6"), b = link("b", pose("1 2 3 0.3 0.2 0.1"));
  for (const std::string type : {"revolute", "prismatic", "screw", "universal"}) {
    const std::string axes = where + (type == "universal" ? universal : "<axis><xyz>1 2 2</xyz></axis>");
    const Model there = model_of(in_model(link("a") + b + held("a") + joint("j", type, "a", "b", axes)));
    const Model back = model_of(in_model(link("a") + b + held("b") + joint("j", type, "a", "b", axes)));
    ASSERT_EQ(there.nq(), back.nq());
    std::vector<double> q = type == "universal" ? std::vector{0.7, -0.4} : std::vector{0.7};
    const auto b_in_a = [](const Model& model, const std::vector<double>& at) {
      Workspace<> workspace(model);
      std::vector<SE3<>> C(model.n_frames());
      poses(model, workspace, at, C);
      return relative(C[model.frame_index("a")], C[model.frame_index("b")]);
    };
    const SE3<> expected = b_in_a(there, q);
    std::ranges::reverse(q);
    EXPECT_LT(test::disparity(b_in_a(back, q), expected), 1e-14) << type;
  }
}

// ---------------------------------------------------------------- matter and shapes

TEST(Sdf, MatterIsGivenInItsOwnFrame) {
  const Model model = model_of(
      in_model("<link name='a'><inertial>" + pose("1 2 3 0 0 1.5707963267948966") +
               "<mass>2</mass><inertia><ixx>1</ixx><iyy>2</iyy><izz>2.5</izz></inertia></inertial></link>"));
  const Inertia<> expected = inertia_from_com(2.0, Vec3<>{1, 2, 3}, Sym3<>{2, 1, 2.5, 0, 0, 0});
  EXPECT_LT(test::disparity(model.body(1).M, expected), 1e-15);
}

TEST(Sdf, MatterThatIsNotSaidIsThatOfTheFormat) {
  const Model model = model_of(in_model("<link name='a'/><link name='b'><inertial/></link>"));
  for (const int i : {1, 2}) {
    EXPECT_EQ(model.body(i).M.m, 1);
    EXPECT_EQ(model.body(i).M.Theta.yy, 1);
  }
  EXPECT_THAT(messages(model),
              ElementsAre(HasSubstr("<inertial> has no <mass>"), HasSubstr("<inertial> has no <inertia>"),
                          HasSubstr("<link>: has no <inertial>")));
}

TEST(Sdf, ShapesAreKept) {
  const auto shape = [](const std::string& geometry, const std::string& more = "") {
    return "<visual name='v'>" + more + "<geometry>" + geometry + "</geometry></visual>";
  };
  const Model model = model_of(in_model(
      link(
          "a",
          pose("1 0 0 0 0 0") +
              shape("<box><size>1 2 3</size></box>", pose("0 0 1 0 0 0", "relative_to='b'")) +
              shape("<sphere><radius>1</radius></sphere>",
                    "<transparency>0.5</transparency><material><diffuse>0.1 0.2 0.3</diffuse></material>") +
              shape("<cylinder><radius>1</radius><length>2</length></cylinder>") +
              shape("<capsule><radius>1</radius><length>2</length></capsule>") +
              shape("<ellipsoid><radii>1 2 3</radii></ellipsoid>") +
              shape("<mesh><uri>model://a/b.stl</uri><scale>1 2 3</scale></mesh>") +
              "<collision name='c'><geometry><plane><normal>0 2 0</normal><size>1 1</size></plane></geometry>"
              "<surface><friction><ode><mu>0.7</mu></ode></friction>"
              "<bounce><restitution_coefficient>0.2</restitution_coefficient></bounce></surface></collision>"
              "<collision name='d'><geometry><polyline/></geometry></collision>") +
      link("b")));
  const std::vector<ShapeDescription>& shapes = model.description().bodies[0].shapes;
  std::vector<ShapeKind> kinds;
  for (const ShapeDescription& s : shapes) kinds.push_back(s.kind);
  EXPECT_THAT(kinds, ElementsAre(ShapeKind::box, ShapeKind::sphere, ShapeKind::cylinder, ShapeKind::capsule,
                                 ShapeKind::ellipsoid, ShapeKind::mesh, ShapeKind::plane));
  EXPECT_EQ(norm(shapes[0].pose.r - Vec3<>{-1, 0, 1}), 0);
  EXPECT_THAT(*shapes[1].color, ElementsAre(0.1, 0.2, 0.3, 0.5));
  EXPECT_EQ(shapes[3].length, 2);
  EXPECT_EQ(norm(shapes[4].size - Vec3<>{1, 2, 3}), 0);
  EXPECT_EQ(shapes[5].file, "model://a/b.stl");
  EXPECT_EQ(shapes[5].scale.z, 3);
  EXPECT_NEAR(norm(shapes[6].pose.R.z - Vec3<>{0, 1, 0}), 0, 1e-15);
  EXPECT_EQ(*shapes[6].contact.friction, 0.7);
  EXPECT_EQ(shapes[6].contact.restitution, 0.2);
  EXPECT_THAT(messages(model), ElementsAre(HasSubstr("<polyline>")));
}

TEST(Sdf, WhatIsNotUnderstoodIsNamedOnce) {
  const Model model = model_of(
      "<sdf version='1.9'>\n<world name='w'>\n<include><uri>model://sun</uri></include>\n"
      "<light name='l'/>\n<model name='m'>" +
      link("a", "<sensor name='s'/><sensor name='t'/><drake:mass/>") + "\n<plugin/></model></world></sdf>");
  EXPECT_THAT(
      messages(model),
      UnorderedElementsAre(HasSubstr("test.sdf:3: warning: world: includes \"model://sun\""),
                           HasSubstr("test.sdf:4: warning: <light>"),
                           HasSubstr("<sensor>: says nothing about the mechanism and is ignored (2 times"),
                           HasSubstr("<drake:mass>: belongs to an extension of SDFormat and is ignored"),
                           HasSubstr("test.sdf:6: warning: <plugin>")));
}

TEST(Sdf, LinksWithoutWeightAndKinematicLinksAreNamed) {
  const Model model =
      model_of(in_model(held("a") + link("a", "<gravity>1</gravity><kinematic>0</kinematic>") +
                        link("b", "<gravity>false</gravity>") + link("c", "<kinematic>true</kinematic>")));
  EXPECT_THAT(
      messages(model),
      UnorderedElementsAre(HasSubstr("link \"b\": has no weight in SDFormat; in axode it has one"),
                           HasSubstr("link \"c\": is kinematic in SDFormat; in axode forces move it")));
}

TEST(Sdf, WhatIsCalledGroundHasAnotherName) {
  const Model model = model_of(in_model(held("base") + link("base") + link("ground") + link("ground_2") +
                                        joint("j", "revolute", "base", "ground") +
                                        joint("k", "revolute", "ground", "ground_2")));
  EXPECT_EQ(model.body(model.joint_index("j")).name, "ground_3");
  EXPECT_EQ(model.body(model.joint_index("k")).predecessor, model.joint_index("j"));
  EXPECT_THAT(messages(model), ElementsAre(HasSubstr("\"ground\": is called \"ground_3\" here")));
  const Model of_a_frame = model_of(
      in_model(held("base") + link("base") + "<frame name='ground'>" + pose("1 2 3 0 0 0") + "</frame>"));
  EXPECT_LT(norm(at_zero(of_a_frame, "ground_2").r - Vec3<>{1, 2, 3}), 1e-15);
}

TEST(Sdf, JointsInAnyOrderAreAssembledByWorkInProportionToTheirNumber) {
  test::expect_work_in_proportion_to_size([](int n) {
    const auto name = [](int k) { return "l" + std::to_string(10'000 + k); };
    std::string links, joints;
    for (int k = 0; k < n; ++k) {
      links += link(name(k));
      if (k > 0) joints = joint("of " + name(k), "revolute", name(k / 2), name(k), "<axis/>") + joints;
      if (k % (n / 4) != 0) continue;
      links += joints;
      joints.clear();
    }
    EXPECT_EQ(model_of(in_model(links + joints)).nv(), 6 + n - 1);
  });
}

}  // namespace
}  // namespace axode::sdf_files
