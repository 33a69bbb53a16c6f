#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <ostream>
#include <sstream>

#include "tests/model/random_mechanism.hpp"

/// Every rule that the builder checks: which fault it reports, for which element, and in which words.
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

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A description of two bodies in a row that has no fault.
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
/// The description after a change.
Description with(const std::function<void(Description&)>& change) {
  Description description = two_bodies();
  change(description);
  return description;
}

/// The faults of the ModelError that build() throws; none if it throws no error.
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

// ------------------------------------------------------------------------------------
// the table of faults

/// The kind that has this name.
template <class Kinds> auto kind_of(const std::string& name, const Kinds& kinds) {
  return *std::ranges::find_if(kinds, [&](auto kind) { return to_string(kind) == name; });
}

/// Makes one change that tests/data/faults.tsv names, e.g. `fore.mass` to
/// `-1.25`. The owner is the body upper or fore, its joint shoulder or elbow,
/// the body or joint that was added last (new), the frame hand, or a loop or a
/// spring between fore and the ground.
void change(Description& d, const std::string& key, const std::string& text) {
  const std::size_t dot = key.find('.');
  const std::string owner = key.substr(0, dot), member = dot == key.npos ? "" : key.substr(dot + 1);
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; stream >> word;) words.push_back(word);
  const auto x = [&](std::size_t k) { return std::strtod(words.at(k).c_str(), nullptr); };
  const auto vector = [&] { return Vec3<>{x(0), x(1), x(2)}; };
  BodyDescription& body = owner == "new"                            ? d.bodies.back()
                          : owner == "upper" || owner == "shoulder" ? d.bodies[0]
                                                                    : d.bodies[1];
  JointDescription& joint = body.joint;
  const bool of_loop = owner == "loop";
  if (of_loop && d.loops.empty())
    d.loops.push_back({.between = {"fore", "ground"}, .points = {Vec3<>{}, {1, 0, 0}}});
  if (owner == "term" && d.couplings.empty()) d.couplings.emplace_back();
  if (owner == "spring" && d.springs.empty())
    d.springs.push_back({.between = {"fore", "ground"}, .stiffness = 1});
  const auto number_of_dof = [&](double Dof::*which) {
    return [&, which] {
      const std::size_t k = words.size() > 1 ? static_cast<std::size_t>(x(1)) : 0;
      joint.dof.resize(std::max(joint.dof.size(), k + 1));
      joint.dof[k].*which = x(0);
    };
  };
  const std::map<std::string, std::function<void()>> members{
      {"name",
       [&] {
         (owner == "hand"                           ? d.frames[0].name
          : owner == "shoulder" || owner == "elbow" ? joint.name
                                                    : body.name) = text;
       }},
      {"on", [&] { (owner == "hand" ? d.frames[0].body : body.predecessor) = text; }},
      {"mass", [&] { (body.inertia ? *body.inertia : body.inertia.emplace()).mass = x(0); }},
      {"com", [&] { body.inertia->com = vector(); }},
      {"Theta", [&] { body.inertia->Theta = {x(0), x(1), x(2), x(3), x(4), x(5)}; }},
      {"axes", [&] { body.inertia->axes = exp_SO3(vector()); }},
      {"about", [&] { body.inertia->about = InertiaAbout::frame_origin; }},
      {"inertia", [&] { body.inertia.reset(); }},
      {"mesh", [&] { body.shapes = {{.kind = ShapeKind::mesh, .file = "fore.stl", .scale = vector()}}; }},
      {"kind",
       [&] {
         if (of_loop)
           d.loops[0].kind = std::ranges::find(loop_kinds, text, &LoopTraits::name)->kind;
         else
           joint.kind = kind_of(text, all_kinds);
       }},
      {"axis", [&] { joint.axis = vector(); }},
      {"second_axis", [&] { joint.second_axis = vector(); }},
      {"point", [&] { (of_loop ? d.loops[0].point : joint.point) = vector(); }},
      {"pitch", [&] { (of_loop ? d.loops[0].pitch : joint.pitch) = x(0); }},
      {"length", [&] { d.loops[0].length = x(0); }},
      {"follows",
       [&] {
         joint.coupling = Coupling{words.at(0), x(1), x(2)};
       }},
      {"dof", [&] { joint.dof.resize(static_cast<std::size_t>(x(0))); }},
      {"lower", number_of_dof(&Dof::lower)},
      {"upper", number_of_dof(&Dof::upper)},
      {"velocity", number_of_dof(&Dof::velocity)},
      {"effort", number_of_dof(&Dof::effort)},
      {"damping", number_of_dof(&Dof::damping)},
      {"friction", number_of_dof(&Dof::friction)},
      {"armature", number_of_dof(&Dof::armature)},
      {"stiffness", number_of_dof(&Dof::stiffness)},
      {"rest", number_of_dof(&Dof::rest)},
      {"stop_stiffness", number_of_dof(&Dof::stop_stiffness)},
      {"stop_damping", number_of_dof(&Dof::stop_damping)},
  };
  const std::map<std::string, std::function<void()>> others{
      {"gravity", [&] { d.gravity = vector(); }},
      {"new body", [&] { d.bodies.push_back({.name = words.at(0), .predecessor = words.at(2)}); }},
      {"new frame", [&] { d.frames.push_back({.name = words.at(0), .body = words.at(2)}); }},
      {"term", [&] { d.couplings[0].terms.emplace_back(words.at(0), x(1)); }},
      {"offset", [&] { d.couplings[0].offset = x(0); }},
      {"spring.on", [&] { d.springs[0].between[1] = text; }},
      {"spring.rest", [&] { d.springs[0].rest = x(0); }},
      {"spring.points",
       [&] {
         d.springs[0].points = {vector(), {x(3), x(4), x(5)}};
         d.springs[0].in = GivenIn::construction_frame;
       }},
  };
  others.contains(key) ? others.at(key)() : members.at(member)();
}

