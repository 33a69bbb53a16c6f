#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <ostream>

#include "tests/model/random_mechanism.hpp"

/// Every rule that the builder checks: which fault is raised, for which element, in which words.
namespace axode {

void PrintTo(const Fault& fault, std::ostream* out) {
  *out << to_string(fault.rule) << ": " << to_string(fault);
}

namespace test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;
using testing::UnorderedElementsAre;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Two bodies in a row, without a fault.
Description two_bodies() {
  const MassProperties solid{.mass = 2, .com = {0.1, 0, 0}, .Theta = {.02, .03, .03, 0, 0, 0}};
  return {.name = "pair",
          .bodies = {{.name = "upper",
                      .joint = {.name = "shoulder",
                                .kind = JointKind::revolute,
                                .dof = {{.lower = -1, .upper = 2}}},
                      .inertia = solid},
                     {.name = "fore",
                      .predecessor = "upper",
                      .joint = {.name = "elbow", .kind = JointKind::revolute, .point = {0.4, 0, 0}},
                      .inertia = solid}},
          .frames = {{.name = "hand", .body = "fore", .pose = {{}, {0.3, 0, 0}}}}};
}
/// The same after a change to the description, to its second body or to the joint of that.
Description with(const std::function<void(Description&)>& change) {
  Description description = two_bodies();
  change(description);
  return description;
}
Description with_body(const std::function<void(BodyDescription&)>& change) {
  return with([&](Description& d) { change(d.bodies[1]); });
}
Description with_joint(const std::function<void(JointDescription&)>& change) {
  return with([&](Description& d) { change(d.bodies[1].joint); });
}

/// What build() throws: the faults of a ModelError, or none.
std::vector<Fault> faults(const Description& description, Strictness strictness = Strictness::strict) {
  try {
    ModelBuilder(description).build(strictness);
  } catch (const ModelError& error) {
    return {error.faults().begin(), error.faults().end()};
  }
  return {};
}

auto says(Rule rule, const char* element, const testing::Matcher<const std::string&>& message,
          Severity severity = Severity::error) {
  return AllOf(Field("severity", &Fault::severity, severity), Field("rule", &Fault::rule, rule),
               Field("element", &Fault::element, element), Field("message", &Fault::message, message));
}

TEST(Faults, ASoundDescriptionHasNone) {
  EXPECT_THAT(faults(two_bodies()), IsEmpty());
  EXPECT_THAT(ModelBuilder(two_bodies()).check(), IsEmpty());
  EXPECT_EQ(ModelBuilder(two_bodies()).build().n_bodies(), 2);
}

// ----------------------------------------------------------------------------------------------------- names

TEST(Faults, EveryBodyAndFrameNeedsAName) {
  EXPECT_THAT(
      faults(with_body([](auto& b) { b.name = ""; })),
      ElementsAre(
          says(Rule::missing_name, "body \"\"", "has no name; every body and frame needs one"),
          says(Rule::unknown_frame_body, "frame \"hand\"", "sits on body \"fore\", which is not described")));
  EXPECT_THAT(
      faults(with([](auto& d) { d.frames[0].name = ""; })),
      ElementsAre(says(Rule::missing_name, "frame \"\"", "has no name; every body and frame needs one")));
  EXPECT_THAT(faults({.bodies = {{.name = ""}, {.name = ""}, {.name = "", .predecessor = ""}}}),
              ElementsAre(says(Rule::missing_name, "body \"\"", testing::_),
                          says(Rule::missing_name, "body \"\"", testing::_),
                          says(Rule::missing_name, "body \"\"", testing::_)))
      << "namelessness is one fault for each body, no clash of names";
}

TEST(Faults, NamesOfBodiesAndFramesDiffer) {
  const char* taken = "the name is taken; names of bodies and frames must differ";
  EXPECT_THAT(faults(with([](auto& d) { d.bodies.push_back({.name = "fore", .predecessor = "upper"}); })),
              ElementsAre(says(Rule::duplicate_name, "body \"fore\"", taken)));
  EXPECT_THAT(faults(with([](auto& d) { d.frames.push_back({.name = "hand", .body = "upper"}); })),
              ElementsAre(says(Rule::duplicate_name, "frame \"hand\"", taken)));
  EXPECT_THAT(faults(with([](auto& d) { d.frames[0].name = "upper"; })),
              ElementsAre(says(Rule::duplicate_name, "frame \"upper\"", taken)));
}

TEST(Faults, GroundIsTheNameOfTheInertialFrameAlone) {
  const char* ground = "\"ground\" names the inertial frame; choose another name";
  EXPECT_THAT(faults(with([](auto& d) { d.bodies.push_back({.name = "ground"}); })),
              ElementsAre(says(Rule::duplicate_name, "body \"ground\"", ground)));
  EXPECT_THAT(faults(with([](auto& d) { d.bodies.push_back({.name = "ground", .predecessor = "fore"}); })),
              ElementsAre(says(Rule::duplicate_name, "body \"ground\"", ground)))
      << "no cycle: bodies on the ground hang on the inertial frame";
  EXPECT_THAT(faults(with([](auto& d) { d.frames[0].name = "ground"; })),
              ElementsAre(says(Rule::duplicate_name, "frame \"ground\"", ground)));
}

TEST(Faults, NamesOfJointsDiffer) {
  const char* taken = "the name is taken; names of joints must differ";
  EXPECT_THAT(faults(with_joint([](auto& j) { j.name = "shoulder"; })),
              ElementsAre(says(Rule::duplicate_name, "joint \"shoulder\"", taken)));
  EXPECT_THAT(faults(with([](auto& d) {
                d.bodies[0].joint.name = "";
                d.bodies[1].joint.name = "upper_joint";
              })),
              ElementsAre(says(Rule::duplicate_name, "joint \"upper_joint\"", taken)))
      << "the name that a nameless joint gets counts";
  EXPECT_THAT(faults(with_joint([](auto& j) { j.name = "upper"; })), IsEmpty())
      << "a joint may be called as a body is";
}

TEST(Faults, NamesOfThePartsOfAJointAreTaken) {
  const auto cylindrical = [](Description& d) {
    d.bodies[0].joint.kind = JointKind::cylindrical;
    d.bodies[0].joint.dof = {};
  };
  EXPECT_THAT(faults(with(cylindrical)), IsEmpty());
  EXPECT_THAT(faults(with([&](auto& d) {
                cylindrical(d);
                d.bodies[1].joint.name = "shoulder.rotation";
              })),
              ElementsAre(says(Rule::duplicate_name, "joint \"shoulder.rotation\"",
                               "the name is taken; names of joints must differ")));
  EXPECT_THAT(faults(with([&](auto& d) {
                cylindrical(d);
                d.frames[0].name = "shoulder.sleeve";
              })),
              ElementsAre(says(Rule::duplicate_name, "frame \"shoulder.sleeve\"",
                               "the name is taken; names of bodies and frames must differ")));
  EXPECT_THAT(faults(with([](auto& d) {
                d.bodies[0].name = "elbow.cross";
                d.bodies[1].predecessor = "elbow.cross";
                d.bodies[1].joint.kind = JointKind::universal;
              })),
              ElementsAre(says(Rule::duplicate_name, "body \"elbow.cross\" of joint \"elbow\"",
                               "the name is taken; names of bodies and frames must differ")));
}

// -------------------------------------------------------------------------------------------------- the tree

TEST(Faults, APredecessorMustBeDescribed) {
  EXPECT_THAT(faults(with_body([](auto& b) { b.predecessor = "uper"; })),
              ElementsAre(says(Rule::unknown_predecessor, "body \"fore\"",
                               "hangs on body \"uper\", which is not described; did you mean \"upper\"?")));
  EXPECT_THAT(
      faults(with_body([](auto& b) { b.predecessor = "gruond"; })),
      ElementsAre(says(Rule::unknown_predecessor, "body \"fore\"",
                       "hangs on body \"gruond\", which is not described; did you mean \"ground\"?")));
  EXPECT_THAT(faults(with_body([](auto& b) { b.predecessor = "chassis"; })),
              ElementsAre(says(Rule::unknown_predecessor, "body \"fore\"",
                               "hangs on body \"chassis\", which is not described")));
  EXPECT_THAT(faults(with_body([](auto& b) { b.predecessor = "for"; })),
              ElementsAre(says(Rule::unknown_predecessor, "body \"fore\"",
                               "hangs on body \"for\", which is not described")))
      << "a body is not told to hang on itself";
  EXPECT_THAT(faults(with_body([](auto& b) { b.predecessor = ""; })),
              ElementsAre(says(Rule::unknown_predecessor, "body \"fore\"",
                               "hangs on body \"\", which is not described")));
}

TEST(Faults, ABodyHasOnePredecessor) {
  EXPECT_THAT(
      faults(with([](auto& d) { d.bodies.push_back({.name = "fore"}); })),
      ElementsAre(says(Rule::two_predecessors, "body \"fore\"",
                       "has two predecessors, \"upper\" and \"ground\"; in a tree every body has one")));
}

TEST(Faults, ACycleIsToldFromBodyToBody) {
  EXPECT_THAT(faults(with_body([](auto& b) { b.predecessor = "fore"; })),
              ElementsAre(says(
                  Rule::cycle, "body \"fore\"",
                  "closes a cycle: \"fore\" on \"fore\"; every body must hang on the ground in the end")));
  EXPECT_THAT(
      faults(with([](auto& d) { d.bodies[0].predecessor = "fore"; })),
      ElementsAre(says(Rule::cycle, "body \"upper\"",
                       "closes a cycle: \"upper\" on \"fore\" on \"upper\"; every body must hang on the "
                       "ground in the end")));
}

TEST(Faults, EveryCycleIsReportedOnceHoweverManyBodiesHangOnIt) {
  const auto body = [](const char* name, const char* predecessor) {
    return BodyDescription{.name = name, .predecessor = predecessor};
  };
  const std::vector<Fault> found = faults(
      {.bodies = {body("tail", "a"), body("a", "b"), body("b", "a"), body("sound", "ground"), body("c", "d"),
                  body("d", "e"), body("e", "c"), body("tail of c", "e"), body("self", "self")}});
  EXPECT_THAT(
      found,
      ElementsAre(
          says(Rule::cycle, "body \"a\"", StartsWith("closes a cycle: \"a\" on \"b\" on \"a\";")),
          says(Rule::cycle, "body \"c\"", StartsWith("closes a cycle: \"c\" on \"d\" on \"e\" on \"c\";")),
          says(Rule::cycle, "body \"self\"", StartsWith("closes a cycle: \"self\" on \"self\";"))));
}

TEST(Faults, ALongCycleIsFound) {
  const int n = 5000;
  Description ring;
  for (int i = 0; i < n; ++i)
    ring.bodies.push_back({.name = std::to_string(i), .predecessor = std::to_string((i + n - 1) % n)});
  const std::vector<Fault> found = faults(ring);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].rule, Rule::cycle);
  EXPECT_THAT(found[0].message, HasSubstr("\"0\" on \"4999\" on \"4998\""));
}

