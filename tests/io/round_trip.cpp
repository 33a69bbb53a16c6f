#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <string>

#include "axode/dynamics.hpp"
#include "axode/io.hpp"
#include "axode/io/pose.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/kinds/shape_kinds.hpp"
#include "tests/io/same_mechanism.hpp"
#include "tests/model/random_loops.hpp"
#include "tests/model/random_mechanism.hpp"
#include "tests/support/shared_files.hpp"
#include "tests/support/smallest_failure.hpp"

namespace axode {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double tolerance = 1e-12;

Model read_back(const std::string& drawing) {
  return ModelBuilder(read_drawing_text(drawing, "drawing.toml")).build();
}

void expect_drawing_round_trip(const Model& model) {
  const std::string text = test::drawing_of(model);
  const Model again = read_back(text);
  EXPECT_LT(test::disparity(model, again), tolerance);
  EXPECT_EQ(text, test::drawing_of(again));
}
void expect_same_shapes(const std::vector<ShapeDescription>& one,
                        const std::vector<ShapeDescription>& other) {
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t k = 0; k < one.size(); ++k) {
    EXPECT_EQ(one[k].kind, other[k].kind);
    EXPECT_EQ(one[k].role, other[k].role);
    EXPECT_EQ(one[k].name, other[k].name);
    EXPECT_EQ(one[k].file, other[k].file);
    EXPECT_EQ(one[k].color, other[k].color);
    EXPECT_EQ(one[k].contact.friction, other[k].contact.friction);
    EXPECT_EQ(one[k].contact.spin_friction, other[k].contact.spin_friction);
    EXPECT_EQ(one[k].contact.rolling_friction, other[k].contact.rolling_friction);
    EXPECT_EQ(one[k].contact.restitution, other[k].contact.restitution);
    EXPECT_EQ(one[k].contact.stiffness, other[k].contact.stiffness);
    EXPECT_EQ(one[k].contact.exponent, other[k].contact.exponent);
    EXPECT_EQ(one[k].contact.damping, other[k].contact.damping);
    EXPECT_EQ(one[k].radius, other[k].radius);
    EXPECT_EQ(one[k].length, other[k].length);
    EXPECT_EQ(norm(one[k].size - other[k].size), 0);
    EXPECT_EQ(norm(one[k].scale - other[k].scale), 0);
    EXPECT_LT(norm(one[k].pose.r - other[k].pose.r), tolerance);
    for (const auto axis : {&SO3<>::x, &SO3<>::y, &SO3<>::z})
      EXPECT_LT(norm(one[k].pose.R.*axis - other[k].pose.R.*axis), tolerance);
  }
}
/// Expects the same shapes on bodies of the same name, and on the ground.
void expect_same_shapes(const Description& one, const Description& other) {
  expect_same_shapes(one.shapes, other.shapes);
  for (const BodyDescription& body : one.bodies) {
    const auto same = std::ranges::find(other.bodies, body.name, &BodyDescription::name);
    if (same != other.bodies.end()) {
      expect_same_shapes(body.shapes, same->shapes);
    } else {
      EXPECT_TRUE(body.shapes.empty()) << body.name;
    }
  }
}

void expect_urdf_round_trip(const Model& model) {
  const std::string text = test::urdf_of(model);
  const Model again = ModelBuilder(read_urdf_text(text, "model.urdf")).build();
  EXPECT_LT(test::disparity(model, again, test::Compare::named_frames), tolerance);
  expect_same_shapes(model.description(), again.description());
  EXPECT_LT(test::disparity(again, ModelBuilder(read_urdf_text(test::urdf_of(again), "again.urdf")).build()),
            tolerance);
}

