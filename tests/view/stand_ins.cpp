#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "axode/view/levels.hpp"
#include "axode/view/points.hpp"
#include "axode/view/stand_ins.hpp"
#include "tests/model/random_mechanism.hpp"
#include "tests/support/random_tree.hpp"
#include "tests/support/shared_files.hpp"
#include "tests/view/scene_json.hpp"

/// Bodies without shapes are drawn such that they look like what they are.
namespace axode::test {
namespace {

/// The points of joints, frames and loop ends on a body, in its frame.
std::vector<Eigen::Vector3d> points_on(const Json& scene, std::size_t body) {
  std::vector<Eigen::Vector3d> points;
  const auto add = [&](const Json& pose) { points.push_back(pose_from(pose).translation()); };
  for (std::size_t i = 1; i < scene["bodies"].size(); ++i) {
    const Json& other = scene["bodies"][i];
    if (i == body) add(other["S_self"]);
    if (other["predecessor"] == body) add(other["S_prev"]);
  }
  for (const Json& frame : scene["frames"])
    if (frame["body"] == body) add(frame["pose"]);
  for (const Json& loop : scene["loops"])
    for (const Json& end : loop["ends"])
      if (end["body"] == body) add(end["pose"]);
  return points;
}
double distance_to_nearest(const Eigen::Vector3d& point, const std::vector<Eigen::Vector3d>& others) {
  double nearest = INFINITY;
  for (const Eigen::Vector3d& other : others) nearest = std::min(nearest, (point - other).norm());
  return nearest;
}

/// The number of blocks on the ground.
int mounts_in(const Json& scene) {
  int mounts = 0;
  for (const Json& shape : scene["shapes"]) mounts += shape["body"] == 0 && shape["kind"] == "box";
  return mounts;
}

TEST(StandIns, ASliderOnTheGroundHasARailAlongItsWay) {
  const Model model = without_shapes("slider_crank.toml");
  const Json scene = scene_of(model, neutral(model));
  int rails = 0;
  for (const Json& shape : scene["shapes"]) {
    if (shape["body"] != 0 || shape["kind"] != "capsule") continue;
    const Eigen::Isometry3d pose = pose_from(shape["pose"]);
    const bool along = (pose.linear().col(2).cwiseAbs() - Eigen::Vector3d::UnitX()).norm() < 1e-12;
    const int slider = model.n_bodies();
    const SE3<> A = model.body(slider).A;
    const Eigen::Vector3d off = to_eigen(A * center_of_mass(model.body(slider).M)) - pose.translation();
    rails += along && off.tail<2>().norm() < 1e-12;
  }
  EXPECT_EQ(rails, 1);
  EXPECT_EQ(mounts_in(scene), 3);  // those of the crank and of both ends of the rail
}

TEST(StandIns, ReachFromPointToPointOfTheirBody) {
  for (const std::string name : {"arm7.toml", "humanoid.urdf", "leg.toml"}) {
    const Model model = without_shapes(name);
    const Json scene = scene_of(model, neutral(model));
    std::vector<bool> seen(static_cast<std::size_t>(model.n_bodies()) + 1);
    int bars = 0;
    for (const Json& shape : scene["shapes"]) {
      EXPECT_EQ(shape["stand_in"], true);
      const auto i = shape["body"].get<std::size_t>();
      seen[i] = true;
      if (i == 0) continue;
      std::vector<Eigen::Vector3d> points = points_on(scene, i);
      const Eigen::Isometry3d pose = pose_from(shape["pose"]);
      if (shape["kind"] == "hull") {
        EXPECT_GT(shape["points"].size(), 2U);
        for (const Json& point : shape["points"])
          EXPECT_LT(distance_to_nearest(pose * Eigen::Vector3d(point[0], point[1], point[2]), points), 1e-12);
      } else if (shape["kind"] == "capsule") {
        const Eigen::Vector3d half = pose.linear().col(2) * shape["length"].get<double>() / 2;
        EXPECT_LT(distance_to_nearest(pose.translation() - half, points), 1e-12);
        const Json& com = scene["bodies"][i]["com"];
        const Eigen::Vector3d center(com[0], com[1], com[2]);
        points.insert(points.end(), {center, 2 * center - (pose.translation() - half)});
        EXPECT_LT(distance_to_nearest(pose.translation() + half, points), 1e-12);
        ++bars;
      } else if (!shape["color"].is_null()) {  // a part that stands for a joint
        EXPECT_LT(distance_to_nearest(pose.translation(), points), 1e-12);
      }
    }
    EXPECT_GT(bars, 0) << name;
    for (int i = 1; i <= model.n_bodies(); ++i)
      EXPECT_TRUE(seen[i] || model.body(i).M.m == 0) << name << ": " << model.body(i).name;
  }
}

/// A boom on a pin, which a cylinder and a spring hold.
constexpr const char* boom = R"(format = "axode drawing 1"

[[body]]
name = "boom"
joint = { kind = "revolute", axis = "y", point = [0, 0, 1] }
mass = 1
com = [1, 0, 1]
inertia = [1, 1, 1]

[[spring]]
between = ["boom", "ground"]
points = [[2, 0, 1], [2, 0, 3]]
stiffness = 10

[[drive]]
kind = "hydraulic_cylinder"
between = ["ground", "boom"]
points = [[1, 0, 0], [1, 0, 0.5]]
stroke = 1
area_a = 1
area_b = 1
dead_volume_a = 1
dead_volume_b = 1
bulk_modulus = 1
valve = 1
supply_pressure = 1
valve_time = 1
input = 0
)";

TEST(StandIns, ReachToTheEndsOfSpringsAndDrives) {
  const Model model = ModelBuilder(read_drawing_text(boom, "boom")).build();
  const Json scene = scene_of(model, neutral(model));
  ASSERT_EQ(scene["lines"].size(), 2U);
  for (const bool driven : {false, true}) {
    const Json& line = scene["lines"][driven ? 1 : 0];
    EXPECT_EQ(line["driven"], driven);
    EXPECT_EQ(line["ends"][0]["body"], driven ? 0 : 1);
  }
  EXPECT_EQ(scene["lines"][0]["stiffness"], 10);
  for (const Json& shape : scene["shapes"]) {
    if (shape["body"] == 1 && shape["kind"] != "cylinder") {
      EXPECT_EQ(shape["kind"], "hull");
      EXPECT_EQ(shape["points"].size(), 3U);
    }
  }
  EXPECT_EQ(mounts_in(scene), 3);
}

TEST(StandIns, APlateJoinsTheTopsOfLegs) {
  const Model model = without_shapes("gough.toml");
  const Json scene = scene_of(model, neutral(model));
  const Json plate =
      *std::ranges::find_if(scene["shapes"], [](const Json& shape) { return shape["kind"] == "hull"; });
  EXPECT_EQ(plate["body"], model.body_index("platform"));
  EXPECT_EQ(plate["points"].size(), 6U);
}

/// A page computes the convex hull of a body. If a body has very many points, the page gets only the
/// outermost ones.
TEST(StandIns, OfManyPointsHaveTheCornersOfTheirHull) {
  ModelBuilder builder("hedgehog");
  builder.add(BodyDescription{.name = "body",
                              .joint = {.kind = JointKind::free},
                              .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}}});
  Random<double> random(1);
  for (int k = 0; k < 70'000; ++k) {
    const Vec3<> inside = random.vector();
    builder.add(FrameDescription{
        .name = std::to_string(k), .body = "body", .pose = {{}, (k < 6 ? 1 : 0.5) / norm(inside) * inside}});
  }
  const Model model = builder.build();
  const std::vector<view::StandIn> parts = view::stand_ins(model, {false, false});
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_GT(parts[0].hull.size(), 6U);
  EXPECT_LE(parts[0].hull.size(), 60U);
  for (const Vec3<>& point : parts[0].hull) EXPECT_GT(norm(point + parts[0].shape.pose.r), 0.49);
}