TEST(Faults, CyclesAmongBodiesOfOneNameEnd) {
  const std::vector<BodyDescription> twins{{.name = "a", .predecessor = "b"},
                                           {.name = "b", .predecessor = "a"},
                                           {.name = "a", .predecessor = "a"},
                                           {.name = "b", .predecessor = "ground"},
                                           {.name = "", .predecessor = ""}};
  EXPECT_THAT(faults({.bodies = twins}),
              UnorderedElementsAre(
                  says(Rule::two_predecessors, "body \"a\"", HasSubstr("\"b\" and \"a\"")),
                  says(Rule::two_predecessors, "body \"b\"", HasSubstr("\"a\" and \"ground\"")),
                  says(Rule::missing_name, "body \"\"", testing::_),
                  says(Rule::cycle, "body \"a\"", testing::_), says(Rule::cycle, "body \"\"", testing::_)));
}

TEST(Faults, AFrameSitsOnABodyThatIsDescribed) {
  EXPECT_THAT(faults(with([](auto& d) { d.frames[0].body = "four"; })),
              ElementsAre(says(Rule::unknown_frame_body, "frame \"hand\"",
                               "sits on body \"four\", which is not described; did you mean \"fore\"?")));
  EXPECT_THAT(faults(with([](auto& d) { d.frames[0].body = "hand"; })),
              ElementsAre(says(Rule::unknown_frame_body, "frame \"hand\"",
                               StartsWith("sits on body \"hand\", which"))))
      << "frames do not carry frames";
  EXPECT_THAT(faults(with([](auto& d) { d.frames[0].body = "ground"; })), IsEmpty());
}

