#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "axode/drives/make_law.hpp"
#include "axode/io.hpp"
#include "axode/model/building/edited.hpp"
#include "tests/io/same_mechanism.hpp"

/// Drives in drawings and in mechanisms that are made of others, and where a format has no word for them.
namespace axode::test {
namespace drives {
namespace {

using testing::HasSubstr;

/// A mechanism with a drive of each kind, and inputs of each kind.
Description driven() {
  Description d{.name = "driven"};
  for (const char* name : {"one", "two"})
    d.bodies.push_back({.name = name,
                        .joint = {.name = std::string(name) + "_joint", .kind = JointKind::revolute},
                        .inertia = MassProperties{.mass = 1, .com = {.1, 0, 0}, .Theta = {1, 1, 1}}});
  for (const DriveTraits& kind : drive_kinds) {
    DriveDescription drive{.name = "the " + std::string(kind.name), .kind = kind.kind};
    for (const DriveParameter& parameter : kind.parameters)
      if (!(parameter.standard == 0)) drive.parameters.emplace_back(parameter.name, 0.7);
    if (kind.kind == DriveKind::hydraulic_cylinder) {
      drive.line = {{"ground", "one"}, {Vec3<>{1, 2, 3}, {0.1, 0, 0.2}}, GivenIn::construction_frame};
      drive.input.times = {0, 1.5};
      drive.input.values = {-1, 1};
    } else {
      drive.joints = {{"one_joint", kind.kind == DriveKind::lugre ? 1.0 : 2.0}, {"two_joint", -1.0}};
    }
    if (kind.kind == DriveKind::dc_motor) drive.input.from = "the pid";
    if (kind.kind == DriveKind::pid) drive.input.values = {3};
    if (kind.kind == DriveKind::series_elastic) {
      drive.input.function.emplace().kind = MotionDescription::Kind::harmonic;
      drive.input.function->amplitude = 2, drive.input.function->frequency = 0.5;
      drive.joints = {{"two_joint", 1.0}};
    }
    drive.conditional = kind.kind == DriveKind::pid;
    d.drives.push_back(drive);
    DriveDescription& added = d.drives.back();
    double value = 0.1;
    for (const DriveState& state : make_law(added)->states())
      added.initial.emplace_back(state.name, value += 0.1);
    std::ranges::sort(added.initial);
  }
  return d;
}

TEST(RoundTrip, ADrawingKeepsTheDrives) {
  const Model model = ModelBuilder(driven()).build();
  const std::string text = drawing_of(model);
  const Model again = ModelBuilder(read_drawing_text(text, "again.toml")).build();
  EXPECT_EQ(drawing_of(again), text);
  ASSERT_EQ(again.drives().size(), drive_kinds.size());
  for (std::size_t k = 0; k < again.drives().size(); ++k) {
    const DriveDescription &one = model.drives()[k], &other = again.drives()[k];
    EXPECT_EQ(one.name, other.name);
    EXPECT_EQ(one.kind, other.kind);
    EXPECT_EQ(one.joints, other.joints);
    EXPECT_EQ(one.parameters, other.parameters);
    EXPECT_EQ(one.conditional, other.conditional);
    EXPECT_EQ(one.initial, other.initial);
    EXPECT_EQ(one.input.from, other.input.from);
    EXPECT_EQ(one.input.times, other.input.times);
    EXPECT_EQ(one.input.values, other.input.values);
    EXPECT_EQ(one.input.function.has_value(), other.input.function.has_value());
    EXPECT_EQ(one.line.has_value(), other.line.has_value());
  }
}

TEST(FormatsWithoutDrives, WarnByNameOrRefuseIfStrict) {
  const Model model = ModelBuilder(driven()).build();
  for (const auto write : {write_urdf, write_mjcf}) {
    std::ostringstream text, strict;
    std::string warnings;
    for (const Fault& fault : write(model, text, Strictness::lenient)) warnings += to_string(fault) + '\n';
    EXPECT_THAT(warnings, HasSubstr("drive \"the dc_motor\": is a dc_motor; "));
    EXPECT_THAT(warnings, HasSubstr("drive \"the hydraulic_cylinder\": is a hydraulic_cylinder; "));
    EXPECT_THROW(write(model, strict, Strictness::strict), ModelError);
    EXPECT_TRUE(strict.str().empty());
  }
}

TEST(EditedMechanisms, TakeTheirDrivesWithThem) {
  const Model model = ModelBuilder(driven()).build();
  const Model both = append(model, "one", model, "second/");
  ASSERT_EQ(both.drives().size(), 2 * drive_kinds.size());
  const DriveDescription& motor = both.drives()[drive_kinds.size()];
  EXPECT_EQ(motor.name, "second/the dc_motor");
  EXPECT_EQ(motor.joints[0].first, "second/one_joint");
  EXPECT_EQ(motor.input.from, "second/the pid");
  EXPECT_EQ(both.drives().back().line->between[1], "second/one");
  EXPECT_THAT(
      [&] {
        reduced(model, std::array<std::string_view, 1>{"one_joint"}, {{0.0, 0.0}});
      },
      testing::ThrowsMessage<std::invalid_argument>(
          HasSubstr("cannot be locked: the drive \"the dc_motor\" acts on it")));
}

}  // namespace
}  // namespace drives
}  // namespace axode::test