TEST(StandIns, DrivesHaveAColorOfTheirOwnAndHingesOnTheGroundAMount) {
  const Model model = without_shapes("four_bar.toml");
  std::map<std::string, int> pins;
  const Json scene = scene_of(model, neutral(model));
  for (const Json& shape : scene["shapes"]) {
    pins[shape["color"].dump()] += shape["kind"] == "cylinder";
  }
  EXPECT_EQ(mounts_in(scene), 2);  // those of the crank and the rocker
  const int driven = static_cast<int>(std::ranges::count(model.joints(), false, &Joint::passive));
  EXPECT_EQ(driven, 1);
  EXPECT_EQ(pins["[0.88,0.54,0.12,1.0]"], driven);
  EXPECT_EQ(pins["[0.31,0.36,0.42,1.0]"], 2 + 1);  // those of two passive joints and of the loop
}

TEST(StandIns, ABeltIsNoJointOfItsPulleys) {
  const auto pulley = [](const char* name, const Vec3<>& center) {
    return BodyDescription{.name = name,
                           .joint = {.kind = JointKind::revolute, .axis = {0, 0, 1}, .point = center},
                           .inertia = MassProperties{.mass = 1, .com = center, .Theta = {1, 1, 2}}};
  };
  Description d{.name = "belt drive"};
  d.bodies = {pulley("small", {}), pulley("large", {1, 0, 0})};
  const Model without = ModelBuilder(d).build();
  LoopDescription belt{.name = "belt", .between = {"small", "large"}, .kind = LoopKind::belt};
  belt.points = {Vec3<>{}, Vec3<>{1, 0, 0}};
  belt.radii = {0.1, 0.3};
  d.loops = {belt};
  const Model with = ModelBuilder(d).build();
  const std::vector<bool> none(3, false);
  EXPECT_EQ(view::stand_ins(with, none).size(), view::stand_ins(without, none).size());
}