TEST(Faults, AFreeBaseNeedsExactlyOneBodyFixedToTheGround) {
  const auto count = [](const Description& description) -> std::string {
    try {
      with_free_base(description);
    } catch (const ModelError& error) {
      EXPECT_EQ(error.faults().size(), 1u);
      EXPECT_EQ(error.faults()[0].rule, Rule::no_base);
      EXPECT_EQ(error.faults()[0].element, "model \"pair\"");
      return error.faults()[0].message;
    }
    return "";
  };
  const std::string rest = " bodies are fixed to the ground; a free base needs exactly one to set free";
  EXPECT_EQ(count(two_bodies()), "0" + rest);
  EXPECT_EQ(count(with([](auto& d) {
              d.bodies.push_back({.name = "left foot"});
              d.bodies.push_back({.name = "right foot"});
            })),
            "2" + rest);
  EXPECT_EQ(count(with([](auto& d) { d.bodies.push_back({.name = "foot"}); })), "");
}

// ------------------------------------------------------------------------------------------ mass and inertia

TEST(Faults, AMassIsPositive) {
  EXPECT_THAT(faults(with_body([](auto& b) { b.inertia->mass = -1.25; })),
              ElementsAre(says(Rule::mass_not_positive, "body \"fore\"",
                               "mass is -1.25 kg; a mass must be positive")));
  EXPECT_THAT(
      faults(with_body([](auto& b) { b.inertia->mass = 0; })),
      ElementsAre(says(Rule::mass_not_positive, "body \"fore\"",
                       "mass is 0; a mass must be positive, and a massless body needs no mass at all")));
}

TEST(Faults, AnInertiaIsThatOfSomeDensity) {
  // Principal moments 1, 1, 3 about the centre of mass: 3 exceeds 1 + 1 by a third of itself.
  const auto disc = [](BodyDescription& b) {
    b.inertia = MassProperties{.mass = 1, .com = {0.5, 0.1, -0.2}, .Theta = {1, 1, 3, 0, 0, 0}};
  };
  const char* message =
      "no density can produce its inertia: a principal moment about the centre of mass exceeds the sum of "
      "the other "
      "two by 33.33 % of the largest, or is negative";
  EXPECT_THAT(faults(with_body(disc)),
              ElementsAre(says(Rule::inertia_not_realisable, "body \"fore\"", message)));
  EXPECT_THAT(faults(with_body([&](auto& b) {
                disc(b);
                b.inertia->axes = exp_SO3(Vec3<>{0.3, -2, 1});
              })),
              ElementsAre(says(Rule::inertia_not_realisable, "body \"fore\"", message)))
      << "in any axes";
  EXPECT_THAT(
      faults(with_body([](auto& b) {
        b.inertia = MassProperties{
            .mass = 1, .com = {1, 0, 0}, .Theta = {.5, .5, .5, 0, 0, 0}, .about = InertiaAbout::frame_origin};
      })),
      ElementsAre(says(Rule::inertia_not_realisable, "body \"fore\"", HasSubstr("no density"))))
      << "less about the origin than the mass itself makes there";
  EXPECT_THAT(faults(with_body([](auto& b) { b.inertia->Theta = {-1, -1, -1, 0, 0, 0}; })),
              ElementsAre(says(Rule::inertia_not_realisable, "body \"fore\"", HasSubstr("negative"))));
}

TEST(Faults, RodsPlatesAndPointMassesArePermitted) {
  for (const Sym3<>& Theta : {Sym3<>{1, 1, 0, 0, 0, 0}, Sym3<>{1, 2, 3, 0, 0, 0}, Sym3<>{}})
    EXPECT_THAT(faults(with_body([&](auto& b) {
                  b.inertia = MassProperties{
                      .mass = 1, .com = {1, 2, 3}, .Theta = Theta, .axes = exp_SO3(Vec3<>{1, 2, 3})};
                })),
                IsEmpty());
}

TEST(Faults, LenientBuildsMakeWarningsOfTheTwoPhysicalRulesAndOfNoOther) {
  const Description impossible = with([](auto& d) {
    d.bodies[0].inertia->Theta = {1, 1, 3, 0, 0, 0};
    d.bodies[1].inertia->mass = 0;
  });
  EXPECT_EQ(faults(impossible).size(), 2u);
  const Model model = ModelBuilder(impossible).build();
  const std::vector<Fault> warnings(model.warnings().begin(), model.warnings().end());
  EXPECT_THAT(
      warnings,
      ElementsAre(
          says(Rule::inertia_not_realisable, "body \"upper\"", HasSubstr("33.33 %"), Severity::warning),
          says(Rule::mass_not_positive, "body \"fore\"", StartsWith("mass is 0;"), Severity::warning),
          says(Rule::moves_no_mass, "joint \"elbow\"",
               StartsWith("moves no mass; the mass matrix is singular: give"), Severity::warning)));
  EXPECT_EQ(model.total_mass(), 2.0);
  EXPECT_THAT(
      faults(with_body([](auto& b) { b.inertia->mass = -1; }), Strictness::lenient),
      ElementsAre(says(Rule::mass_not_positive, "body \"fore\"", "mass is -1 kg; a mass must be positive")));
  EXPECT_THAT(faults(with_joint([](auto& j) { j.axis = {}; }), Strictness::lenient),
              ElementsAre(says(Rule::zero_axis, "joint \"elbow\"", testing::_)));
}

TEST(Faults, AJointThatMovesNoMassIsAWarning) {
  const auto warnings = [](const Description& description) {
    const Model model = ModelBuilder(description).build();
    EXPECT_EQ(ModelBuilder(description).check().size(), model.warnings().size());
    return std::vector<Fault>(model.warnings().begin(), model.warnings().end());
  };
  const auto massless = [](Description& d) { d.bodies[1].inertia.reset(); };
  EXPECT_THAT(warnings(two_bodies()), IsEmpty());
  EXPECT_THAT(
      warnings(with(massless)),
      ElementsAre(says(Rule::moves_no_mass, "joint \"elbow\"",
                       StartsWith("moves no mass; the mass matrix is singular: give"), Severity::warning)));
  EXPECT_THAT(warnings(with([](auto& d) { d.bodies[0].inertia.reset(); })), IsEmpty())
      << "the fore arm hangs on it";
  EXPECT_THAT(warnings(with([&](auto& d) {
                massless(d);
                d.bodies[1].joint.dof = {{.armature = 0.1}};
              })),
              IsEmpty())
      << "the drive has inertia";
  EXPECT_THAT(
      warnings(with([&](auto& d) {
        massless(d);
        d.bodies.push_back({.name = "glove", .predecessor = "fore", .inertia = MassProperties{.mass = 1}});
      })),
      IsEmpty())
      << "a body with mass is fixed to it";
  EXPECT_THAT(warnings(with([&](auto& d) {
                massless(d);
                d.bodies.push_back(d.bodies[0]);
                d.bodies[2].name = "finger";
                d.bodies[2].joint = {
                    .name = "knuckle", .kind = JointKind::revolute, .coupling = Coupling{"elbow", -1}};
              })),
              IsEmpty())
      << "a joint that follows it moves mass";
}

