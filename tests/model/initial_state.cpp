#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "axode/model/building/builder.hpp"
#include "axode/model/building/edited.hpp"
#include "axode/model/configuration.hpp"

/// The initial state of a description and its prescribed motions in models that are made of others.
namespace axode {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr MassProperties ball{.mass = 1, .com = {0.1, 0, 0}, .Theta = {1, 1, 1, 0, 0, 0}};

/// A hinge, a ball joint and a slider in a chain, on a root body that is fixed to the ground or free.
Description chain(JointKind root = JointKind::fixed) {
  return {.name = "chain",
          .bodies = {{.name = "base", .joint = {.name = "mount", .kind = root}, .inertia = ball},
                     {.name = "a",
                      .predecessor = "base",
                      .joint = {.name = "hinge", .kind = JointKind::revolute},
                      .inertia = ball},
                     {.name = "b",
                      .predecessor = "a",
                      .joint = {.name = "ball", .kind = JointKind::spherical},
                      .inertia = ball},
                     {.name = "c",
                      .predecessor = "b",
                      .joint = {.name = "slider", .kind = JointKind::prismatic},
                      .inertia = ball}},
          .frames = {{.name = "flange", .body = "c", .pose = {}}},
          .motions = {{.of = "hinge", .coefficients = {0, 1}}, {.of = "slider", .coefficients = {1}}},
          .state = InitialStateDescription{.q = {{"slider", {0.3}}, {"ball", {0, 0, 0.6, 0.8}}},
                                           .v = {{"hinge", {2}}, {"ball", {1, 2, 3}}}}};
}
Model built(Description d) { return ModelBuilder(std::move(d)).build(); }
std::vector<std::string> moved(const Model& model) {
  std::vector<std::string> names;
  for (const MotionDescription& motion : model.motions()) names.push_back(motion.of);
  return names;
}

TEST(InitialState, IsZeroAndTheIdentityWhereNothingIsNamed) {
  Description d = chain();
  EXPECT_THAT(initial_state(built(d)).q, ElementsAre(0, 0, 0, 0.6, 0.8, 0.3));
  EXPECT_THAT(initial_state(built(d)).v, ElementsAre(2, 1, 2, 3, 0));
  d.state.reset();
  EXPECT_EQ(initial_state(built(d)).q, neutral(built(d)));
  EXPECT_THAT(initial_state(built(d)).v, ElementsAre(0, 0, 0, 0, 0));
}

TEST(InitialState, IsThatOfTheJointsThatStillMoveInAReducedModel) {
  const Model model = built(chain());
  const std::vector<std::string_view> locked{"ball", "slider"};
  const Model less = reduced(model, locked, initial_state(model).q);
  EXPECT_THAT(initial_state(less).q, ElementsAre(0));
  EXPECT_THAT(initial_state(less).v, ElementsAre(2));
  EXPECT_THAT(moved(less), ElementsAre("hinge"));
}

TEST(InitialState, IsThatOfBothMechanismsAfterOneIsMounted) {
  const Model model = built(chain()), both = append(model, "flange", model, "second ");
  EXPECT_THAT(initial_state(both).q, ElementsAre(0, 0, 0, 0.6, 0.8, 0.3, 0, 0, 0, 0.6, 0.8, 0.3));
  EXPECT_THAT(initial_state(both).v, ElementsAre(2, 1, 2, 3, 0, 2, 1, 2, 3, 0));
  EXPECT_THAT(moved(both), ElementsAre("hinge", "slider", "second hinge", "second slider"));
}

TEST(InitialState, StaysWithOtherParametersGravityAndPayloads) {
  const Model model = built(chain());
  const InitialState start = initial_state(model);
  for (const Model& other :
       {with_gravity(model, {0, 0, -1}), with_payload(model, "flange", {1, {}, {1, 1, 1}})}) {
    EXPECT_EQ(initial_state(other).q, start.q);
    EXPECT_EQ(initial_state(other).v, start.v);
  }
}

TEST(InitialState, OfReversedJointsOfSeveralVelocitiesIsLeftOutWithAWarning) {
  const auto warnings = [](const Model& model) {
    std::string all;
    for (const Fault& fault : model.warnings()) all += to_string(fault) + '\n';
    return all;
  };
  const Model turned = rerooted(built(chain()), "c");
  EXPECT_THAT(warnings(turned), HasSubstr("the initial state of joint \"ball\" is left out"));
  const InitialState start = initial_state(turned);
  EXPECT_EQ(start.q[static_cast<std::size_t>(turned.joint(turned.joint_index("slider")).iq)], 0.3);
  EXPECT_EQ(start.v[static_cast<std::size_t>(turned.joint(turned.joint_index("hinge")).iv)], 2);
  EXPECT_THAT(warnings(rerooted(built(chain()), "base")), Not(HasSubstr("left out")));

  Description floating = chain(JointKind::free);
  floating.state->q.push_back({"mount", {0, 0, 0, 1, 1, 2, 3}});
  EXPECT_THAT(warnings(built(with_fixed_base(floating))), HasSubstr("joint \"mount\" is left out"));
  EXPECT_THAT(warnings(rerooted(built(floating), "a")), HasSubstr("joint \"mount\" is left out"));
}

TEST(InitialState, HasItsFaultsInCodeToo) {
  const auto fault = [](Description d) {
    std::string all;
    for (const Fault& it : ModelBuilder(std::move(d)).check()) all += to_string(it) + '\n';
    return all;
  };
  Description d = chain();
  d.state->q.push_back({"slider", {0.1}});
  EXPECT_THAT(fault(d), HasSubstr("q names joint \"slider\" twice"));
  d.state = InitialStateDescription{.v = {{"hinge", {std::numeric_limits<double>::quiet_NaN()}}}};
  EXPECT_THAT(fault(d), HasSubstr("v of joint \"hinge\" is nan; it must be finite"));
  d.state.reset();
  d.motions[0].coefficients = {std::numeric_limits<double>::infinity()};
  EXPECT_THAT(fault(d), HasSubstr("\"motion of hinge\": coefficients[0] is inf; it must be finite"));
}

}  // namespace
}  // namespace axode