TEST(StandIns, AnAxisymmetricBodyIsTheCylinderWithItsInertia) {
  for (const double ratio : {0.1, 0.9, 1.4, 1.9}) {  // the moment of inertia about the axis, divided by that
                                                     // across it
    const double m = 3, across = 0.4, along = ratio * across;
    const Model model =
        ModelBuilder("wheel")
            .add(BodyDescription{.name = "wheel",
                                 .joint = {.kind = JointKind::free},
                                 .inertia = MassProperties{.mass = m, .Theta = {across, along, across}}})
            .build();
    const Json shape = scene_of(model, neutral(model))["shapes"][0];
    ASSERT_EQ(shape["kind"], "cylinder") << ratio;
    const double r2 = std::pow(shape["radius"].get<double>(), 2),
                 l2 = std::pow(shape["length"].get<double>(), 2);
    EXPECT_NEAR(m * r2 / 2, along, 1e-12);
    EXPECT_NEAR(m * (r2 / 4 + l2 / 12), across, 1e-12);
    EXPECT_NEAR(std::abs(pose_from(shape["pose"]).linear()(1, 2)), 1,
                1e-12);  // the axis of the cylinder is y
  }
}

TEST(StandIns, AnEllipsoidHasTheInertiaOfItsBody) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random<double> random(seed);
    const Inertia<> M = random.inertia();
    const Model model =
        ModelBuilder("stone")
            .add(BodyDescription{
                .name = "stone", .joint = {.kind = JointKind::free}, .inertia = mass_properties(M)})
            .build();
    const Json scene = scene_of(model, neutral(model));
    ASSERT_EQ(scene["shapes"].size(), 1U);
    const Json& shape = scene["shapes"][0];
    ASSERT_EQ(shape["kind"], "ellipsoid");
    const auto a = shape["size"].get<std::vector<double>>();
    const auto square = [](double x) { return x * x; };
    const Inertia<> solid{M.m,
                          {},
                          {M.m / 5 * (square(a[1]) + square(a[2])), M.m / 5 * (square(a[0]) + square(a[2])),
                           M.m / 5 * (square(a[0]) + square(a[1]))}};
    EXPECT_LT((to_eigen(transform(pose_of(shape["pose"]), solid)) - to_eigen(M)).cwiseAbs().maxCoeff(),
              2e-3 * to_eigen(M).cwiseAbs().maxCoeff())
        << "seed " << seed;
  }
}