// ---------------------------------------------------------------------------------------------------- joints

TEST(Faults, AnAxisHasADirection) {
  const char* message = "an axis is (0, 0, 0); an axis needs a direction";
  for (const JointKind kind : {JointKind::revolute, JointKind::prismatic, JointKind::helical,
                               JointKind::cylindrical, JointKind::universal, JointKind::planar})
    EXPECT_THAT(faults(with_joint([&](auto& j) {
                  j.kind = kind;
                  j.axis = {0, -0.0, 0};
                })),
                ElementsAre(says(Rule::zero_axis, "joint \"elbow\"", message)))
        << to_string(kind);
  for (const JointKind kind : {JointKind::fixed, JointKind::spherical, JointKind::free})
    EXPECT_THAT(faults(with_joint([&](auto& j) {
                  j.kind = kind;
                  j.axis = {};
                })),
                IsEmpty())
        << to_string(kind) << " needs no axis";
  EXPECT_THAT(faults(with_joint([](auto& j) {
                j.kind = JointKind::universal;
                j.second_axis = {};
              })),
              ElementsAre(says(Rule::zero_axis, "joint \"elbow\"", message)));
}

TEST(Faults, AxesOfAUniversalJointAreNotParallel) {
  const auto axes = [](const Vec3<>& first, const Vec3<>& second) {
    return faults(
        with_joint([&](auto& j) { j.kind = JointKind::universal, j.axis = first, j.second_axis = second; }));
  };
  const auto parallel =
      ElementsAre(says(Rule::parallel_axes, "joint \"elbow\"",
                       "its two axes are parallel; the axes of a universal joint must not be parallel"));
  EXPECT_THAT(axes({1, 2, 3}, {-2, -4, -6}), parallel);
  EXPECT_THAT(axes({0, 0, 1}, {1e-7, 0, 1}), parallel);
  EXPECT_THAT(axes({0, 0, 1e-200}, {0, 0, 1e200}), parallel);
  EXPECT_THAT(axes({0, 0, 1}, {1e-5, 0, 1}), IsEmpty());
  EXPECT_THAT(axes({0, 0, 1e-200}, {1e200, 0, 0}), IsEmpty());
}

TEST(Faults, OnlyHelicalJointsHaveAPitch) {
  for (const JointKind kind :
       {JointKind::fixed, JointKind::revolute, JointKind::prismatic, JointKind::cylindrical,
        JointKind::universal, JointKind::spherical, JointKind::planar, JointKind::free})
    EXPECT_THAT(faults(with_joint([&](auto& j) { j.kind = kind, j.pitch = 0.02; })),
                ElementsAre(says(Rule::pitch_without_helix, "joint \"elbow\"",
                                 "has a pitch of 0.02 m/rad but is " + std::string(to_string(kind)) +
                                     "; only helical joints have a pitch")));
  EXPECT_THAT(faults(with_joint([](auto& j) { j.kind = JointKind::helical, j.pitch = -0.02; })), IsEmpty());
}

TEST(Faults, DegreesOfFreedomAreDescribedAllOrNot) {
  const std::vector<std::pair<JointKind, int>> kinds{
      {JointKind::fixed, 0},     {JointKind::revolute, 1},  {JointKind::prismatic, 1},
      {JointKind::helical, 1},   {JointKind::universal, 2}, {JointKind::cylindrical, 2},
      {JointKind::spherical, 3}, {JointKind::planar, 3},    {JointKind::free, 6}};
  for (const auto& [kind, n] : kinds)
    for (int described = 0; described <= 7; ++described) {
      const std::vector<Fault> found = faults(with_joint([&, kind = kind](auto& j) {
        j.kind = kind;
        j.dof.resize(static_cast<std::size_t>(described));
      }));
      if (described == 0 || described == n) {
        EXPECT_THAT(found, IsEmpty()) << to_string(kind);
      } else {
        EXPECT_THAT(found,
                    ElementsAre(says(Rule::degrees_of_freedom, "joint \"elbow\"",
                                     "describes " + std::to_string(described) + " degrees of freedom; a " +
                                         std::string(to_string(kind)) + " joint has " + std::to_string(n))));
      }
    }
}

TEST(Faults, LimitsLeaveRoom) {
  const auto limits = [](double lower, double upper) {
    return faults(with_joint([&](auto& j) { j.dof = {{.lower = lower, .upper = upper}}; }));
  };
  EXPECT_THAT(limits(0.5, -0.25), ElementsAre(says(Rule::limits_crossed, "joint \"elbow\"",
                                                   "lower limit 0.5 is above upper limit -0.25")));
  EXPECT_THAT(limits(infinity, -infinity), ElementsAre(says(Rule::limits_crossed, "joint \"elbow\"",
                                                            "lower limit inf is above upper limit -inf")));
  EXPECT_THAT(limits(infinity, infinity),
              ElementsAre(says(Rule::limits_crossed, "joint \"elbow\"",
                               "limits inf and inf allow no position; the lower limit must be below inf and "
                               "the upper one above -inf")));
  EXPECT_THAT(limits(-infinity, -infinity),
              ElementsAre(says(Rule::limits_crossed, "joint \"elbow\"",
                               "limits -inf and -inf allow no position; the lower limit must be below inf "
                               "and the upper one above -inf")));
  EXPECT_THAT(limits(0.5, 0.5), IsEmpty());
  EXPECT_THAT(limits(-12, 12), IsEmpty());
  EXPECT_THAT(limits(-1000, 62.83), IsEmpty());
  EXPECT_THAT(limits(-infinity, 0), IsEmpty());
  EXPECT_THAT(limits(0, infinity), IsEmpty());
  EXPECT_THAT(limits(-infinity, infinity), IsEmpty());
}

TEST(Faults, WhatBrakesIsNotNegative) {
  const auto negative = [](const std::function<void(Dof&)>& change, const char* what) {
    EXPECT_THAT(faults(with_joint([&](auto& j) {
                  j.dof.resize(1);
                  change(j.dof[0]);
                })),
                ElementsAre(says(Rule::negative_value, "joint \"elbow\"",
                                 std::string(what) + " is -0.5; it must not be negative")));
  };
  negative([](Dof& d) { d.damping = -0.5; }, "damping");
  negative([](Dof& d) { d.friction = -0.5; }, "friction");
  negative([](Dof& d) { d.armature = -0.5; }, "armature");
  negative([](Dof& d) { d.velocity = -0.5; }, "velocity limit");
  negative([](Dof& d) { d.effort = -0.5; }, "effort limit");
}

