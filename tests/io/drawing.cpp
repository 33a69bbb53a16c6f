#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <numbers>
#include <string>

#include "axode/dynamics.hpp"
#include "axode/io.hpp"
#include "axode/kinematics.hpp"
#include "axode/lie/screw_geometry.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/model/configuration.hpp"
#include "tests/io/same_mechanism.hpp"
#include "tests/support/shared_files.hpp"

namespace axode {
namespace {

using ::testing::HasSubstr;

const std::string format = "format = \"axode drawing 1\"\n";

Model model_of(const std::string& text) {
  return ModelBuilder(read_drawing_text(format + text, "test.toml")).build();
}

TEST(Drawing, AxisPointAndPitchMakeTheJointScrewInTheConstructionFrame) {
  const Model model = model_of(R"(
    [[body]]
    name = "nut"
    joint = { name = "screw", kind = "helical", axis = [0, 3, 4], point = [1, 2, 3], pitch = 0.1 }
    mass = 1
    com = [0, 0, 0]
    inertia = [1, 1, 1])");
  const Screw<> Y = screw(Vec3<>{0, 0.6, 0.8}, Vec3<>{1, 2, 3}, 0.1);
  EXPECT_LT(test::disparity(model.body(1).X[0], Y), 1e-15);
}

TEST(Drawing, ALeadIsAPitchForEachTurn) {
  const std::string body = R"([[body]]
    name = "nut"
    joint = { kind = "helical", axis = "z", point = [0, 0, 0], )";
  EXPECT_DOUBLE_EQ(model_of(body + "lead = 0.005 }").joint(1).pitch, 0.005 / (2 * std::numbers::pi));
  EXPECT_DOUBLE_EQ(model_of(body + "pitch = 0.005 }").joint(1).pitch, 0.005);
}

TEST(Drawing, AnAxisMayBeNamed) {
  for (const auto& [name, axis] : {std::pair{"x", Vec3<>{1, 0, 0}}, std::pair{"-y", Vec3<>{0, -1, 0}},
                                   std::pair{"z", Vec3<>{0, 0, 1}}, std::pair{"-z", Vec3<>{0, 0, -1}}}) {
    const Model model = model_of(
        std::string("[[body]]\nname = \"a\"\njoint = { kind = \"prismatic\", axis = \"") + name + "\" }\n");
    EXPECT_EQ(norm(model.body(1).X[0].v - axis), 0) << name;
  }
}

TEST(Drawing, TheThreeWaysOfPlacingABodyAreOneMechanism) {
  const std::string base = R"(
    [[body]]
    name = "base"
    joint = { name = "turn", kind = "revolute", axis = "z", point = [0.1, 0, 0] }
    A = { position = [0.1, 0, 0.5], rpy = [0, 0, 1.5707963267948966] }
    mass = 2
    com = [0.1, 0, 0.3]
    inertia = [0.3, 0.2, 0.1, 0, 0, 0.01]
    [[body]]
    name = "arm"
    on = "base"
    mass = 1
  )";
  // The arm's frame has its origin in (0.1, 1, 0.5), x along -y of the construction frame, z along its x.
  const Model drawn = model_of(base + R"(
    joint = { name = "swing", kind = "revolute", axis = "x", point = [0, 1, 0.5] }
    A = { position = [0.1, 1, 0.5], rotation = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]] }
    com = [0.1, 0.8, 0.5]
    inertia = [0.04, 0.03, 0.02]
  )");
  const Model in_body_frame = model_of(base + R"(
    joint = { name = "swing", kind = "revolute", axis = "z", point = [0, 0, -0.1] }
    B = { position = [1, 0, 0], rotation = [[-1, 0, 0], [0, 0, -1], [0, -1, 0]] }
    com = [0.2, 0, 0]
    inertia = [0.03, 0.02, 0.04]
  )");
  const Model in_joint_frames = model_of(base + R"(
    joint = { name = "swing", kind = "revolute" }
    S_prev = { position = [1, 0, 0], rotation = [[-1, 0, 0], [0, 0, -1], [0, -1, 0]] }
    com = [0.2, 0, 0]
    inertia = [0.03, 0.02, 0.04]
  )");
  EXPECT_LT(test::disparity(drawn, in_body_frame), 1e-14);
  EXPECT_LT(test::disparity(drawn, in_joint_frames), 1e-14);
}