TEST(StandIns, OnlyWhereNothingIsSeen) {
  const auto shapes = [](std::vector<ShapeDescription> own) {
    const Model model = ModelBuilder("stone")
                            .add(BodyDescription{.name = "stone",
                                                 .joint = {.kind = JointKind::free},
                                                 .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}},
                                                 .shapes = std::move(own)})
                            .build();
    return scene_of(model, neutral(model))["shapes"];
  };
  const auto stand_ins_in = [](const Json& all) {
    return std::ranges::count_if(all, [](const Json& shape) { return shape["stand_in"] == true; });
  };
  using enum ShapeKind;
  const auto visual = ShapeDescription::Role::visual, collision = ShapeDescription::Role::collision;
  EXPECT_EQ(stand_ins_in(shapes({})), 1);
  EXPECT_EQ(stand_ins_in(shapes({{.role = visual, .kind = sphere, .radius = 1}})), 0);
  EXPECT_EQ(stand_ins_in(shapes({{.role = collision, .kind = sphere, .radius = 1}})), 1);
  const Json missing = shapes({{.role = visual, .kind = mesh, .file = "no.stl"}});
  EXPECT_EQ(missing.size(), 1U);
  EXPECT_EQ(stand_ins_in(missing), 1);
}

/// A body whose mesh is lost is drawn as its collision shapes, or else by a stand-in, also if a small part of
/// it is left.
TEST(StandIns, ACylindricalJointBetweenBodiesWithShapesHasNone) {
  const auto stand_ins_in = [](const Model& model) {
    const Json scene = scene_of(model, neutral(model));
    return std::ranges::count_if(scene["shapes"],
                                 [](const Json& shape) { return shape["stand_in"] == true; });
  };
  EXPECT_EQ(stand_ins_in(shipped("radial_drill.toml")), 0);
  EXPECT_GT(stand_ins_in(without_shapes("radial_drill.toml")), 5);
}

TEST(StandIns, ReplaceMeshesThatAreLost) {
  using enum ShapeKind;
  const auto visual = ShapeDescription::Role::visual, collision = ShapeDescription::Role::collision;
  const ShapeDescription lost{.role = visual, .kind = mesh, .file = "no.stl"},
      knob{.role = visual, .kind = sphere, .radius = 0.01},
      box_around{.role = collision, .kind = box, .size = {1, 2, 3}};
  const auto visuals = [](std::vector<ShapeDescription> own) {
    const Model model = ModelBuilder("stone")
                            .add(BodyDescription{.name = "stone",
                                                 .joint = {.kind = JointKind::free},
                                                 .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}},
                                                 .shapes = std::move(own)})
                            .build();
    std::vector<std::string> kinds;
    const Json scene = scene_of(model, neutral(model));
    for (const Json& shape : scene["shapes"])
      if (shape["role"] == "visual") kinds.push_back(shape["kind"]);
    return kinds;
  };
  using Kinds = std::vector<std::string>;
  EXPECT_EQ(visuals({lost, box_around}), Kinds{"box"});
  EXPECT_EQ(visuals({lost, knob, box_around}), (Kinds{"sphere", "box"}));
  EXPECT_EQ(visuals({lost, knob}), (Kinds{"sphere", "ellipsoid"}));
  EXPECT_EQ(visuals({lost, knob, knob, box_around}), (Kinds{"sphere", "sphere"}));
}

TEST(StandIns, AreNoFartherFromTheirBodyThanItIsLong) {
  std::vector<std::filesystem::path> files = files_ending_in(AXODE_SOURCE_DIR "/examples/robots", "");
  for (const auto& file : files_ending_in(robots_folder(), ".urdf")) files.push_back(file);
  for (const auto& file : files) {
    SCOPED_TRACE(file.string());
    const Model model = load(file);
    const Json scene = scene_of(model, neutral(model));
    const double size = view::Points(model).size();
    for (const Json& shape : scene["shapes"]) {
      const auto i = shape["body"].get<std::size_t>();
      if (shape["stand_in"] == false || shape["role"] == "collision" || i == 0) continue;
      std::vector<Eigen::Vector3d> points = points_on(scene, i);
      const Json& com = scene["bodies"][i]["com"];
      points.emplace_back(com[0], com[1], com[2]);
      const Eigen::Vector3d at = pose_from(shape["pose"]).translation();
      ASSERT_TRUE(at.allFinite());
      EXPECT_LT(distance_to_nearest(at, points), 0.6 * size) << shape.dump();
    }
  }
}

TEST(StandIns, ATrunkThatIsFixedToTheGroundIsDrawnAndHasNoMounts) {
  const Model on_ground = without_shapes("humanoid.urdf");
  const Json fixed = scene_of(on_ground, neutral(on_ground));
  int trunks = 0;
  for (const Json& shape : fixed["shapes"]) trunks += shape["body"] == 0 && shape["kind"] == "hull";
  EXPECT_EQ(trunks, 1);
  EXPECT_EQ(mounts_in(fixed), 0);
  const Model free = without_shapes("humanoid.urdf", Base::free);
  const Json floating = scene_of(free, neutral(free));
  for (const Json& shape : floating["shapes"]) EXPECT_NE(shape["body"], 0);
}