// ------------------------------------------------------------------------------------------------- couplings

Description coupled(const std::string& leader, JointKind kind = JointKind::revolute) {
  return with_joint([&](auto& j) {
    j.kind = kind;
    j.coupling = Coupling{leader, 2, 0.1};
  });
}

TEST(Faults, AJointFollowsAJointThatIsDescribed) {
  EXPECT_THAT(faults(coupled("shoulder")), IsEmpty());
  EXPECT_THAT(
      faults(coupled("shuolder")),
      ElementsAre(says(Rule::coupling_unknown_joint, "joint \"elbow\"",
                       "follows joint \"shuolder\", which is not described; did you mean \"shoulder\"?")));
  EXPECT_THAT(faults(coupled("knee joint")),
              ElementsAre(says(Rule::coupling_unknown_joint, "joint \"elbow\"",
                               "follows joint \"knee joint\", which is not described")));
  EXPECT_THAT(faults(coupled("upper")),
              ElementsAre(says(Rule::coupling_unknown_joint, "joint \"elbow\"",
                               StartsWith("follows joint \"upper\", which is not described"))))
      << "a leader is a joint, not a body";
}

TEST(Faults, OnlyJointsWithOneDegreeOfFreedomFollowAndLead) {
  for (const JointKind kind : {JointKind::fixed, JointKind::cylindrical, JointKind::universal,
                               JointKind::spherical, JointKind::planar, JointKind::free}) {
    EXPECT_THAT(
        faults(coupled("shoulder", kind)),
        ElementsAre(
            says(Rule::coupling_kind, "joint \"elbow\"",
                 "is " + std::string(to_string(kind)) +
                     " and coupled; only revolute, prismatic and helical joints can follow another joint")));
    Description leader = coupled("shoulder");
    leader.bodies[0].joint.kind = kind;
    leader.bodies[0].joint.dof = {};
    const bool splits = kind == JointKind::cylindrical || kind == JointKind::universal;
    EXPECT_THAT(faults(leader),
                ElementsAre(says(splits ? Rule::coupling_unknown_joint : Rule::coupling_kind,
                                 "joint \"elbow\"", StartsWith("follows joint \"shoulder\", which is "))))
        << to_string(kind);
  }
  for (const JointKind kind : one_dof_kinds) EXPECT_THAT(faults(coupled("shoulder", kind)), IsEmpty());
}

TEST(Faults, HalfOfACylindricalOrUniversalJointMayLead) {
  const auto on = [](JointKind kind, const char* leader) {
    Description description = coupled(leader);
    description.bodies[0].joint.kind = kind;
    description.bodies[0].joint.dof = {};
    return faults(description);
  };
  EXPECT_THAT(on(JointKind::cylindrical, "shoulder.rotation"), IsEmpty());
  EXPECT_THAT(on(JointKind::cylindrical, "shoulder.translation"), IsEmpty());
  EXPECT_THAT(on(JointKind::universal, "shoulder.first"), IsEmpty());
  EXPECT_THAT(on(JointKind::universal, "shoulder.second"), IsEmpty());
  EXPECT_THAT(on(JointKind::universal, "shoulder.third"),
              ElementsAre(says(Rule::coupling_unknown_joint, "joint \"elbow\"",
                               HasSubstr("did you mean \"shoulder."))));
}

TEST(Faults, CouplingsEndAtAJointWithACoordinateOfItsOwn) {
  const char* rest = " in a loop; one joint must have a coordinate of its own";
  EXPECT_THAT(faults(coupled("elbow")), ElementsAre(says(Rule::coupling_loop, "joint \"elbow\"",
                                                         "follows joint \"elbow\"" + std::string(rest))));
  Description mutual = coupled("shoulder");
  mutual.bodies[0].joint.coupling = Coupling{"elbow"};
  EXPECT_THAT(
      faults(mutual),
      ElementsAre(
          says(Rule::coupling_loop, "joint \"shoulder\"", "follows joint \"elbow\"" + std::string(rest)),
          says(Rule::coupling_loop, "joint \"elbow\"", "follows joint \"shoulder\"" + std::string(rest))));
  mutual.bodies.push_back(
      {.name = "outside", .joint = {.kind = JointKind::prismatic, .coupling = Coupling{"elbow"}}});
  EXPECT_EQ(faults(mutual).size(), 3u) << "whoever follows a loop has no coordinate either";
}

TEST(Faults, ALongLoopOfCouplingsIsFound) {
  const int n = 5000;
  Description ring;
  for (int i = 0; i < n; ++i)
    ring.bodies.push_back({.name = numbered('b', i),
                           .joint = {.name = numbered('j', i),
                                     .kind = JointKind::revolute,
                                     .coupling = Coupling{numbered('j', (i + 1) % n)}},
                           .inertia = MassProperties{.mass = 1}});
  const std::vector<Fault> found = faults(ring);
  ASSERT_EQ(found.size(), static_cast<std::size_t>(n));
  for (const Fault& fault : found) EXPECT_EQ(fault.rule, Rule::coupling_loop);
  ring.bodies[0].joint.coupling.reset();
  EXPECT_THAT(faults(ring), IsEmpty());
}

// ---------------------------------------------------------------------------------- numbers and rotations