ShapeDescription random_shape(test::Random<double>& random) {
  ShapeDescription shape{
      .role = ShapeDescription::Role::collision, .kind = ShapeKind::mesh, .pose = random.pose()};
  if (random.number(0, 1) < 0.3) {
    shape.file = "a \"b\"\\c.stl", shape.scale = {1, 2, 3};
    return shape;
  }
  shape.kind = shape_kinds[static_cast<std::size_t>(random.number(0, 5))].kind;
  shape.role = ShapeDescription::Role::visual;
  shape.name = random.number(0, 1) < 0.5 ? "" : "skin <&>";
  const ShapeTraits& kind = traits(shape.kind);
  if (!kind.size.empty()) shape.size = {random.number(0.1, 1), random.number(0.1, 1), random.number(0.1, 1)};
  if (kind.radius) shape.radius = random.number(0.1, 1);
  if (kind.length) shape.length = random.number(0.1, 1);
  if (random.number(0, 1) < 0.5) shape.color = {random.number(0, 1), 0, random.number(0, 1), 1};
  return shape;
}

/// A random tree with geometry given in all three ways, and with limits, losses, couplings, shapes and
/// frames.
Description random_description(std::uint64_t seed) {
  test::Random<double> random(seed);
  const int n = static_cast<int>(random.number(1, 25));
  Description tree = test::random_tree(random, n, test::all_kinds);
  tree =
      test::described(tree, random, [&](std::size_t) { return static_cast<test::Way>(random.number(0, 3)); });
  std::string leader;
  for (BodyDescription& body : tree.bodies) {
    const JointKind kind = body.joint.kind;
    const bool one_dof =
        kind == JointKind::revolute || kind == JointKind::prismatic || kind == JointKind::helical;
    if (one_dof && random.number(0, 1) < 0.6) {
      body.joint.dof = {Dof{.lower = -random.number(0, 3),
                            .upper = random.number(0, 3),
                            .velocity = random.number(1, 2),
                            .effort = random.number(1, 100),
                            .damping = random.number(0, 1),
                            .friction = random.number(0, 1),
                            .armature = random.number(0, 1)}};
      if (random.number(0, 1) < 0.5)
        body.joint.dof[0].stiffness = random.number(0, 9), body.joint.dof[0].rest = random.number(-1, 1);
      if (random.number(0, 1) < 0.5)
        body.joint.dof[0].stop_stiffness = 1e4, body.joint.dof[0].stop_damping = random.number(0, 1);
      if (!leader.empty() && random.number(0, 1) < 0.4)
        body.joint.coupling = Coupling{leader, random.number(-2, 2), random.number(-1, 1)};
      leader = body.joint.name;
    }
    if (kind == JointKind::planar || kind == JointKind::spherical)
      body.joint.dof = {Dof{.velocity = 1}, Dof{.lower = -1},
                        Dof{.upper = 2, .damping = 0.1, .stiffness = 0.3}};
    if (random.number(0, 1) < 0.2) body.inertia.reset();
    if (body.inertia && random.number(0, 1) < 0.3) {
      body.inertia->axes = random.rotation();
      body.inertia->in = random.number(0, 1) < 0.5 ? GivenIn::body_frame : GivenIn::construction_frame;
    }
    if (body.inertia && random.number(0, 1) < 0.3) {
      const Vec3<>& c = body.inertia->com;
      body.inertia->about = InertiaAbout::frame_origin;
      body.inertia->axes = {};
      body.inertia->Theta = body.inertia->Theta + (0.5 * body.inertia->mass) * parallel_axis_tensor(c, c);
    }
    if (random.number(0, 1) < 0.4) body.shapes.push_back(random_shape(random));
  }
  for (int k = 0; k < 3; ++k) {
    const auto carrier = static_cast<std::size_t>(random.number(0, n));
    tree.frames.push_back(
        {.name = test::numbered('f', k),
         .body = k == 0 ? "ground" : tree.bodies[carrier].name,
         .pose = random.pose(),
         .in = random.number(0, 1) < 0.5 ? GivenIn::body_frame : GivenIn::construction_frame});
  }
  if (random.number(0, 1) < 0.2) tree.shapes.push_back(random_shape(random));
  for (int k = 0; k < 3; ++k)
    tree.springs.push_back(
        {.between = {tree.bodies[static_cast<std::size_t>(random.number(0, n))].name, test::numbered('f', k)},
         .points = {k == 0 ? Vec3<>{} : random.vector(), k == 0 ? Vec3<>{} : random.vector()},
         .in = k < 2 ? GivenIn::body_frame : GivenIn::construction_frame,
         .stiffness = k == 1 ? 0 : random.number(0, 100),
         .rest = random.number(0, 1),
         .damping = random.number(0, 1)});
  return tree;
}