TEST(StandIns, AnArmStandsOnAMount) {
  const Model model = without_shapes("arm7.toml");
  EXPECT_EQ(mounts_in(scene_of(model, neutral(model))), 1);
}

TEST(StandIns, InertiasThatAreTooLargeDoNotHideTheMechanism) {
  ModelBuilder builder("two links");
  const JointDescription hinge{.kind = JointKind::revolute, .axis = {0, 1, 0}};
  const MassProperties wrong{.mass = 1, .com = {0, 0, 0.5}, .Theta = {10, 10, 10}};
  builder.add(BodyDescription{.name = "upper", .joint = hinge, .inertia = wrong})
      .add(BodyDescription{.name = "lower", .predecessor = "upper", .joint = hinge, .inertia = wrong});
  const Model model = builder.build();
  double largest = 0;
  for (const view::StandIn& part : view::stand_ins(model, {false, false, false}))
    if (part.shape.kind == ShapeKind::ellipsoid) largest = std::max(largest, part.shape.size.x);
  EXPECT_GT(largest, 0);
  EXPECT_LE(largest, 0.125 * view::Points(model).size() + 1e-12);
}

TEST(StandIns, HeavierBodiesAreThicker) {
  ModelBuilder builder("chain");
  const double masses[] = {0.01, 1, 3, 1000};
  for (int k = 0; k < 5; ++k)
    builder.add(BodyDescription{
        .name = std::to_string(k),
        .predecessor = k == 0 ? "ground" : std::to_string(k - 1),
        .joint = {.kind = JointKind::revolute,
                  .axis = {0, 1.0 * (k % 2), 1.0 * ((k + 1) % 2)},
                  .point = {1.0 * k, 0, 0}},
        .inertia =
            MassProperties{.mass = masses[std::min(k, 3)], .com = {k + 0.5, 0, 0}, .Theta = {1, 1, 1}}});
  const Model model = builder.build();
  std::vector<double> radii;
  for (const view::StandIn& part : view::stand_ins(model, std::vector<bool>(6)))
    if (part.body > 0 && part.body < 5 && part.shape.kind == ShapeKind::capsule)
      radii.push_back(part.shape.radius);
  ASSERT_EQ(radii.size(), 4U);
  EXPECT_TRUE(std::ranges::is_sorted(radii));
  EXPECT_NEAR(radii[1] / radii[0], std::cbrt(1.0 / 3) / 0.6, 1e-9);  // the median mass is 3
  EXPECT_NEAR(radii[3] / radii[2], 1.6, 1e-9);
}

/// Bars of a planar mechanism lie above each other, and none goes through another one that it meets.
TEST(Levels, BodiesThatMeetHaveDifferentOnes) {
  for (const char* file :
       {"four_bar.toml", "andrews.toml", "slider_crank.toml", "n_four_bar.toml", "five_bar_arm.toml"}) {
    SCOPED_TRACE(file);
    const Model model = without_shapes(file);
    const auto levels = view::levels_of(model, 0.01 * view::Points(model).size(), {0, 0, 1});
    ASSERT_TRUE(levels.has_value());
    EXPECT_EQ(levels->of[0], 0);
    for (int i = 1; i <= model.n_bodies(); ++i)
      if (model.joint(i).kind != Subgroup::prismatic) {
        EXPECT_NE(levels->of[i], levels->of[model.body(i).predecessor]);
      }
    for (const Loop& loop : model.loops().joints)
      EXPECT_NE(levels->of[loop.ends[0].body], levels->of[loop.ends[1].body]);
  }
  for (const char* file : {"bricard.toml", "gough.toml", "arm7.toml", "delta.toml"}) {
    const Model model = without_shapes(file);
    EXPECT_FALSE(view::levels_of(model, 1e-3, {0, 0, 1}).has_value()) << file;
  }
}

