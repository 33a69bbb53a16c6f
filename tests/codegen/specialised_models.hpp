#pragma once
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "axode/codegen.hpp"
#include "axode/model/building/builder.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/random_states.hpp"
#include "tests/support/run_program.hpp"

/// Helpers of the tests of specialised models.
namespace axode::test {

/// Options that make the compiler quick, for tests that do not depend on the speed of the code.
inline const std::vector<std::string> quickly{"-O0", "-march=native", "-ffp-contract=fast"};

/// Gives an environment variable another value until the end of the scope.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    setenv(name, value.c_str(), 1);
  }
  ~Variable() {
    if (before_)
      setenv(name_, before_->c_str(), 1);
    else
      unsetenv(name_);
  }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};
/// Gives each test a cache of its own.
class SpecialisedModels : public testing::Test {
 protected:
  TemporaryFolder folder;
  Variable cache{"XDG_CACHE_HOME", folder.path()};
  Variable compiler{"CC", "cc"};
};

/// A model with joints of every kind, a free base, a joint that is coupled to one on another branch, and an
/// armature.
inline Model every_joint() {
  const auto joint = [](JointKind kind, Vec3<> axis) {
    JointDescription described{.kind = kind, .axis = axis};
    described.dof.resize(1);
    described.dof[0].armature = 0.1;
    return described;
  };
  ModelBuilder builder("every joint");
  double height = 0;
  const auto add = [&](const char* name, const char* on, JointDescription described) {
    described.point = {0.3, 0.1, height += 0.2};
    builder.add({.name = name,
                 .predecessor = on,
                 .joint = std::move(described),
                 .inertia = MassProperties{
                     .mass = 2, .com = {0.1, 0.05, -0.1}, .Theta = {0.1, 0.2, 0.25, 0.01, 0, 0.02}}});
  };
  add("base", "ground", {.kind = JointKind::free});
  add("hinge", "base", joint(JointKind::revolute, {0.6, 0.8, 0}));
  add("slide", "hinge", joint(JointKind::prismatic, {0, 0.6, 0.8}));
  add("ball", "base", {.kind = JointKind::spherical});
  add("screw", "ball", {.kind = JointKind::helical, .axis = {0, 0, 1}, .pitch = 0.1});
  add("plate", "ground", {.kind = JointKind::planar, .axis = {0, 1, 0}});
  JointDescription follower{.kind = JointKind::revolute, .axis = {1, 0, 0}};
  follower.coupling = Coupling{.leader = "hinge_joint", .ratio = -2, .offset = 0.3};
  add("follower", "base", follower);
  return builder.build();
}

/// Two hinges about one axis, of which the second moves no mass, so that the mass matrix is singular.
inline Model singular_wrist() {
  const JointDescription hinge{.kind = JointKind::revolute, .axis = {0, 0, 1}};
  return ModelBuilder("wrist")
      .add({.name = "a",
            .joint = hinge,
            .inertia = MassProperties{.mass = 1, .com = {1, 0, 0}, .Theta = {1, 1, 1}}})
      .add({.name = "b", .predecessor = "a", .joint = hinge})
      .build();
}

}  // namespace axode::test