TEST(RoundTrip, ADrawingOfARandomTreeIsTheSameMechanismAndTheSameTextAgain) {
  test::for_seeds(100, [&](std::uint64_t seed) {
    expect_drawing_round_trip(ModelBuilder(random_description(seed)).build());
  });
}

TEST(RoundTrip, ADrawingOfRandomLoopsIsTheSameMechanismAndTheSameTextAgain) {
  test::for_seeds(100, [&](std::uint64_t seed) {
    test::Random<double> random(seed);
    expect_drawing_round_trip(ModelBuilder(test::with_loops(random_description(seed), random)).build());
  });
}

TEST(RoundTrip, LoopsInJointFramesAreTheSameMechanism) {
  test::for_seeds(100, [&](std::uint64_t seed) {
    test::Random<double> random(seed);
    const Model model = ModelBuilder(test::with_loops(random_description(seed), random)).build();
    EXPECT_LT(test::disparity(model, ModelBuilder(in_joint_frames(model.description())).build()), tolerance);
  });
}

TEST(RoundTrip, AUrdfOfARandomTreeIsTheSameMechanism) {
  constexpr std::array kinds{JointKind::fixed,       JointKind::revolute,  JointKind::prismatic,
                             JointKind::cylindrical, JointKind::universal, JointKind::planar,
                             JointKind::free};
  test::for_seeds(100, [&](std::uint64_t seed) {
    test::Random<double> random(seed);
    Description tree = test::random_tree(random, static_cast<int>(random.number(1, 25)), kinds);
    tree.gravity = {0, 0, -9.81};
    for (BodyDescription& body : tree.bodies)
      if (body.joint.kind == JointKind::revolute || body.joint.kind == JointKind::prismatic) {
        if (random.number(0, 1) < 0.5) body.joint.dof = {Dof{.lower = -1, .effort = 3, .damping = 0.2}};
        if (random.number(0, 1) < 0.3) body.joint.dof = {Dof{.velocity = 3}};
      }
    for (BodyDescription& body : tree.bodies) {
      const ShapeDescription shape = random_shape(random);
      if (traits(shape.kind).in_urdf) body.shapes.push_back(shape);
    }
    tree.frames.push_back({.name = "tool", .body = tree.bodies.back().name, .pose = random.pose()});
    expect_urdf_round_trip(ModelBuilder(tree).build());
  });
}

/// Where the pitch is a quarter turn, roll and yaw turn about one
/// line, and their sines and cosines are lost in the third column.
TEST(RoundTrip, RotationsByAQuarterTurnOfPitchKeepTheirAngles) {
  for (const double side : {-1.0, 1.0})
    for (const double angle : {-2.5, -0.4, 0.0, 1.0, 3.0}) {
      const double s = std::sin(angle), c = std::cos(angle);
      const SO3<> R{{0, 0, -side}, {s, c, 0}, {side * c, -side * s, 0}};
      const SO3<> again = io::from_roll_pitch_yaw(io::to_roll_pitch_yaw(R));
      for (const Vec3<>& difference : {R.x - again.x, R.y - again.y, R.z - again.z})
        EXPECT_LT(norm(difference), 1e-15) << angle;
    }
}