TEST(Drawing, InertiaMayBeGivenInAnyAxesAndAboutComOrOrigin) {
  const std::string body = R"(
    [[body]]
    name = "a"
    joint = "free"
    A = { position = [0, 0, 2], quaternion = [0, 0, 0.6, 0.8] }
    mass = 2
  )";
  const Model about_com = model_of(body + "com = [0.5, 0, 2]\ninertia = [0.1, 0.2, 0.25, 0.01, 0, 0]\n");
  EXPECT_LT(test::disparity(about_com, model_of(body + R"(
    com = [0.5, 0, 2]
    inertia = [[0.1, 0.01, 0], [0.01, 0.2, 0], [0, 0, 0.25]])")),
            1e-15);
  EXPECT_LT(test::disparity(about_com, model_of(body + R"(
    com = [0.14, -0.48, 0]
    inertia = [0.1, 0.2, 0.25, 0.01, 0, 0]
    inertia_in = "body"
    inertia_axes = { quaternion = [0, 0, -0.6, 0.8] })")),
            1e-15);
  // Θ about the origin of the construction frame: the parallel-axis theorem by hand, m (c·c I - c cᵀ).
  EXPECT_LT(test::disparity(about_com, model_of(body + R"(
    com = [0.5, 0, 2]
    inertia = [8.1, 8.7, 0.75, 0.01, -2, 0]
    inertia_about = "origin")")),
            1e-15);
}

const std::string two_bodies = R"(
    [[body]]
    name = "upper"
    joint = { name = "turn", kind = "revolute", axis = "z", point = [1, 0, 0], limits = [-1, 2] )";
const std::string behind = R"( }
    [[body]]
    name = "fore"
    on = "upper"
    joint = { kind = "spherical", point = [2, 0, 0], dof = [{}, { spring = { stiffness = 4 } }, {}] }
    B = { position = [2, 0, 0] }
    [[frame]]
    name = "tip"
    on = "fore"
    position = [3, 0, 0]
  )";

TEST(Drawing, SpringsAndStopsActOnJointsAndBetweenFrames) {
  const Model model = model_of(
      two_bodies + R"(, spring = { stiffness = 10, rest = 0.5 }, stop = { stiffness = 1e4, damping = 0.3 })" +
      behind + R"(
    [[spring]]
    between = ["tip", "ground"]
    points = [[3, 0.5, 0], [0, 7, 0]]
    stiffness = 20
    rest = 0.1
    damping = 2
    [[spring]]
    between = ["fore", "upper"]
    points = [[0.5, 0, 0], [0.25, 0, 0]]
    in = "body"
    damping = 3
    [[spring]]
    between = ["upper", "tip"]
    stiffness = 1)");
  const Dof& turn = model.joint(1).dof[0];
  EXPECT_EQ(turn.stiffness, 10);
  EXPECT_EQ(turn.rest, 0.5);
  EXPECT_EQ(turn.stop_stiffness, 1e4);
  EXPECT_EQ(turn.stop_damping, 0.3);
  EXPECT_EQ(model.joint(2).dof[1].stiffness, 4);
  EXPECT_EQ(model.springs().joints, (std::vector<int>{1, 2}));
  const auto& springs = model.springs().elements;
  ASSERT_EQ(springs.size(), 3U);
  const auto end = [&](std::size_t k, std::size_t e) {
    return std::get<Spring::Path>(springs[k].geometry).points[e];
  };
  const auto stiffness = [&](std::size_t k) { return std::get<LinearCurve>(springs[k].law.curve).stiffness; };
  EXPECT_EQ(model.frame(end(0, 0).frame).name, "tip");
  EXPECT_LT(norm(end(0, 0).point - Vec3<>{0, 0.5, 0}), 1e-15);
  EXPECT_LT(norm(end(0, 1).point - Vec3<>{0, 7, 0}), 1e-15);
  EXPECT_EQ(stiffness(0), 20);
  EXPECT_EQ(springs[0].law.rest, 0.1);
  EXPECT_EQ(springs[0].law.damping, 2);
  EXPECT_EQ(norm(end(1, 0).point - Vec3<>{0.5, 0, 0}), 0);
  EXPECT_EQ(stiffness(1), 0);
  EXPECT_EQ(norm(end(2, 1).point), 0);

  Workspace<> workspace(model);
  const std::vector<double> q{0, 0, 0, 0, 1};
  const double first = std::hypot(3, 6.5) - 0.1, third = 3;
  EXPECT_NEAR(elastic_energy(model, workspace, q), 0.5 * (10 * 0.25 + 20 * first * first + third * third),
              1e-12);
}

/// A crane far from the origin, with its body frames at the given places.
Model crane(const std::string& column_frame, const std::string& jib_frame) {
  return model_of("[[body]]\nname = \"column\"\n" + column_frame + R"(
    joint = { name = "slew", kind = "revolute", axis = "z", point = [10, 20, 0] }
    mass = 800
    com = [10, 20.1, 1.5]
    inertia = [620, 620, 40]
    [[body]]
    name = "jib"
    on = "column"
    )" + jib_frame +
                  R"(
    joint = { name = "luff", kind = "revolute", axis = [0, -1, 0], point = [10.3, 20, 3] }
    mass = 300
    com = [12.1, 20, 3]
    inertia = [8, 330, 330, 0, 2.5, 0]
    [[frame]]
    name = "hook"
    on = "jib"
    position = [14, 20, 3]
  )");
}