/// A text of the table with a number in place of each sign #.
std::string with_number(std::string text, const std::string& number) {
  for (std::size_t at; (at = text.find('#')) != text.npos;) text.replace(at, 1, number);
  return text;
}

/// The description after the changes of a row of the table. The sign # stands for a number.
Description changed(const std::string& changes, const std::string& number) {
  Description description = two_bodies();
  std::istringstream stream(with_number(changes, number));
  for (std::string one; std::getline(stream, one, ';');) {
    const std::size_t sign = one.find('='), begin = one.find_first_not_of(' ');
    change(description, one.substr(begin, one.find_last_not_of(" =", sign) + 1 - begin),
           sign + 2 < one.size() ? one.substr(sign + 2) : "");
  }
  return description;
}

/// The severity, rule, element and message of each fault, as the table writes them.
std::vector<std::string> words_of(std::span<const Fault> faults) {
  std::vector<std::string> words;
  for (const Fault& fault : faults)
    words.push_back(std::string(fault.severity == Severity::error ? "error" : "warning") + '\t' +
                    std::string(to_string(fault.rule)) + '\t' + fault.element + '\t' + fault.message);
  return words;
}

TEST(Faults, AreThoseOfTheTable) {
  struct Case {
    std::string changes;
    std::vector<std::string> strict, lenient;
  };
  std::vector<Case> cases;
  std::ifstream table(AXODE_SOURCE_DIR "/tests/data/faults.tsv");
  std::string line;
  std::getline(table, line);  // the heading
  while (std::getline(table, line)) {
    const std::size_t first = line.find('\t'), second = line.find('\t', first + 1);
    const std::string changes = line.substr(0, first), when = line.substr(first + 1, second - first - 1);
    if (cases.empty() || cases.back().changes != changes) cases.push_back({changes, {}, {}});
    if (when == "strict" || when == "always") cases.back().strict.push_back(line.substr(second + 1));
    if (when == "lenient" || when == "always") cases.back().lenient.push_back(line.substr(second + 1));
  }
  EXPECT_GT(cases.size(), 100u);
  for (const Case& row : cases)
    for (const char* number : {"nan", "inf", "-inf"}) {
      SCOPED_TRACE(row.changes);
      const Description description = changed(row.changes, number);
      for (const Strictness strictness : {Strictness::strict, Strictness::lenient}) {
        const ModelBuilder builder(description);
        std::vector<std::string> expected = strictness == Strictness::strict ? row.strict : row.lenient;
        for (std::string& fault : expected) fault = with_number(fault, number);
        EXPECT_EQ(words_of(builder.check(strictness)), expected);
        try {
          EXPECT_EQ(words_of(builder.build(strictness).warnings()), expected);
          for (const std::string& fault : expected) EXPECT_THAT(fault, StartsWith("warning"));
        } catch (const ModelError& error) {
          EXPECT_EQ(words_of(error.faults()), expected);
          EXPECT_THAT(expected, testing::Contains(StartsWith("error")));
        }
      }
    }
}