TEST(RoundTrip, AUrdfOfRandomLoopsIsTheSameMechanism) {
  constexpr std::array kinds{JointKind::fixed, JointKind::revolute, JointKind::prismatic, JointKind::planar};
  std::size_t loops = 0;
  test::for_seeds(100, [&](std::uint64_t seed) {
    test::Random<double> random(seed);
    Description tree = test::random_tree(random, static_cast<int>(random.number(1, 9)), kinds);
    tree.gravity = {0, 0, -9.81};
    tree = test::with_loops(tree, random);
    tree.couplings.clear();
    for (BodyDescription& body : tree.bodies) body.joint.passive = false;
    std::erase_if(tree.loops, [](const LoopDescription& loop) {
      return std::ranges::any_of(std::array{"pitch", "angle", "length", "radius", "radii"},
                                 [&](const char* size) { return traits(loop.kind).has(size); });
    });
    loops += tree.loops.size();
    expect_urdf_round_trip(ModelBuilder(tree).build());
  });
  EXPECT_GT(loops, 100U);
}

TEST(RoundTrip, ADrawingKeepsWhatIsInTheConstructionFrameToTheLastBit) {
  const Model model =
      ModelBuilder("exact")
          .add(BodyDescription{.name = "a",
                               .joint = {.name = "j",
                                         .kind = JointKind::helical,
                                         .axis = {0.1, 0.2, 0.30000000000000004},
                                         .point = {1.0 / 3, 2.0 / 3, 1e-17},
                                         .pitch = 5e-324},
                               .inertia = MassProperties{.mass = 0.1,
                                                         .com = {1e22, 0.7, -0.1},
                                                         .Theta = {1. / 7, 1. / 7, 1. / 7, 1e-9, 0, 0},
                                                         .in = GivenIn::construction_frame}})
          .build();
  const BodyDescription& body = model.description().bodies[0];
  const Description again = read_drawing_text(test::drawing_of(model), "exact.toml");
  EXPECT_EQ(norm(again.bodies[0].joint.axis - body.joint.axis), 0);
  EXPECT_EQ(norm(again.bodies[0].joint.point - body.joint.point), 0);
  EXPECT_EQ(again.bodies[0].joint.pitch, body.joint.pitch);
  EXPECT_EQ(norm(again.bodies[0].inertia->com - body.inertia->com), 0);
  EXPECT_EQ(again.bodies[0].inertia->Theta.xy, body.inertia->Theta.xy);
}

TEST(RoundTrip, ExamplesAndGoodFiles) {
  const std::filesystem::path root(AXODE_SOURCE_DIR);
  int count = 0;
  for (const char* folder : {"examples/robots", "tests/data/good"})
    for (const auto& entry : std::filesystem::directory_iterator(root / folder)) {
      SCOPED_TRACE(entry.path().filename().string());
      const Model model = load(entry.path());
      EXPECT_EQ(model.warnings().size(), 0U);
      expect_drawing_round_trip(model);
      ++count;
    }
  EXPECT_GE(count, 6);
}

TEST(RoundTrip, ContactIsReadAndWritten) {
  const Model model = load(std::filesystem::path(AXODE_SOURCE_DIR) / "tests/data/good/contact.toml");
  const Description& d = model.description();
  ASSERT_TRUE(d.contact);
  EXPECT_EQ(d.contact->friction, 0.4);
  EXPECT_EQ(d.contact->margin, 0.005);
  EXPECT_EQ(d.contact->threshold, 0.02);
  EXPECT_THAT(d.contact->ignored, testing::ElementsAre(std::array<std::string, 2>{"puck", "ground"}));
  EXPECT_EQ(d.shapes[0].kind, ShapeKind::plane);
  EXPECT_EQ(d.shapes[0].contact.friction, 0.0);
  EXPECT_EQ(d.bodies[0].shapes[0].contact.spin_friction, 0.002);
  EXPECT_FALSE(d.bodies[1].shapes[0].contact.friction);
  EXPECT_TRUE(d.bodies[0].joint.dof[0].hard_stops);
  EXPECT_EQ(d.bodies[0].joint.dof[0].restitution, 0.3);
  const Model again = read_back(test::drawing_of(model));
  expect_same_shapes(d, again.description());
  EXPECT_TRUE(again.description().bodies[0].joint.dof[0].hard_stops);
  EXPECT_EQ(again.description().bodies[0].joint.dof[0].restitution, 0.3);
  EXPECT_EQ(again.description().contact->ignored, d.contact->ignored);
  EXPECT_EQ(again.description().contact->margin, 0.005);
}

