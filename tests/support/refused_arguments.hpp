#pragma once
#include <gmock/gmock.h>

#include <functional>
#include <stdexcept>
#include <string>

#include "axode/model.hpp"

/// Matchers for the messages with which the library refuses arguments.
namespace axode::test {

/// The message of the std::invalid_argument that f() throws, or "no error" if it throws none.
template <class F> std::string message_of(const F& f) {
  try {
    f();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

/// Matches a call that the library refuses.
using Refusal = testing::Matcher<const std::function<void()>&>;

/// Matches a call whose message names the argument, the size that it has and the size that it should have.
inline Refusal refused(const std::string& argument, int actual, const std::string& meaning, int expected) {
  return testing::ThrowsMessage<std::invalid_argument>(
      testing::AllOf(testing::StartsWith(argument + " has " + std::to_string(actual) + " entries"),
                     testing::EndsWith("expected " + meaning + " = " + std::to_string(expected))));
}
/// Matches a call whose message names the sizes of the workspace and of the model.
inline Refusal refused_workspace(int made_for, int n_bodies) {
  return testing::ThrowsMessage<std::invalid_argument>(
      testing::AllOf(testing::HasSubstr("workspace: made for " + std::to_string(made_for)),
                     testing::HasSubstr("has " + std::to_string(n_bodies))));
}
/// Matches a call whose message names the argument, the joint and the rule that the quaternion breaks.
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

/// A model with one hinge. A workspace that is made for it is too small for all models with more bodies.
inline Model one_body() {
  return ModelBuilder("door").add({.name = "leaf", .joint = {.kind = JointKind::revolute}}).build();
}

}  // namespace axode::test
