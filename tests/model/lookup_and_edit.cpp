#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "axode/dynamics.hpp"
#include "tests/model/random_mechanism.hpp"

/// Names lead to indices, models never change, and edits make new models.
namespace axode::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

auto throws_message(const std::string& message) { return ThrowsMessage<std::invalid_argument>(message); }

Model arm() {
  const MassProperties solid{.mass = 2, .com = {0.1, 0, 0}, .Theta = {.02, .03, .03, 0, 0, 0}};
  return ModelBuilder("arm")
      .add(
          {.name = "upper arm", .joint = {.name = "shoulder", .kind = JointKind::revolute}, .inertia = solid})
      .add({.name = "forearm",
            .predecessor = "upper arm",
            .joint = {.name = "elbow", .kind = JointKind::revolute, .axis = {0, 1, 0}, .point = {0.4, 0, 0}},
            .inertia = solid})
      .add({.name = "hand",
            .predecessor = "forearm",
            .geometry = InBodyFrame{{{}, {0.7, 0, 0}}},
            .inertia = solid})
      .add({.name = "tool", .body = "hand", .pose = {{}, {0.1, 0, 0}}})
      .build();
}
double torque_at_rest(const Model& model, std::size_t k) {
  Workspace<double> workspace(model);
  const std::vector<double> zero(model.nv());
  std::vector<double> tau(model.nv());
  inverse_dynamics(model, workspace, neutral(model), zero, zero, tau);
  return tau[k];
}

// --------------------------------------------------------------------------------------------------- lookups

TEST(Lookup, NamesGiveIndices) {
  const Model model = arm();
  EXPECT_EQ(model.name(), "arm");
  EXPECT_EQ(model.body_index("ground"), 0);
  EXPECT_EQ(model.body_index("upper arm"), 1);
  EXPECT_EQ(model.body_index("forearm"), 2);
  EXPECT_EQ(model.joint_index("shoulder"), 1);
  EXPECT_EQ(model.joint_index("elbow"), 2);
  EXPECT_EQ(model.frame_index("ground"), 0);
  EXPECT_EQ(model.frame_index("forearm"), 2);
  EXPECT_EQ(model.frame_index("hand"), 3);
  EXPECT_EQ(model.frame_index("tool"), 4);
}

TEST(Lookup, EveryNameFindsItsOwn) {
  Random<double> random(61);
  const Model model = ModelBuilder(random_tree(random, 40, all_kinds)).build();
  for (int i = 0; i <= model.n_bodies(); ++i) EXPECT_EQ(model.body_index(model.body(i).name), i);
  for (int i = 1; i <= model.n_bodies(); ++i) EXPECT_EQ(model.joint_index(model.joint(i).name), i);
  for (int f = 0; f < model.n_frames(); ++f) EXPECT_EQ(model.frame_index(model.frame(f).name), f);
  EXPECT_EQ(&model.joints()[0], &model.joint(1));
  EXPECT_EQ(&model.bodies()[1], &model.body(1));
  EXPECT_EQ(&model.frames()[2], &model.frame(2));
}