TEST(RoundTrip, AHumanoidWithAFreeBase) {
  const auto file = std::filesystem::path(AXODE_SOURCE_DIR) / "examples/robots/humanoid.urdf";
  const Model model = load(file, Base::free);
  expect_drawing_round_trip(model);
  expect_urdf_round_trip(model);
  EXPECT_EQ(model.nv(), 31 + 6);
  EXPECT_NEAR(model.total_mass(), 75, 1e-3);
}

TEST(RoundTrip, UrdfOfAnArmIsTheArm) {
  expect_urdf_round_trip(load(std::filesystem::path(AXODE_SOURCE_DIR) / "examples/robots/arm7.toml"));
}

TEST(Writers, AStrictUrdfNamesEverythingItCannotSayAndWritesNothing) {
  const Model model = load(std::filesystem::path(AXODE_SOURCE_DIR) / "tests/data/good/every_key.toml");
  std::ostringstream out;
  try {
    write_urdf(model, out, Strictness::strict);
    FAIL() << "written";
  } catch (const ModelError& error) {
    for (const char* part :
         {"gravity: is (0 0 -1.62)", "joint \"screw\": is helical", "joint \"ball\": is spherical",
          "joint \"turn\": has an armature of 0.7", "joint \"turn\": has a gear with losses",
          "joint \"turn\": has a spring", "joint \"turn\": has elastic stops",
          "spring 3: is between \"ghost\" and \"knob\"", "is rod; URDF has no word for it",
          "\": is passive; URDF has no word for it",
          "coupling \"coupling 1\": is one of the coordinates of 2 joints",
          "joint \"stage\": has several degrees"})
      EXPECT_THAT(error.what(), HasSubstr(part));
    EXPECT_THAT(error.what(), Not(HasSubstr("cardan")));
  }
  EXPECT_EQ(out.str(), "");
}

TEST(Writers, ContactThatAFormatCannotSayIsLeftOutByName) {
  const Model model = load(std::filesystem::path(AXODE_SOURCE_DIR) / "tests/data/good/contact.toml");
  const auto left_out = [](const std::vector<Fault>& faults) {
    std::string all;
    for (const Fault& fault : faults) all += fault.element + ": " + fault.message + "\n";
    return all;
  };
  std::ostringstream urdf, mjcf;
  const std::string by_urdf = left_out(write_urdf(model, urdf)), by_mjcf = left_out(write_mjcf(model, mjcf));
  for (const char* part : {"the ground: has a shape that is a plane",
                           "body \"finger\": has a shape with friction, restitution or stiffness",
                           "joint \"finger_joint\": has hard stops", "contact: has friction"})
    EXPECT_THAT(by_urdf, HasSubstr(part));
  for (const char* part :
       {"body \"finger\": has a shape with the restitution 0.25", "joint \"finger_joint\": has hard stops",
        "contact: has a margin and a threshold", "contact: ignores bodies \"puck\" and \"ground\""})
    EXPECT_THAT(by_mjcf, HasSubstr(part));
  for (const char* part : {"type=\"plane\" size=\"0 0 1\"", "friction=\"0 0 0\"",
                           "friction=\"0.9 0.002 0.001\" condim=\"6\"", "friction=\"0.4 0 0\""})
    EXPECT_THAT(mjcf.str(), HasSubstr(part));
}

