#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/comparison.hpp"
#include "tests/support/dense.hpp"
#include "tests/support/smallest_failure.hpp"
#include "tests/support/trial.hpp"

/// Laws are tested for every representation and scalar type, on random mechanisms with fixed seeds; a failure
/// prints its seed. The code of a law is compiled once, because it works on the numbers that a Subject
/// returns.
///
/// Half of the mechanisms have springs. Functions leave these out if their rows in the table say so, and laws
/// about such functions hold with springs as without them. Where functions count loops, loops.cpp,
/// counts.cpp, invariance.cpp and forward_dynamics.cpp have laws about closed mechanisms; other laws are
/// about trees.
namespace axode::test {

/// The base class of laws for several ways to compute. `class Balances : public Law {};` makes a suite, and
/// `INSTANTIATE_TEST_SUITE_P(Laws, Balances, testing::ValuesIn(cases()), name_of);` gives it its cases. Each
/// TEST_P(Balances, ...) is a law.
using Law = testing::TestWithParam<Case>;

/// The recipe with the mechanism of a seed at another place or of another size: of every eight seeds two are
/// as the recipe says, two are far from the origin, two a thousand times smaller, and two a thousand times
/// larger.
inline TreeRecipe elsewhere(std::uint64_t seed, TreeRecipe recipe = {}) {
  switch (seed / 2 % 4) {
    case 1: recipe.far = 30; break;
    case 2: recipe.scale = 1e-3; break;
    case 3: recipe.scale = 1e3; break;
    default: break;
  }
  return recipe;
}

/// An estimate of those terms of the forces that cancel each other in the spatial representation because the
/// mechanism is far from the origin: inertia, weight and loads at that distance. It is 0 for mechanisms at
/// the origin.
inline double terms_far_away(const Trial& trial, double far) {
  double mass = 0, loads = 0;
  for (const AppliedWrench<>& W : trial.state.wrenches) loads += norm(W.m) + far * norm(W.f);
  for (const Body& body : trial.model.bodies()) mass += body.M.m;
  const double weight = far * mass * norm(trial.model.gravity());
  const double rates = std::pow(largest(trial.state.v), 2) + largest(trial.state.a);
  return far > 0 ? loads + weight + far * far * mass * rates : 0;
}

/// Expects that two inverses of M agree to the accuracy that the condition of M allows. If that is worse than
/// a tenth, only expects that both are finite.
template <class Numbers>
void expect_same_inverse(const Numbers& one, const Numbers& other, const Numbers& M, double agreement) {
  const auto largest = [](const Numbers& matrix) {
    double x = 0;
    for (const auto entry : matrix) x = std::max(x, std::abs(static_cast<double>(entry)));
    return x;
  };
  const double scale = largest(other),
               tolerance = agreement * scale * std::max(1.0, scale * largest(M) * 1e-2);
  for (std::size_t k = 0; k < other.size(); ++k) {
    EXPECT_TRUE(std::isfinite(one[k]) && std::isfinite(other[k]));
    if (tolerance < 0.1 * scale) {
      EXPECT_NEAR(one[k], other[k], tolerance);
    }
  }
}

}  // namespace axode::test