TEST(Drawing, TheFrameOfABodyIsTheConstructionFrameOrAtItsJointOrItsCentreOfMass) {
  const Model drawn = crane("", ""), moved = crane("frame = \"joint\"", "frame = \"com\"");
  EXPECT_EQ(norm(drawn.body(2).A.r), 0);
  EXPECT_EQ(norm(moved.body(1).A.r - Vec3<>{10, 20, 0}), 0);
  EXPECT_EQ(norm(moved.body(2).A.r - Vec3<>{12.1, 20, 3}), 0);
  EXPECT_EQ(norm(center_of_mass(moved.body(2).M)), 0);
  EXPECT_EQ(norm(moved.body(1).X[0].v), 0);  // the axis of its joint passes through the origin of its frame
  EXPECT_EQ(test::disparity(test::frames_at_zero(drawn).at("hook"), test::frames_at_zero(moved).at("hook")),
            0);
  const std::string in_words = "A = { position = [10, 20, 0] }",
                    in_more_words = "A = { position = [12.1, 20, 3] }";
  EXPECT_EQ(test::disparity(moved, crane(in_words, in_more_words)), 0);
  EXPECT_EQ(
      test::disparity(moved, ModelBuilder(read_drawing_text(test::drawing_of(moved), "again.toml")).build()),
      0);
}

TEST(Drawing, PosesAndJacobiansFollowTheFrameOfABodyAndDynamicsDoNot) {
  const Model drawn = crane("", ""), moved = crane("frame = \"joint\"", "frame = \"com\"");
  Workspace<> of_drawn(drawn), of_moved(moved);
  const std::vector<double> q{0.4, 0.7}, v{-0.3, 0.5}, a{1, -2};
  std::vector<SE3<>> C(static_cast<std::size_t>(drawn.n_frames())), D(C.size());
  poses(drawn, of_drawn, q, C), poses(moved, of_moved, q, D);
  std::vector<Twist<BodyFixed>> J(2), K(2);
  for (int i = 1; i <= 2; ++i) {
    const SE3<> shift = inverse(drawn.body(i).A) * moved.body(i).A;
    EXPECT_LT(test::disparity(C[i] * shift, D[i]), 1e-14);
    jacobian<BodyFixed>(drawn, of_drawn, q, i, J), jacobian<BodyFixed>(moved, of_moved, q, i, K);
    for (int k = 0; k < 2; ++k)
      EXPECT_LT(test::disparity(Ad(inverse(shift), Screw<>{J[k].w, J[k].v}), Screw<>{K[k].w, K[k].v}), 1e-13);
  }
  std::vector<double> tau(2), tau_moved(2);
  inverse_dynamics(drawn, of_drawn, q, v, a, tau), inverse_dynamics(moved, of_moved, q, v, a, tau_moved);
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(tau[k], tau_moved[k], 1e-12 * std::abs(tau[k]));
}

TEST(Drawing, AFreeBodyIsAtItsFrame) {
  const std::string body =
      "[[body]]\nname = \"stone\"\njoint = \"free\"\nmass = 2\ncom = [1, 2, 3]\n"
      "inertia = [1, 1, 1]\n";
  const Model model = model_of(body + "frame = \"com\"\n");
  Workspace<> workspace(model);
  std::vector<SE3<>> C(static_cast<std::size_t>(model.n_frames()));
  poses(model, workspace, neutral(model), C);
  EXPECT_EQ(norm(C[1].r - Vec3<>{1, 2, 3}), 0);
  EXPECT_EQ(norm(center_of_mass(model.body(1).M)), 0);
}

