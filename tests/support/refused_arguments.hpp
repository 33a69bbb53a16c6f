#pragma once
#include <gmock/gmock.h>

#include <functional>
#include <stdexcept>
#include <string>

#include "axode/model.hpp"

/// What the library says of arguments that it refuses.
namespace axode::test {

/// What f() throws, or that it does not.
template <class F> std::string message_of(const F& f) {
  try {
    f();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

/// How a call is refused.
using Refusal = testing::Matcher<const std::function<void()>&>;

/// The message names the argument, the size it has and the size it should have.
inline Refusal refused(const std::string& argument, int actual, const std::string& meaning, int expected) {
  return testing::ThrowsMessage<std::invalid_argument>(
      testing::AllOf(testing::StartsWith(argument + " has " + std::to_string(actual) + " entries"),
                     testing::EndsWith("expected " + meaning + " = " + std::to_string(expected))));
}
/// The message names the sizes of the workspace and of the model.
inline Refusal refused_workspace(int made_for, int n_bodies) {
  return testing::ThrowsMessage<std::invalid_argument>(
      testing::AllOf(testing::HasSubstr("workspace: made for " + std::to_string(made_for)),
                     testing::HasSubstr("has " + std::to_string(n_bodies))));
}
/// The message names the argument, the joint and the rule.
inline Refusal refused_quaternion(const std::string& joint) {
  return testing::ThrowsMessage<std::invalid_argument>(
      testing::AllOf(testing::StartsWith("q: "), testing::HasSubstr('"' + joint + '"'),
                     testing::HasSubstr("must be 1 to 1e-0")));
}

/// A ball joint with a hinge behind it: nq = 5, nv = 4, three frames.
inline Model shoulder() {
  const auto inertia = [](double x) {
    return MassProperties{.mass = 1, .com = {x, 0, 0}, .Theta = {1, 1, 1, 0, 0, 0}};
  };
  return ModelBuilder("shoulder")
      .add({.name = "upper arm",
            .joint = {.name = "ball", .kind = JointKind::spherical},
            .inertia = inertia(0.1)})
      .add({.name = "forearm",
            .predecessor = "upper arm",
            .joint = {.name = "elbow", .kind = JointKind::revolute, .point = {0.3, 0, 0}},
            .inertia = inertia(0.4)})
      .build();
}

/// A model of one hinge, for which a workspace is too small for any other.
inline Model one_body() {
  return ModelBuilder("door").add({.name = "leaf", .joint = {.kind = JointKind::revolute}}).build();
}

}  // namespace axode::test