TEST(Writers, WhatAUrdfCannotSayIsLeftOutWithAWarningAndTheRestIsWritten) {
  Description described;
  const MassProperties matter{.mass = 2, .com = {0.1, 0, 0}, .Theta = {1, 1, 1}};
  described.bodies = {
      {.name = "bar",
       .joint = {.name = "hinge",
                 .kind = JointKind::revolute,
                 .dof = {{.lower = -1, .upper = 1, .damping = 2, .armature = 3, .stiffness = 4}},
                 .passive = true},
       .inertia = matter,
       .shapes = {{.kind = ShapeKind::ellipsoid, .size = {1, 2, 3}},
                  {.kind = ShapeKind::sphere, .radius = 1}}},
      {.name = "puck",
       .joint = {.name = "table",
                 .kind = JointKind::planar,
                 .dof = {{.damping = 1}, {.damping = 2}, {.damping = 2}}},
       .inertia = matter}};
  described.springs = {{.between = {"bar", "ground"}, .stiffness = 1}};
  described.loops = {
      {.name = "rod", .between = {"bar", "puck"}, .kind = LoopKind::rod, .points = {{{1, 0, 0}, {2, 0, 0}}}},
      {.name = "ball", .between = {"bar", "puck"}, .kind = LoopKind::spherical}};
  described.couplings = {{.name = "gears", .terms = {{"hinge", 1}}}};
  described.gravity = {0, 0, -1.62};
  const Model model = ModelBuilder(described).build();
  std::ostringstream out;
  std::vector<std::string> elements;
  for (const Fault& fault : write_urdf(model, out)) {
    EXPECT_EQ(fault.severity, Severity::warning);
    EXPECT_THAT(fault.message, testing::EndsWith("URDF has no word for it, and it is left out"));
    elements.push_back(fault.element);
  }
  EXPECT_THAT(elements, testing::ElementsAre("gravity", "body \"bar\"", "joint \"hinge\"", "joint \"hinge\"",
                                             "joint \"hinge\"", "joint \"table\"", "spring 1", "loop \"rod\"",
                                             "coupling \"gears\""));

  described.bodies[0].joint.dof[0].armature = described.bodies[0].joint.dof[0].stiffness = 0;
  described.bodies[0].joint.passive = false;
  described.bodies[0].shapes.erase(described.bodies[0].shapes.begin());
  described.bodies[1].joint.dof.clear();
  described.springs.clear(), described.couplings.clear();
  described.loops.erase(described.loops.begin());
  described.gravity = {0, 0, -9.81};
  EXPECT_EQ(out.str(), test::urdf_of(ModelBuilder(described).build()));
  std::ostringstream nothing;
  EXPECT_THROW(write_urdf(model, nothing, Strictness::strict), ModelError);
  EXPECT_EQ(nothing.str(), "");
}

TEST(Writers, ABodyThatNoMatterCanMakeIsWrittenAsItIs) {
  const auto text = R"(<robot name="r"><link name="a"><inertial><mass value="1"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="3"/></inertial></link></robot>)";
  const Model model = ModelBuilder(read_urdf_text(text, "test.urdf")).build();
  ASSERT_EQ(model.warnings().size(), 1U);
  const std::string drawing = test::drawing_of(model);
  const Model again = read_back(drawing);
  EXPECT_EQ(test::disparity(model, again), 0);
  ASSERT_EQ(again.warnings().size(), 1U);
  EXPECT_EQ(again.warnings()[0].message, model.warnings()[0].message);
  EXPECT_THROW(ModelBuilder(read_drawing_text(drawing, "test.toml")).build(Strictness::strict), ModelError);
}

TEST(Writers, AModelWithoutANameIsReadBack) {
  const Model model = ModelBuilder("")
                          .add(BodyDescription{.name = "a", .joint = {.kind = JointKind::revolute}})
                          .add(BodyDescription{.name = "b", .predecessor = "a"})
                          .build();
  EXPECT_EQ(test::disparity(model, read_back(test::drawing_of(model))), 0);
  const Model again = ModelBuilder(read_urdf_text(test::urdf_of(model), "nameless.urdf")).build();
  EXPECT_EQ(again.name(), "");
  EXPECT_EQ(again.warnings().size(), model.warnings().size());  // it moves no mass
  EXPECT_LT(test::disparity(model, again, test::Compare::named_frames), tolerance);
  expect_same_shapes(model.description(), again.description());
}