// -----------------------------------------------------------------------------------------
// names and the tree

TEST(Faults, BodiesWithoutNamesDoNotClash) {
  EXPECT_THAT(faults({.bodies = {{.name = ""}, {.name = ""}, {.name = "", .predecessor = ""}}}),
              ElementsAre(says(Rule::missing_name, "body \"\"", testing::_),
                          says(Rule::missing_name, "body \"\"", testing::_),
                          says(Rule::missing_name, "body \"\"", testing::_)));
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
  const std::string rest =
      " bodies are fixed to the ground; a free base needs "
      "exactly one to set free";
  EXPECT_EQ(count(two_bodies()), "0" + rest);
  EXPECT_EQ(count(with([](auto& d) {
              d.bodies.push_back({.name = "left foot"});
              d.bodies.push_back({.name = "right foot"});
            })),
            "2" + rest);
  EXPECT_EQ(count(with([](auto& d) { d.bodies.push_back({.name = "foot"}); })), "");
}

// ----------------------------------------------------------------------------
// degrees of freedom, numbers and rotations

TEST(Faults, DegreesOfFreedomAreDescribedAllOrNot) {
  const std::vector<std::pair<JointKind, int>> kinds{
      {JointKind::fixed, 0},     {JointKind::revolute, 1},  {JointKind::prismatic, 1},
      {JointKind::helical, 1},   {JointKind::universal, 2}, {JointKind::cylindrical, 2},
      {JointKind::spherical, 3}, {JointKind::planar, 3},    {JointKind::free, 6}};
  for (const auto& [kind, n] : kinds)
    for (int described = 0; described <= 7; ++described) {
      const std::vector<Fault> found = faults(with([&, kind = kind](auto& d) {
        d.bodies[1].joint.kind = kind;
        d.bodies[1].joint.dof.resize(static_cast<std::size_t>(described));
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

/// A rotation matrix R that is sheared and stretched until RᵀR differs from the identity by `off`.
SO3<> distorted(double off) {
  SO3<> R = exp_SO3(Vec3<>{0.3, -0.4, 0.5});
  R.x += off * R.y;
  R.z = (1 + 0.4 * off) * R.z;
  return R;
}

/// One of the poses in a description: how to set it, and which element and which part of it a fault should
/// name.
struct Place {
  const char* element;
  std::string thing;
  std::function<void(Description&, const SE3<>&)> set;
};
const std::vector<Place>& places() {
  const auto drawn = [](auto geometry) {
    return [=](Description& d, const SE3<>& C) { d.bodies[1].geometry = geometry(C); };
  };
  static const std::vector<Place> all{
      {"body \"fore\"", "A", drawn([](const SE3<>& C) { return InConstructionFrame{C}; })},
      {"body \"fore\"", "B", drawn([](const SE3<>& C) { return InBodyFrame{C}; })},
      {"joint \"elbow\"", "S_prev", drawn([](const SE3<>& C) {
         return InJointFrames{C, {}};
       })},
      {"joint \"elbow\"", "S_self", drawn([](const SE3<>& C) {
         return InJointFrames{{}, C};
       })},
      {"body \"fore\"", "the axes of the inertia",
       [](auto& d, const SE3<>& C) { d.bodies[1].inertia->axes = C.R; }},
      {"body \"fore\"", "the pose of a mesh",
       [](auto& d, const SE3<>& C) {
         d.bodies[1].shapes = {{.kind = ShapeKind::mesh, .pose = C, .file = "fore.stl"}};
       }},
      {"frame \"hand\"", "pose", [](auto& d, const SE3<>& C) { d.frames[0].pose = C; }}};
  return all;
}

TEST(Faults, EveryNumberOfAPoseIsFinite) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const Place& place : places())
    for (int k = 0; k < 8; ++k)
      for (const double x : {nan, infinity, -infinity}) {
        SE3<> C;
        double* const numbers[] = {&C.R.x.x, &C.R.x.y, &C.R.y.y, &C.R.z.z, &C.R.y.z, &C.r.x, &C.r.y, &C.r.z};
        if (k >= 5 && place.thing == "the axes of the inertia") continue;
        *numbers[k] = x;
        EXPECT_THAT(faults(with([&](auto& d) { place.set(d, C); })),
                    ElementsAre(says(Rule::non_finite_number, place.element, place.thing + " is not finite")))
            << x;
      }
}

TEST(Faults, ARotationIsOneToAMillionth) {
  for (const Place& place : places()) {
    const auto found = [&](const SO3<>& R) { return faults(with([&](auto& d) { place.set(d, {R, {}}); })); };
    const std::string thing = place.thing;
    for (const double off : {1.0, 1e-2, 1.1e-6, -1.1e-6})
      EXPECT_THAT(found(distorted(off)),
                  ElementsAre(says(Rule::not_a_rotation, place.element,
                                   AllOf(StartsWith(thing + " is off a rotation by "),
                                         testing::EndsWith("; RᵀR must be the identity to 1e-6")))))
          << off;
    EXPECT_THAT(found(SO3<>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1.25}}),
                ElementsAre(says(Rule::not_a_rotation, place.element,
                                 thing + " is off a rotation by 0.5625; RᵀR "
                                         "must be the identity to 1e-6")));
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
  for (const Place& place : places()) {
    const Model model = ModelBuilder(with([&](auto& d) { place.set(d, {distorted(1e-8), {}}); })).build();
    const Model exact = ModelBuilder(with([&](auto& d) { place.set(d, {distorted(0), {}}); })).build();
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

TEST(Faults, PosesThatOverflowAreNotFiniteEither) {
  EXPECT_THAT(faults(with([](auto& d) {
                d.bodies[1].geometry = InConstructionFrame{{exp_SO3(Vec3<>{0, 0, 0.7}), {}}};
                d.frames[0].pose.r = {1.7e308, 1.7e308, 0};
                d.frames[0].in = GivenIn::construction_frame;
              })),
              ElementsAre(says(Rule::non_finite_number, "frame \"hand\"",
                               "its numbers are so large that its pose overflows")));
}

TEST(Faults, AFrameOfALoopIsARotation) {
  const SE3<> mirror{{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}};
  EXPECT_THAT(faults(with([&](auto& d) {
                d.loops = {{.between = {"fore", "ground"}, .frames = {{SE3<>{}, mirror}}}};
              })),
              ElementsAre(says(Rule::not_a_rotation, "loop \"loop 1\"",
                               "the second frame mirrors; a rotation has determinant +1")));
}

// ------------------------------------------------------------------------------------------------
// the report

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

}  // namespace
}  // namespace test
}  // namespace axode