/// Bodies on one pin are stacked in their order, and so are drawings with very many of them.
TEST(Levels, BodiesOnOnePinAreStacked) {
  ModelBuilder builder("fan");
  const int n = 5000;
  for (int k = 0; k < n; ++k)
    builder.add(BodyDescription{.name = std::to_string(k),
                                .joint = {.kind = JointKind::revolute, .axis = {0, 0, 1}},
                                .inertia = MassProperties{.mass = 1, .com = {1, 0, 0}, .Theta = {1, 1, 1}}});
  const auto levels = view::levels_of(builder.build(), 0.01, {0, 0, 1});
  ASSERT_TRUE(levels.has_value());
  for (int i = 0; i <= n; ++i) EXPECT_EQ(levels->of[i], i);
}

TEST(Levels, AreFoundQuicklyForLongChains) {
  ModelBuilder builder("chain");
  const int n = 3000;
  for (int k = 0; k < n; ++k)
    builder.add(
        BodyDescription{.name = std::to_string(k),
                        .predecessor = k == 0 ? "ground" : std::to_string(k - 1),
                        .joint = {.kind = JointKind::revolute, .axis = {0, 1, 0}, .point = {0, 0, 1.0 * k}},
                        .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}}});
  const auto levels = view::levels_of(builder.build(), 1e-3, {0, 0, 1});
  ASSERT_TRUE(levels.has_value());
  for (int k = 1; k <= n; ++k) EXPECT_EQ(levels->of[k], k % 2 == 1 ? 1 : 2);
}

/// A mechanism that has a joint of every kind and no shapes.
constexpr const char* every_joint = R"(format = "axode drawing 1"

[[body]]
name = "post"
joint = { kind = "revolute", axis = "y", point = [0, 0, 0] }
mass = 1
com = [0, 0, 0.3]
inertia = [1, 1, 1]

[[body]]
name = "arm"
on = "post"
joint = { kind = "spherical", point = [0, 0, 0.6] }
mass = 1
com = [0.25, 0, 0.6]
inertia = [1, 1, 1]

[[body]]
name = "screw"
on = "arm"
joint = { kind = "helical", axis = "z", point = [0.5, 0, 0.6], lead = -0.05 }
mass = 1
com = [0.5, 0, 0.4]
inertia = [1, 1, 1]

[[body]]
name = "table"
joint = { kind = "planar", axis = "z", point = [0.7, 0.5, 0.1] }
mass = 1
com = [0.7, 0.5, 0.2]
inertia = [1, 1, 1]

[[body]]
name = "shaft"
on = "table"
joint = { kind = "universal", axis = "x", second_axis = "y", point = [0.7, 0.5, 0.4] }
mass = 1
com = [0.7, 0.5, 0.6]
inertia = [1, 1, 1]
)";

TEST(JointParts, ShowTheKindOfAJointAndWhichEndBelongsToWhichBody) {
  const Model model = ModelBuilder(read_drawing_text(every_joint, "every joint")).build();
  const Json scene = scene_of(model, neutral(model));
  /// The numbers of parts on a body of a kind, with the colour of a drive or with that of the body.
  const auto count = [&](const std::string& body, const std::string& kind, bool is_colored) {
    int found = 0;
    for (const Json& shape : scene["shapes"])
      found += shape["body"] == (body == "ground" ? 0 : model.body_index(body)) && shape["kind"] == kind &&
               shape["color"].is_null() != is_colored;
    return found;
  };
  EXPECT_EQ(count("ground", "cylinder", false), 2);  // the cheeks of a fork
  EXPECT_EQ(count("post", "cylinder", false), 1);    // the tongue in it
  EXPECT_EQ(count("post", "cylinder", true), 1);     // the pin
  EXPECT_EQ(count("post", "socket", false), 1);
  EXPECT_EQ(count("arm", "sphere", true), 1);
  EXPECT_EQ(count("arm", "box", false), 1);  // the nut
  EXPECT_EQ(count("screw", "thread", true), 1);
  EXPECT_EQ(count("ground", "box", false), 1 + 2);  // a plate for the pad, and mounts
  EXPECT_EQ(count("table", "box", true), 1);
  EXPECT_EQ(count("shaft", "cylinder", true), 1);  // one of the pins of the cross
  for (const Json& shape : scene["shapes"])
    if (shape["kind"] == "thread") {
      EXPECT_NEAR(shape["lead"].get<double>(), -0.05, 1e-12);
    }
}

}  // namespace
}  // namespace axode::test
