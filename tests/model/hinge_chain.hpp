#pragma once
#include <string>

#include "axode/model.hpp"
#include "tests/lie/random_quantities.hpp"

namespace axode::test {

/// A chain of n hinges. Each axis is the z-axis of the body frame, or a skew axis elsewhere.
inline Model chain(int n) {
  Random<double> random(1);
  ModelBuilder builder("chain");
  for (int i = 0; i < n; ++i) {
    BodyDescription link{.name = "link " + std::to_string(i)};
    if (i > 0) link.predecessor = "link " + std::to_string(i - 1);
    link.joint = {.kind = JointKind::revolute, .axis = random.vector(1)};
    link.geometry = InBodyFrame{{random.rotation(), random.vector(0.3)}};
    link.inertia = MassProperties{.mass = 1, .com = random.vector(0.1), .Theta = {0.02, 0.02, 0.02}};
    builder.add(std::move(link));
  }
  return builder.build();
}

}  // namespace axode::test