TEST(Faults, EveryNumberIsFinite) {
  struct Field {
    const char* element;
    const char* message;
    std::function<void(Description&, double)> set;
  };
  const char* body = "body \"fore\"";
  const char* joint = "joint \"elbow\"";
  const auto dof = [](Description& d) -> Dof& {
    d.bodies[1].joint.dof.resize(1);
    return d.bodies[1].joint.dof[0];
  };
  const auto set_frame = [](SE3<>& C, int k, double x) {
    double* number[] = {&C.r.x, &C.r.y, &C.r.z, &C.R.x.x, &C.R.x.y, &C.R.y.y, &C.R.z.z, &C.R.y.z};
    *number[k] = x;
  };
  std::vector<Field> fields{
      {joint, "axis is not finite", [](auto& d, double x) { d.bodies[1].joint.axis.x = x; }},
      {joint, "axis is not finite", [](auto& d, double x) { d.bodies[1].joint.axis.y = x; }},
      {joint, "axis is not finite", [](auto& d, double x) { d.bodies[1].joint.axis.z = x; }},
      {joint, "second axis is not finite", [](auto& d, double x) { d.bodies[1].joint.second_axis.z = x; }},
      {joint, "point is not finite", [](auto& d, double x) { d.bodies[1].joint.point.y = x; }},
      {joint, "pitch is not finite",
       [](auto& d, double x) {
         d.bodies[1].joint.kind = JointKind::helical;
         d.bodies[1].joint.pitch = x;
       }},
      {joint, "damping, friction or armature is not finite", [&](auto& d, double x) { dof(d).damping = x; }},
      {joint, "damping, friction or armature is not finite", [&](auto& d, double x) { dof(d).friction = x; }},
      {joint, "damping, friction or armature is not finite", [&](auto& d, double x) { dof(d).armature = x; }},
      {joint, "the coupling is not finite",
       [](auto& d, double x) {
         d.bodies[1].joint.coupling = Coupling{"shoulder", x, 0};
       }},
      {joint, "the coupling is not finite",
       [](auto& d, double x) {
         d.bodies[1].joint.coupling = Coupling{"shoulder", 1, x};
       }},
      {body, "mass is not finite", [](auto& d, double x) { d.bodies[1].inertia->mass = x; }},
      {body, "centre of mass is not finite", [](auto& d, double x) { d.bodies[1].inertia->com.z = x; }},
      {body, "rotational inertia is not finite",
       [](auto& d, double x) { d.bodies[1].inertia->Theta.yy = x; }},
      {body, "rotational inertia is not finite",
       [](auto& d, double x) { d.bodies[1].inertia->Theta.yz = x; }},
      {body, "the axes of the inertia is not finite",
       [](auto& d, double x) { d.bodies[1].inertia->axes.y.z = x; }},
      {body, "the pose of a mesh is not finite",
       [](auto& d, double x) {
         d.bodies[1].shapes = {{.kind = ShapeKind::mesh, .pose = {{}, {0, x, 0}}, .file = "fore.stl"}};
       }},
      {body, "the scale of a mesh is not finite",
       [](auto& d, double x) {
         d.bodies[1].shapes = {{.kind = ShapeKind::mesh, .file = "fore.stl", .scale = {1, 1, x}}};
       }},
      {"gravity", "a component is not finite; give three numbers in m/s²",
       [](auto& d, double x) { d.gravity.z = x; }}};
  for (int k = 0; k < 8; ++k) {
    fields.push_back({body, "A is not finite", [=](auto& d, double x) {
                        InConstructionFrame drawn;
                        set_frame(drawn.A, k, x);
                        d.bodies[1].geometry = drawn;
                      }});
    fields.push_back({body, "B is not finite", [=](auto& d, double x) {
                        InBodyFrame in_body;
                        set_frame(in_body.B, k, x);
                        d.bodies[1].geometry = in_body;
                      }});
    fields.push_back({joint, "S_prev is not finite", [=](auto& d, double x) {
                        InJointFrames frames;
                        set_frame(frames.S_prev, k, x);
                        d.bodies[1].geometry = frames;
                      }});
    fields.push_back({joint, "S_self is not finite", [=](auto& d, double x) {
                        InJointFrames frames;
                        set_frame(frames.S_self, k, x);
                        d.bodies[1].geometry = frames;
                      }});
    fields.push_back({"frame \"hand\"", "pose is not finite",
                      [=](auto& d, double x) { set_frame(d.frames[0].pose, k, x); }});
  }
  for (const Field& field : fields)
    for (const double x : {nan, infinity, -infinity})
      EXPECT_THAT(faults(with([&](auto& d) { field.set(d, x); })),
                  ElementsAre(says(Rule::non_finite_number, field.element, field.message)))
          << "with " << x;
}

TEST(Faults, LimitsMayBeInfiniteButNotUndefined) {
  const auto limit = [](double Dof::*which, double x) {
    return faults(with_joint([&](auto& j) {
      j.dof.resize(1);
      j.dof[0].*which = x;
    }));
  };
  for (const auto which : {&Dof::lower, &Dof::upper, &Dof::velocity, &Dof::effort})
    EXPECT_THAT(limit(which, nan),
                ElementsAre(says(Rule::non_finite_number, "joint \"elbow\"", "a limit is not finite")));
  for (const auto which : {&Dof::upper, &Dof::velocity, &Dof::effort})
    EXPECT_THAT(limit(which, infinity), IsEmpty());
  EXPECT_THAT(limit(&Dof::lower, -infinity), IsEmpty());
}

TEST(Faults, NumbersThatOverflowAreNotFiniteEither) {
  EXPECT_THAT(faults(with_body([](auto& b) {
                b.inertia->com = {1e200, 0, 0};
              })),
              ElementsAre(says(Rule::non_finite_number, "body \"fore\"",
                               "its numbers are so large that its pose, inertia or coupling overflows")));
  EXPECT_THAT(faults(with([](auto& d) {
                d.bodies[1].geometry = InConstructionFrame{{exp_SO3(Vec3<>{0, 0, 0.7}), {}}};
                d.frames[0].pose.r = {1.7e308, 1.7e308, 0};
                d.frames[0].in = GivenIn::construction_frame;
              })),
              ElementsAre(says(Rule::non_finite_number, "frame \"hand\"",
                               "its numbers are so large that its pose overflows")));
}

/// A rotation sheared and stretched, so that RᵀR is off the identity by `off`.
SO3<> distorted(double off) {
  SO3<> R = exp_SO3(Vec3<>{0.3, -0.4, 0.5});
  R.x += off * R.y;
  R.z = (1 + 0.4 * off) * R.z;
  return R;
}

/// One of the places for a rotation: how to put one there, and which element and thing a fault should name.
struct Place {
  const char* element;
  const char* thing;
  std::function<void(Description&, const SO3<>&)> set;
};
const std::vector<Place>& places_of_rotations() {
  static const std::vector<Place> places{
      {"body \"fore\"", "A",
       [](auto& d, const SO3<>& R) {
         d.bodies[1].geometry = InConstructionFrame{{R, {}}};
       }},
      {"body \"fore\"", "B",
       [](auto& d, const SO3<>& R) {
         d.bodies[1].geometry = InBodyFrame{{R, {}}};
       }},
      {"joint \"elbow\"", "S_prev",
       [](auto& d, const SO3<>& R) {
         d.bodies[1].geometry = InJointFrames{{R, {}}, {}};
       }},
      {"joint \"elbow\"", "S_self",
       [](auto& d, const SO3<>& R) {
         d.bodies[1].geometry = InJointFrames{{}, {R, {}}};
       }},
      {"body \"fore\"", "the axes of the inertia",
       [](auto& d, const SO3<>& R) { d.bodies[1].inertia->axes = R; }},
      {"body \"fore\"", "the pose of a mesh",
       [](auto& d, const SO3<>& R) {
         d.bodies[1].shapes = {{.kind = ShapeKind::mesh, .pose = {R, {}}, .file = "fore.stl"}};
       }},
      {"frame \"hand\"", "pose", [](auto& d, const SO3<>& R) {
         d.frames[0].pose = {R, {}};
       }}};
  return places;
}