TEST(Writers, NamesSurviveWhateverTheyHold) {
  const std::string name = "a\"b\\c<d>&é 'f'";
  const Model model =
      ModelBuilder(name)
          .add(BodyDescription{.name = name + "1", .joint = {.name = name, .kind = JointKind::revolute}})
          .add(FrameDescription{.name = name + "2", .body = name + "1"})
          .build();
  EXPECT_LT(test::disparity(model, read_back(test::drawing_of(model))), tolerance);
  const Model again = ModelBuilder(read_urdf_text(test::urdf_of(model), "test.urdf")).build();
  EXPECT_LT(test::disparity(model, again, test::Compare::named_frames), tolerance);
  expect_same_shapes(model.description(), again.description());
}

TEST(Writers, UrdfInventsNamesThatNobodyHas) {
  const Model model =
      ModelBuilder("names")
          .add(BodyDescription{.name = "a", .joint = {.name = "fixed_base"}})
          .add(BodyDescription{.name = "j_frame",
                               .predecessor = "a",
                               .joint = {.name = "j", .kind = JointKind::revolute, .point = {1, 0, 0}}})
          .add(BodyDescription{.name = "b",
                               .predecessor = "a",
                               .joint = {.name = "j_frame__to_j_frame", .kind = JointKind::revolute}})
          .add(BodyDescription{
              .name = "c", .predecessor = "b", .joint = {.name = "f_joint", .kind = JointKind::revolute}})
          .add(FrameDescription{.name = "f", .body = "a"})
          .build();
  const Model again = ModelBuilder(read_urdf_text(test::urdf_of(model), "names.urdf")).build();
  EXPECT_LT(test::disparity(model, again, test::Compare::named_frames), tolerance);
  expect_same_shapes(model.description(), again.description());
}

TEST(Load, TellsTheFormatByExtensionAndContent) {
  const auto folder = std::filesystem::temp_directory_path() / "axode_test_load";
  std::filesystem::create_directories(folder);
  const std::string urdf = "<robot name=\"robot\"><link name=\"a\"/></robot>", mark = "\xEF\xBB\xBF";
  const std::string drawing = "name = \"drawing\"\nformat = \"axode drawing 1\"\n";
  const auto name_of = [&](const char* file, const std::string& text) {
    std::ofstream(folder / file) << text;
    return load(folder / file).name();
  };
  EXPECT_EQ(name_of("a.urdf", urdf), "robot");
  EXPECT_EQ(name_of("a.xml", urdf), "robot");
  EXPECT_EQ(name_of("a", mark + "\n" + urdf), "robot");
  EXPECT_EQ(name_of("a.txt", drawing), "drawing");
  EXPECT_EQ(name_of("a.toml", mark + drawing), "drawing");
  const std::string sdf = "<sdf version=\"1.9\"><model name=\"stone\"><link name=\"a\"/></model></sdf>";
  for (const char* file : {"a.sdf", "a.world", "a.xml", "a.txt"})
    EXPECT_EQ(name_of(file, "<?xml version=\"1.0\"?><!-- <robot> -->" + sdf), "stone") << file;
  try {
    name_of("a.xml", "\n<mujoco/>");
    ADD_FAILURE() << "MJCF is read";
  } catch (const ModelError& error) {
    EXPECT_EQ(error.faults()[0].source.line, 2);
    EXPECT_THAT(error.what(), HasSubstr("the file is MJCF, which is read by MuJoCo itself"));
  }
  std::filesystem::remove_all(folder);
}

TEST(Load, TheBaseIsHeldAsAsked) {
  const auto examples = std::filesystem::path(AXODE_SOURCE_DIR) / "examples/robots";
  const auto kind_of = [&](Base base, const char* body) {
    const Model model = load(examples / "machine.toml", base);
    const int i = model.frame(model.frame_index(body)).body;
    return i == 0 ? std::string("fixed") : std::string(to_string(model.joint(i).kind));
  };
  EXPECT_EQ(kind_of(Base::as_described, "column"), "fixed");
  EXPECT_EQ(kind_of(Base::as_described, "chip"), "free");
  EXPECT_EQ(kind_of(Base::free, "column"), "free");
  EXPECT_EQ(kind_of(Base::fixed, "chip"), "fixed");
  EXPECT_THROW(load(examples / "double_pendulum.toml", Base::free),
               ModelError);  // no body is fixed to the ground
}