TEST(Drawing, RotationsInThreeWaysAreOne) {
  const auto frame = [](const std::string& rotation) {
    return model_of("[[frame]]\nname = \"f\"\non = \"ground\"\nposition = [1, 2, 3]\n" + rotation)
        .frames()
        .back()
        .pose;
  };
  const SE3<> rows = frame("rotation = [[0.28, -0.96, 0], [0.96, 0.28, 0], [0, 0, 1]]\n");
  EXPECT_LT(test::disparity(rows, frame("quaternion = [0, 0, 0.6, 0.8]\n")), 1e-15);
  EXPECT_LT(test::disparity(rows, frame("rpy = [0, 0, 1.2870022175865687]\n")), 1e-15);
  // Turned about the fixed axes x, y, z in this order: z lies along x in the end, x along y.
  const SE3<> turned = frame("rpy = [1.5707963267948966, 0, 1.5707963267948966]\n");
  EXPECT_LT(norm(turned.R.z - Vec3<>{1, 0, 0}), 1e-15);
  EXPECT_LT(norm(turned.R.x - Vec3<>{0, 1, 0}), 1e-15);
}

TEST(Drawing, EveryKeyIsUnderstood) {
  const auto folder = std::filesystem::path(AXODE_SOURCE_DIR) / "tests/data/good";
  const Model model = load(folder / "every_key.toml");
  EXPECT_EQ(model.warnings().size(), 0U);
  EXPECT_EQ(model.name(), "every \"key\"");
  EXPECT_EQ(model.gravity().z, -1.62);

  const Joint& turn = model.joint(model.joint_index("turn"));
  ASSERT_EQ(turn.dof.size(), 1U);
  const Dof expected{-1, 2, 3, 4, 0.5, 0.6, 0.7, 8, 0.1, 1e4, 0.2, false, 0, 0.3, 0.4};
  EXPECT_TRUE(test::same(turn.dof[0], expected));

  const Joint& follower = model.joint(model.joint_index("follower"));
  ASSERT_TRUE(follower.leader);
  EXPECT_EQ(model.joint(follower.leader->joint).name, "turn");
  EXPECT_EQ(follower.leader->ratio, -2);
  EXPECT_EQ(follower.leader->offset, 0.25);

  const Joint& stage = model.joint(model.joint_index("stage"));
  ASSERT_EQ(stage.dof.size(), 3U);
  EXPECT_EQ(stage.dof[0].velocity, 1);
  EXPECT_EQ(stage.dof[0].stiffness, 2);
  EXPECT_EQ(stage.dof[1].lower, -0.1);
  EXPECT_EQ(stage.dof[2].lower, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(stage.dof[2].upper, 0.2);

  EXPECT_EQ(model.springs().joints.size(), 2U);
  ASSERT_EQ(model.springs().elements.size(), 9U);
  const auto spring = [&](std::string_view name) {
    return *std::ranges::find(model.springs().elements, name, &Spring::name);
  };
  EXPECT_EQ(std::get<Spring::Path>(spring("tendon").geometry).points.size(), 3U);
  EXPECT_EQ(spring("tendon").law.acts, Acts::in_tension);
  EXPECT_DOUBLE_EQ(tension(spring("tendon").law, 1.0, 0.0).f, 5);
  EXPECT_EQ(std::get<GasCurve>(spring("spring 5").law.curve).ambient, 1e5);
  EXPECT_NEAR(tension(spring("clock spring").law, 0.0, 0.0).f, 0.5, 1e-14) << "as drawn";
  EXPECT_EQ(spring("spring 7").law.acts, Acts::in_compression);
  const auto teeth = std::get<Spring::JointSum>(spring("teeth").geometry);
  ASSERT_EQ(teeth.terms.size(), 2U);
  EXPECT_EQ(teeth.terms[0].factor, -2) << "terms are sorted by name";
  const auto mount = std::get<Spring::Bushing>(spring("mount").geometry);
  EXPECT_EQ(mount.K[5][5], 4e4);
  EXPECT_EQ(mount.C[0][1], 0.1);
  EXPECT_EQ(mount.rest.r.z, 0.001);

  const auto loop = [&](std::string_view name) {
    return *std::ranges::find(model.loops().joints, name, &Loop::name);
  };
  const auto coupling = [&](std::string_view name) {
    return *std::ranges::find(model.loops().couplings, name, &LoopCoupling::name);
  };
  const auto origin = [&](const Loop::End& end) {
    return model.body(end.body).A * (model.body(end.body).S_self * end.F.r);
  };
  ASSERT_EQ(model.loops().all.size(), 17U);
  EXPECT_EQ(model.loops().rows, 6 + 5 + 5 + 5 + 5 + 4 + 3 + 3 + 3 + 4 + 1 + 3 * 3 + 1 + 2);
  EXPECT_EQ(model.body(loop("loop 2").ends[0].body).name, "wheel");
  EXPECT_EQ(loop("loop 2").ends[1].body, 0);
  EXPECT_LT(norm(loop("loop 2").ends[1].F.R.z - Vec3<>{0, -1, 0}), 1e-15);
  EXPECT_LT(norm(origin(loop("loop 2").ends[0]) - Vec3<>{1, 2, 3}), 1e-15);
  EXPECT_EQ(loop("loop 4").pitch, 0.01);
  EXPECT_DOUBLE_EQ(loop("loop 5").pitch, -0.01 / (2 * std::numbers::pi));
  EXPECT_LT(norm(origin(loop("loop 7").ends[1]) - Vec3<>{1, 0, 0}), 1e-15);
  EXPECT_LT(norm(origin(loop("loop 8").ends[0]) - Vec3<>{0, 0, 1}), 1e-15);
  EXPECT_DOUBLE_EQ(loop("loop 10").size, std::cos(1.5));
  EXPECT_EQ(loop("tie").size, 4.5);
  EXPECT_TRUE(loop("coin").wheel);
  EXPECT_DOUBLE_EQ(loop("coin").size, 2 / 0.6);
  EXPECT_LT(norm(loop("coin").ends[0].F.R.z - Vec3<>{0, 0, 1}), 1e-15) << "towards what rolls";
  EXPECT_FALSE(loop("marble").wheel);
  EXPECT_TRUE(loop("disc").wheel);
  EXPECT_EQ(loop("disc").size, 0.3);
  EXPECT_EQ(loop("belt").radii[1], -0.1);
  ASSERT_EQ(model.loops().backlashes.size(), 1U);
  EXPECT_EQ(model.loops().backlashes[0].play, 0.01);
  EXPECT_EQ(model.loops().backlashes[0].restitution, 0.4);
  EXPECT_EQ(coupling("coupling 1").offset, 0.1);
  ASSERT_EQ(coupling("train").terms.size(), 3U);
  EXPECT_EQ(coupling("train").terms[0].factor, 3 * -2) << "what follows is a multiple of what leads";
  EXPECT_EQ(coupling("train").offset, -3 * 0.25);
  EXPECT_TRUE(model.joint(model.joint_index("slide")).passive);
  EXPECT_TRUE(model.joint(model.joint_index("drift")).passive)
      << "free, and the drawing does not say that it is driven";
  EXPECT_EQ(std::ranges::count(model.loops().driven, 0), 1 + 6);

  EXPECT_EQ(model.joint(model.joint_index("screw")).kind, Subgroup::helical);
  EXPECT_EQ(model.joint(model.joint_index("slide")).kind, Subgroup::prismatic);
  EXPECT_EQ(model.joint(model.joint_index("ball")).kind, Subgroup::spherical);
  EXPECT_EQ(model.joint(model.joint_index("drift")).kind, Subgroup::free);
  EXPECT_EQ(model.joint(model.joint_index("cardan.second")).kind, Subgroup::revolute);
  EXPECT_EQ(model.joint(model.joint_index("sleeve.translation")).kind, Subgroup::prismatic);

  const BodyDescription& plate = model.description().bodies[0];
  ASSERT_EQ(plate.shapes.size(), 6U);  // the file gives the last two as [[body.mesh]]
  EXPECT_EQ(plate.shapes[0].kind, ShapeKind::cylinder);
  EXPECT_EQ(plate.shapes[0].name, "rim");
  EXPECT_EQ(plate.shapes[0].role, ShapeDescription::Role::collision);
  EXPECT_EQ(plate.shapes[0].length, 0.1);
  EXPECT_EQ(plate.shapes[1].size.z, 0.3);
  EXPECT_EQ(plate.shapes[1].color, (std::array<double, 4>{0.5, 0.5, 1, 1}));
  EXPECT_EQ(plate.shapes[2].file, "plate.obj");
  EXPECT_EQ(plate.shapes[2].scale.z, -1);
  EXPECT_EQ(plate.shapes[3].radius, 1);
  ASSERT_EQ(model.description().shapes.size(), 1U);
  EXPECT_EQ(model.description().shapes[0].size.y, 3);
  EXPECT_EQ(plate.shapes[4].file, "meshes/plate.stl");
  EXPECT_EQ(plate.shapes[4].role, ShapeDescription::Role::visual);
  EXPECT_EQ(plate.shapes[4].scale.y, 0.001);
  EXPECT_EQ(plate.shapes[5].role, ShapeDescription::Role::collision);
  EXPECT_EQ(plate.shapes[5].pose.r.z, 0.3);
  EXPECT_NEAR(plate.shapes[5].pose.R.x.y, 1, 1e-15);

  const Frame& tool = model.frame(model.frame_index("tool"));
  EXPECT_EQ(model.body(tool.body).name, "wheel");
  EXPECT_LT(norm(tool.pose.r - Vec3<>{0, 0, 0.1}), 1e-15);
}

TEST(Drawing, TheExampleOfTheDocumentationIsADrawing) {
  std::ifstream file(std::filesystem::path(AXODE_SOURCE_DIR) / "docs/drawing-format.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  const std::string fence = "```toml\n";
  const std::size_t begin = page.find(fence) + fence.size();
  const std::string example = page.substr(begin, page.find("```", begin) - begin);
  const Model crane = ModelBuilder(read_drawing_text(example, "crane.toml")).build();
  EXPECT_EQ(crane.n_bodies(), 3);
  EXPECT_EQ(crane.warnings().size(), 0U);
  EXPECT_EQ(crane.total_mass(), 1160);
}

TEST(Drawing, IntegersAreNumbersAndLinesAreThoseOfTheFile) {
  const Description d =
      read_drawing_text(format +
                            "[[body]]\nname = \"a\"\njoint = \"fixed\"\n"
                            "[[body]]\nname = \"b\"\non = \"a\"\njoint.kind = \"prismatic\"\n"
                            "joint.axis = [1, 0, 0]\n[[frame]]\nname = \"f\"\non = \"b\"\n",
                        "lines.toml");
  EXPECT_EQ(d.bodies[0].source.line, 2);
  EXPECT_EQ(d.bodies[1].source.line, 5);
  EXPECT_EQ(d.bodies[1].joint.source.line, 8);
  EXPECT_EQ(d.bodies[1].source.file, "lines.toml");
  EXPECT_EQ(d.frames[0].source.line, 10);
}

TEST(Drawing, TextsAndCommentsMayHoldAnything) {
  const std::string odd = R"(# größer [ # " ' }
name = """
[ not a header \""" \
  ü "" [#]\
     end""""  # ' "
[[body]]  # [
"name" = '\[é]'
joint . kind = "fixed" # """
[[  body  ]]
'name' = """.""."" """
joint = { "kind" = 'prismatic', axis = [
  0, # [ {
  0,
  1, # ü
] }
)";
  const Description d = read_drawing_text("\xEF\xBB\xBF" + format + odd, "odd.toml");
  EXPECT_EQ(d.name, "[ not a header \"\"\" ü \"\" [#]end\"");
  ASSERT_EQ(d.bodies.size(), 2U);
  EXPECT_EQ(d.bodies[0].name, "\\[é]");
  EXPECT_EQ(d.bodies[1].name, ".\"\".\"\" ");
  EXPECT_EQ(d.bodies[1].joint.axis.z, 1);
}

TEST(Drawing, TheReaderAloneThrowsEveryFaultOfItsOwn) {
  try {
    read_drawing_text("[[body]]\nnam = \"a\"\njoint = 1\n[[frames]]\n", "test.toml");
    FAIL() << "accepted";
  } catch (const ModelError& error) {
    EXPECT_EQ(error.faults().size(), 5U);
    EXPECT_THAT(error.what(),
                HasSubstr("test.toml:2: error: body 1: key \"nam\" is not known; did you mean \"name\"?"));
    EXPECT_THAT(
        error.what(),
        HasSubstr("test.toml:4: error: drawing: key \"frames\" is not known; did you mean \"frame\"?"));
  }
}

}  // namespace
}  // namespace axode