TEST(Faults, ARotationIsOneToAMillionth) {
  for (const Place& place : places_of_rotations()) {
    const auto found = [&](const SO3<>& R) { return faults(with([&](auto& d) { place.set(d, R); })); };
    const std::string thing = place.thing;
    for (const double off : {1.0, 1e-2, 1.1e-6, -1.1e-6})
      EXPECT_THAT(found(distorted(off)),
                  ElementsAre(says(Rule::not_a_rotation, place.element,
                                   AllOf(StartsWith(thing + " is off a rotation by "),
                                         testing::EndsWith("; RᵀR must be the identity to 1e-6")))))
          << off;
    EXPECT_THAT(found(SO3<>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1.25}}),
                ElementsAre(says(Rule::not_a_rotation, place.element,
                                 thing + " is off a rotation by 0.5625; RᵀR must be the identity to 1e-6")));
    EXPECT_THAT(found(SO3<>{{}, {}, {}}),
                ElementsAre(says(Rule::not_a_rotation, place.element,
                                 thing + " is off a rotation by 1; RᵀR must be the identity to 1e-6")));
    EXPECT_THAT(found(SO3<>{{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}),
                ElementsAre(says(Rule::not_a_rotation, place.element,
                                 thing + " mirrors; a rotation has determinant +1")));
    for (const double off : {0.9e-6, 1e-8, -1e-8, 0.0}) EXPECT_THAT(found(distorted(off)), IsEmpty()) << off;
  }
}

double defect(const SO3<>& R) { return distance(transpose(R) * R, SO3<>{}); }

TEST(Faults, ANearlyRotationIsMadeOne) {
  for (const Place& place : places_of_rotations()) {
    const Model model = ModelBuilder(with([&](auto& d) { place.set(d, distorted(1e-8)); })).build();
    const Model exact = ModelBuilder(with([&](auto& d) { place.set(d, distorted(0)); })).build();
    for (int i = 1; i <= model.n_bodies(); ++i) {
      const Body& body = model.body(i);
      for (const SE3<>& C : {body.A, body.B, body.S_prev, body.S_self})
        EXPECT_LE(defect(C.R), 2e-15) << place.thing;
      EXPECT_LE(distance(body.A, exact.body(i).A), 2e-8);
      EXPECT_LE(distance(body.M, exact.body(i).M), 1e-8);
      EXPECT_NEAR(trace(body.M.Theta), trace(exact.body(i).M.Theta), 1e-15) << place.thing;
    }
    for (const Frame& frame : model.frames()) EXPECT_LE(defect(frame.pose.R), 2e-15) << place.thing;
  }
}

// ------------------------------------------------------------------------------------------------ the report