TEST(Load, SeveralFreeBodiesAreFixedTogether) {
  Description two{.name = "two"};
  for (const char* name : {"a", "b"})
    two.bodies.push_back(
        {.name = name, .joint = {.name = std::string(name) + " floats", .kind = JointKind::free}});
  two.bodies.push_back(
      {.name = "c", .predecessor = "b", .joint = {.name = "hinge", .kind = JointKind::revolute}});
  const Model model = ModelBuilder(with_fixed_base(two)).build();
  EXPECT_EQ(model.nv(), 1);
  two.bodies.pop_back(), two.bodies.pop_back();
  two.bodies.push_back(
      {.name = "c", .predecessor = "a", .joint = {.name = "fixed_base", .kind = JointKind::revolute}});
  EXPECT_EQ(ModelBuilder(with_fixed_base(two)).build().joint(1).name, "fixed_base");
  two.bodies[0].joint = {};
  two.bodies[1].joint.name = "free_base";
  EXPECT_EQ(ModelBuilder(with_free_base(two)).build().joint(1).name, "free_base_2");
}

/// The URDF files of the project, and those of other projects if they are present.
std::vector<std::filesystem::path> robots() {
  std::vector<std::filesystem::path> files =
      test::files_ending_in(std::filesystem::path(AXODE_SOURCE_DIR) / "examples/robots", ".urdf");
  for (const auto& file : test::files_ending_in(test::robots_folder(), ".urdf")) files.push_back(file);
  return files;
}

/// The mass matrix, and the drive forces of a random motion, as one list of numbers.
std::vector<double> dynamics(const Model& model, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto n = static_cast<std::size_t>(model.nv());
  Workspace<> workspace(model);
  const std::vector<double> q = random_configuration(model, seed);
  std::vector<double> v(n), a(n), result(n * n + n);
  std::uniform_real_distribution<double> between(-1, 1);
  for (double& x : v) x = between(random);
  for (double& x : a) x = between(random);
  mass_matrix(model, workspace, q, std::span(result).first(n * n));
  inverse_dynamics(model, workspace, q, v, a, std::span(result).last(n));
  return result;
}
double difference_of_dynamics(const Model& a, const Model& b) {
  if (a.nq() != b.nq() || a.nv() != b.nv()) return std::numeric_limits<double>::infinity();
  double largest = 0, off = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<double> x = dynamics(a, seed), y = dynamics(b, seed);
    for (std::size_t k = 0; k < x.size(); ++k) {
      largest = std::max(largest, std::abs(x[k]));
      off = std::max(off, std::isnan(y[k]) ? std::numeric_limits<double>::infinity() : std::abs(x[k] - y[k]));
    }
  }
  return off / largest;
}

class Robot : public ::testing::TestWithParam<std::filesystem::path> {};

TEST_P(Robot, IsTheSameAsADrawingAndAsAUrdfWithFixedAndFreeBase) {
  const Model fixed = load(GetParam()), free = load(GetParam(), Base::free);
  EXPECT_EQ(free.nv(), fixed.nv() + 6);
  EXPECT_EQ(free.joint(1).name, "free_base");
  EXPECT_LT(test::disparity(fixed, load(GetParam(), Base::fixed)), tolerance);
  for (const Model& model : {fixed, free}) {
    expect_drawing_round_trip(model);
    expect_urdf_round_trip(model);
    EXPECT_LT(difference_of_dynamics(model, read_back(test::drawing_of(model))), 1e-13);
    const Model again = ModelBuilder(read_urdf_text(test::urdf_of(model), "again.urdf")).build();
    EXPECT_LT(difference_of_dynamics(model, again), 1e-13);
  }
}

std::string robot_name(const ::testing::TestParamInfo<std::filesystem::path>& info) {
  std::string name = info.param.stem().string();
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return name;
}
INSTANTIATE_TEST_SUITE_P(RoundTrip, Robot, ::testing::ValuesIn(robots()), robot_name);

}  // namespace
}  // namespace axode