TEST(Lookup, WhoMisspellsIsTold) {
  const Model model = arm();
  EXPECT_THAT([&] { model.body_index("foream"); },
              throws_message("model \"arm\" has no body \"foream\"; did you mean \"forearm\"?"));
  EXPECT_THAT([&] { model.joint_index("elbwo"); },
              throws_message("model \"arm\" has no joint \"elbwo\"; did you mean \"elbow\"?"));
  const Model cardan = ModelBuilder()
                           .add({.name = "fork",
                                 .joint = {.name = "U", .kind = JointKind::universal, .axis = {0, 0, 1}},
                                 .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1, 0, 0, 0}}})
                           .build();
  EXPECT_THAT([&] { static_cast<void>(cardan.joint_index("U")); },
              throws_message("model \"mechanism\" has no joint \"U\"; there are \"U.first\", \"U.second\""));
  EXPECT_THAT([&] { model.frame_index("tol"); },
              throws_message("model \"arm\" has no frame \"tol\"; did you mean \"tool\"?"));
  EXPECT_THAT([&] { model.body_index("wheel"); }, throws_message("model \"arm\" has no body \"wheel\""))
      << "nothing is near";
  EXPECT_THAT([&] { model.body_index(""); }, throws_message("model \"arm\" has no body \"\""));
  EXPECT_THAT([&] { model.body_index("Forearm"); },
              throws_message("model \"arm\" has no body \"Forearm\"; did you mean \"forearm\"?"));
  EXPECT_THAT([&] { model.body_index(std::string(100'000, 'x')); }, testing::Throws<std::invalid_argument>());
}

TEST(Lookup, OneKindOfNameIsNotAnother) {
  const Model model = arm();
  EXPECT_THROW(model.body_index("elbow"), std::invalid_argument);
  EXPECT_THROW(model.joint_index("forearm"), std::invalid_argument);
  EXPECT_THROW(model.body_index("hand"), std::invalid_argument) << "a body fixed to another is a frame";
  EXPECT_THROW(model.joint_index("hand_joint"), std::invalid_argument) << "a fixed joint is none";
}

TEST(Lookup, NamesMayBeAnyText) {
  const std::string odd = "Größe \"1\" / \n\t {}";
  const Model model =
      ModelBuilder(odd)
          .add({.name = odd, .joint = {.kind = JointKind::revolute}, .inertia = MassProperties{.mass = 1}})
          .build();
  EXPECT_EQ(model.body_index(odd), 1);
  EXPECT_EQ(model.joint_index(odd + "_joint"), 1);
}

// ---------------------------------------------------------------------------------------------------- models

TEST(Edit, TotalMassIsThatOfEverythingThatMoves) {
  EXPECT_DOUBLE_EQ(arm().total_mass(), 6);
  Random<double> random(62);
  Description tree = random_tree(random, 30, all_kinds);
  double mass = 0;
  for (BodyDescription& body : tree.bodies) {
    if (body.predecessor == "ground" && body.joint.kind == JointKind::fixed)
      body.joint.kind = JointKind::revolute;
    mass += body.inertia->mass;
  }
  EXPECT_NEAR(ModelBuilder(tree).build().total_mass(), mass, 1e-12);
}

TEST(Edit, CopiesShareTheirData) {
  const Model model = arm();
  const Model copy = model;
  EXPECT_EQ(&copy.body(1), &model.body(1));
  EXPECT_EQ(&copy.tree<float>(), &model.tree<float>());
  Model assigned = ModelBuilder("other").build();
  assigned = copy;
  EXPECT_EQ(&assigned.description(), &model.description());
  EXPECT_EQ(assigned.name(), "arm");
}

TEST(Edit, ACopyOutlivesTheModelItWasTakenFrom) {
  std::optional<Model> model = arm();
  const Model copy = *model;
  model.reset();
  EXPECT_EQ(copy.body(2).name, "forearm");
  EXPECT_EQ(copy.tree<double>()->n, 2);
}

TEST(Edit, APayloadMakesANewModelAndLeavesTheOld) {
  const Model model = arm();
  ModelBuilder builder(model);
  builder.body("hand").inertia =
      MassProperties{.mass = 12, .com = {0.1, 0, 0}, .Theta = {.1, .1, .1, 0, 0, 0}};
  const Model loaded = builder.build();
  EXPECT_DOUBLE_EQ(model.total_mass(), 6);
  EXPECT_DOUBLE_EQ(loaded.total_mass(), 16);
  const std::size_t elbow = 1;
  const double g = 9.81;
  EXPECT_NEAR(torque_at_rest(model, elbow), -g * (2 * (0.1 - 0.4) + 2 * (0.8 - 0.4)), 1e-12);
  EXPECT_NEAR(torque_at_rest(loaded, elbow), -g * (2 * (0.1 - 0.4) + 12 * (0.8 - 0.4)), 1e-12);
}

TEST(Edit, AnythingOfTheDescriptionCanBeChanged) {
  ModelBuilder builder(arm());
  builder.gravity({0, 0, 0});
  builder.body("forearm").joint.kind = JointKind::fixed;
  builder.add(BodyDescription{.name = "finger",
                              .predecessor = "hand",
                              .joint = {.kind = JointKind::prismatic},
                              .inertia = MassProperties{.mass = 0.1}});
  builder.add(FrameDescription{.name = "tip", .body = "finger"});
  const Model model = builder.build();
  EXPECT_EQ(model.n_bodies(), 2);
  EXPECT_EQ(model.body(2).name, "finger");
  EXPECT_EQ(model.body(2).predecessor, 1);
  EXPECT_EQ(model.gravity().z, 0);
  EXPECT_EQ(model.frame(model.frame_index("tip")).body, 2);
  EXPECT_EQ(torque_at_rest(model, 0), 0);
}

TEST(Edit, AModelRebuiltFromItsDescriptionIsTheSame) {
  Random<double> random(63);
  for (int trial = 0; trial < 20; ++trial) {
    const Model model = ModelBuilder(random_tree(random, 10, all_kinds)).build(),
                again = ModelBuilder(model).build();
    ASSERT_EQ(again.n_frames(), model.n_frames());
    for (int i = 0; i <= model.n_bodies(); ++i) {
      EXPECT_EQ(distance(model.tree<double>().B[i], again.tree<double>().B[i]), 0);
      EXPECT_EQ(distance(model.tree<double>().M[i], again.tree<double>().M[i]), 0);
    }
  }
}

TEST(Edit, TheBodyToEditMustExist) {
  ModelBuilder builder(arm());
  EXPECT_THAT(
      [&] { builder.body("hnad"); },
      throws_message("ModelBuilder::body: model \"arm\" has no body \"hnad\"; did you mean \"hand\"?"));
}

TEST(Edit, ABadEditIsRefusedAndTheBuilderStays) {
  ModelBuilder builder(arm());
  builder.body("hand").inertia->mass = -1;
  EXPECT_THROW(builder.build(), ModelError);
  builder.body("hand").inertia->mass = 1;
  EXPECT_DOUBLE_EQ(builder.build().total_mass(), 5);
}

TEST(Edit, TheDescriptionIsWhatWasSaid) {
  const Model model = arm();
  EXPECT_EQ(model.description().bodies.size(), 3u);
  EXPECT_EQ(model.description().bodies[2].name, "hand");
  EXPECT_EQ(model.description().bodies[1].joint.point.x, 0.4);
  EXPECT_EQ(model.description().frames[0].name, "tool");
}

TEST(Edit, GravityIsMinusNineEightOneAlongZUnlessSaid) {
  EXPECT_EQ(arm().gravity().x, 0);
  EXPECT_EQ(arm().gravity().z, -9.81);
  EXPECT_EQ(ModelBuilder().gravity({1, 2, 3}).build().gravity().y, 2);
  EXPECT_EQ(ModelBuilder().gravity({1, 2, 3}).build().tree<float>().g.y, 2.0f);
}

}  // namespace
}  // namespace axode::test