TEST(Faults, AllOfThemComeInOneError) {
  const Description wrong{
      .name = "scrap",
      .gravity = {0, 0, nan},
      .bodies = {{.name = "a", .predecessor = "b"},
                 {.name = "b",
                  .predecessor = "a",
                  .joint = {.name = "j", .kind = JointKind::revolute, .axis = {}}},
                 {.name = "c", .predecessor = "d", .inertia = MassProperties{.mass = -3}},
                 {.name = "c", .predecessor = "ground"},
                 {.name = "ground", .joint = {.name = "j", .pitch = 1}},
                 {.name = "e",
                  .joint = {.kind = JointKind::revolute,
                            .dof = {{.lower = 1, .upper = 0}},
                            .coupling = Coupling{"k"}}},
                 {.name = "f", .geometry = InBodyFrame{{SO3<>{{2, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}}}}},
      .frames = {{.name = "", .body = "z"}}};
  const std::vector<Fault> found = faults(wrong);
  std::vector<Rule> rules;
  for (const Fault& fault : found) rules.push_back(fault.rule);
  EXPECT_THAT(rules,
              UnorderedElementsAre(Rule::non_finite_number, Rule::cycle, Rule::zero_axis,
                                   Rule::unknown_predecessor, Rule::mass_not_positive, Rule::two_predecessors,
                                   Rule::duplicate_name, Rule::duplicate_name, Rule::pitch_without_helix,
                                   Rule::limits_crossed, Rule::coupling_unknown_joint, Rule::not_a_rotation,
                                   Rule::missing_name, Rule::unknown_frame_body));
  try {
    ModelBuilder(wrong).build();
    FAIL() << "built";
  } catch (const ModelError& error) {
    EXPECT_THAT(error.what(), StartsWith("model \"scrap\" has 14 faults:\n  "));
    for (const Fault& fault : found) EXPECT_THAT(error.what(), HasSubstr("\n  " + to_string(fault)));
  }
}

TEST(Faults, LimitsThatLookLikeDegreesAreDoubted) {
  const auto joint = [](JointKind kind, std::vector<Dof> dof) {
    return with_joint([&](JointDescription& j) { j.kind = kind, j.dof = std::move(dof); });
  };
  const Dof quarter{.lower = -90, .upper = 90};
  const char* message =
      "limits are -90 and 90 rad, which look like degrees; as degrees they would be -1.5707963267948966 and "
      "1.5707963267948966 rad";
  for (const auto& [kind, dof] :
       std::vector<std::pair<JointKind, std::vector<Dof>>>{{JointKind::revolute, {quarter}},
                                                           {JointKind::helical, {quarter}},
                                                           {JointKind::universal, {{}, quarter}},
                                                           {JointKind::cylindrical, {quarter, {}}},
                                                           {JointKind::planar, {quarter, {}, {}}}}) {
    SCOPED_TRACE(to_string(kind));
    EXPECT_THAT(ModelBuilder(joint(kind, dof)).check(),
                ElementsAre(says(Rule::wrong_value, "joint \"elbow\"", message, Severity::warning)));
    EXPECT_THAT(faults(joint(kind, dof), Strictness::lenient), IsEmpty());
    EXPECT_THAT(faults(joint(kind, dof)), ElementsAre(says(Rule::wrong_value, "joint \"elbow\"", message)));
  }
  EXPECT_THAT(faults(joint(JointKind::revolute, {{.upper = 170}})),
              ElementsAre(says(Rule::wrong_value, "joint \"elbow\"", HasSubstr("limits are -inf and 170"))));
  EXPECT_THAT(faults(joint(JointKind::prismatic, {quarter})), IsEmpty());
  EXPECT_THAT(faults(joint(JointKind::cylindrical, {{}, quarter})), IsEmpty());
  EXPECT_THAT(faults(joint(JointKind::planar, {{}, quarter, quarter})), IsEmpty());
}

TEST(Faults, ASingleOneIsOneSentence) {
  try {
    ModelBuilder(with_body([](auto& b) { b.inertia->mass = -1; })).build();
    FAIL() << "built";
  } catch (const ModelError& error) {
    EXPECT_STREQ(error.what(), "error: body \"fore\": mass is -1 kg; a mass must be positive");
  }
}

TEST(Faults, WhatNamesTheErrorsAndFaultsHasTheWarningsToo) {
  const Description description = with([](auto& d) {
    d.warnings = {{Severity::warning, Rule::unknown_element, "line 3", "is strange", {}}};
    d.bodies[1].inertia->mass = -1;
  });
  try {
    ModelBuilder(description).build();
    FAIL() << "built";
  } catch (const ModelError& error) {
    EXPECT_STREQ(error.what(), "error: body \"fore\": mass is -1 kg; a mass must be positive");
    EXPECT_EQ(error.faults().size(), 2u);
  }
  Description doubtful = two_bodies();
  doubtful.warnings = description.warnings;
  EXPECT_EQ(ModelBuilder(doubtful).build().warnings().size(), 1u) << "warnings of a reader stay on the model";
}

TEST(Faults, CheckFindsWhatBuildThrows) {
  const Description wrong = with([](auto& d) {
    d.bodies[0].inertia->mass = 0;
    d.bodies[1].joint.axis = {};
  });
  for (const Strictness strictness : {Strictness::strict, Strictness::lenient}) {
    const std::vector<Fault> thrown = faults(wrong, strictness),
                             checked = ModelBuilder(wrong).check(strictness);
    ASSERT_EQ(thrown.size(), checked.size());
    for (std::size_t k = 0; k < thrown.size(); ++k) EXPECT_EQ(to_string(thrown[k]), to_string(checked[k]));
  }
}

TEST(Faults, ComeWithTheLineOfTheirElement) {
  Description file = two_bodies();
  file.source = {"arm.toml", 0};
  file.bodies[0].source = {"arm.toml", 7};
  file.bodies[1].source = {"arm.toml", 12};
  file.bodies[1].joint.source = {"arm.toml", 15};
  file.frames[0].source = {"arm.toml", 21};
  file.gravity.x = nan;
  file.bodies[0].joint.axis = {};
  file.bodies[1].inertia->mass = -1;
  file.bodies[1].joint.dof.resize(3);
  file.frames[0].body = "nobody";
  std::vector<std::string> lines;
  for (const Fault& fault : faults(file))
    lines.push_back(to_string(fault).substr(0, to_string(fault).find(": ")));
  EXPECT_THAT(lines,
              UnorderedElementsAre("arm.toml", "arm.toml:7", "arm.toml:15", "arm.toml:12", "arm.toml:21"));
}

TEST(Faults, EveryRuleHasANameOfItsOwn) {
  std::vector<std::string_view> names;
  for (int k = 0; k <= static_cast<int>(Rule::wrong_value); ++k) {
    const std::string_view name = to_string(static_cast<Rule>(k));
    EXPECT_NE(name, "unknown");
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 0) << name;
    names.push_back(name);
  }
}

// ------------------------------------------------------------------------------------- loops told in code

Description with_loop(const LoopDescription& loop) {
  return with([&](Description& d) { d.loops.push_back(loop); });
}
Description with_terms(const std::vector<std::pair<std::string, double>>& terms, double offset = 0) {
  return with([&](Description& d) { d.couplings.push_back({.terms = terms, .offset = offset}); });
}

TEST(Faults, NumbersOfLoopsAreFiniteAndPosesAreOnes) {
  const std::array between{std::string("fore"), std::string("ground")};
  EXPECT_THAT(faults(with_loop({.between = between})), IsEmpty());
  for (const LoopDescription& loop :
       {LoopDescription{.between = between, .point = {0, nan, 0}},
        LoopDescription{.between = between, .kind = LoopKind::helical, .pitch = infinity},
        LoopDescription{
            .between = between, .kind = LoopKind::rod, .points = {Vec3<>{}, {1, 0, 0}}, .length = nan}})
    EXPECT_THAT(faults(with_loop(loop)),
                ElementsAre(says(Rule::non_finite_number, "loop \"loop 1\"", "a number is not finite")));
  const SE3<> mirror{{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}};
  EXPECT_THAT(faults(with_loop({.between = between, .frames = {{SE3<>{}, mirror}}})),
              ElementsAre(says(Rule::not_a_rotation, "loop \"loop 1\"",
                               "the second frame mirrors; a rotation has determinant +1")));
}

TEST(Faults, PitchesAreNotForEveryLoop) {
  EXPECT_THAT(
      faults(with_loop({.between = {"fore", "ground"}, .pitch = 0.1})),
      ElementsAre(says(Rule::pitch_without_helix, "loop \"loop 1\"",
                       "has a pitch of 0.1 m/rad but is revolute; only helical joints have a pitch")));
}

TEST(Faults, ACouplingNamesEachOfItsJointsOnce) {
  EXPECT_THAT(faults(with_terms({{"shoulder", 1}, {"elbow", -2}})), IsEmpty());
  EXPECT_THAT(faults(with_terms({{"shoulder", 1}, {"shoulder", -1}})),
              ElementsAre(says(Rule::duplicate_element, "coupling \"coupling 1\"",
                               "has two terms of joint \"shoulder\"; add up their factors")));
  EXPECT_THAT(
      faults(with_terms({{"shoulder", nan}}, infinity)),
      ElementsAre(says(Rule::non_finite_number, "coupling \"coupling 1\"", "its offset is not finite"),
                  says(Rule::non_finite_number, "coupling \"coupling 1\"",
                       "the factor of joint \"shoulder\" is nan; it must be a number other than 0")));
}

}  // namespace
}  // namespace test
}  // namespace axode
