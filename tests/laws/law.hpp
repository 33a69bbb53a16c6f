#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <concepts>
#include <cstdlib>
#include <string>
#include <vector>

#include "axode/axode.hpp"
#include "tests/support/cases.hpp"
#include "tests/support/comparison.hpp"
#include "tests/support/random_tree.hpp"

/// Laws are tested for every representation and scalar, over random trees with fixed seeds; a failure prints
/// the seed.
namespace axode::test {

/// What two computations of one quantity may differ by, as a part of the largest entry.
template <class T> inline constexpr double agreement = std::same_as<T, double> ? 1e-11 : 1e-3;

/// law(seed) for the seeds 1, 2, ... until one fails. AXODE_RANDOM_TREES overrides how many.
template <class Law> void for_seeds(int count, const Law& law) {
  if (const char* chosen = std::getenv("AXODE_RANDOM_TREES")) count = std::max(1, std::atoi(chosen));
  for (int seed = 1; seed <= count && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    law(static_cast<std::uint64_t>(seed));
  }
}

/// A random tree, a state of it, and the quantities of it that laws speak of.
template <class T> struct Trial {
  Model model;
  State<double> exact;
  State<T> state;
  Workspace<T> workspace;

  Trial(Model built, State<double> at)
      : model(std::move(built)), exact(std::move(at)), state(cast<T>(exact)), workspace(model) {}
  Trial(Model built, Random<double>& random) : Trial(built, random_state(built, random)) {}
  explicit Trial(Random<double> random, const TreeRecipe& recipe = {})
      : Trial(ModelBuilder(told(random_mechanism(random, recipe), random)).build(), random) {}

  std::vector<SE3<T>> poses() {
    std::vector<SE3<T>> C(n_frames());
    axode::poses<T>(model, workspace, state.q, C);
    return C;
  }
  template <class Rep> std::vector<Twist<Rep, T>> twists(const std::vector<T>& v) {
    std::vector<Twist<Rep, T>> V(n_frames());
    axode::twists<Rep>(model, workspace, state.q, v, V);
    return V;
  }
  template <class Rep> std::vector<Twist<Rep, T>> twists() { return twists<Rep>(state.v); }
  template <class Rep> std::vector<TwistRate<Rep, T>> accelerations() {
    std::vector<TwistRate<Rep, T>> dV(n_frames());
    axode::accelerations<Rep>(model, workspace, state.q, state.v, state.a, dV);
    return dV;
  }
  template <class Rep>
  std::vector<T> inverse_dynamics(const std::vector<T>& v, const std::vector<T>& a, const Loads<T>& loads) {
    std::vector<T> tau(static_cast<std::size_t>(model.nv()));
    axode::inverse_dynamics<Rep>(model, workspace, state.q, v, a, tau, loads);
    return tau;
  }
  template <class Rep> std::vector<T> inverse_dynamics() {
    return inverse_dynamics<Rep>(state.v, state.a, state.loads());
  }
  template <class Rep> std::vector<Wrench<Rep, T>> joint_wrenches() {
    std::vector<Wrench<Rep, T>> W(static_cast<std::size_t>(model.n_bodies()));
    axode::joint_wrenches<Rep>(model, workspace, state.q, state.v, state.a, W, state.loads());
    return W;
  }
  std::vector<T> zero() const { return std::vector<T>(static_cast<std::size_t>(model.nv())); }
  std::size_t n_frames() const { return static_cast<std::size_t>(model.n_frames()); }
};

/// Two inverses of M agree as far as the condition of M lets either be known.
template <class T>
void expect_same_inverse(const std::vector<T>& one, const std::vector<T>& other, const std::vector<T>& M) {
  const auto largest = [](const std::vector<T>& matrix) {
    double x = 0;
    for (const T entry : matrix) x = std::max(x, std::abs(static_cast<double>(entry)));
    return x;
  };
  const double scale = largest(other),
               tolerance = agreement<T> * scale * std::max(1.0, scale * largest(M) * 1e-2);
  for (std::size_t k = 0; k < other.size(); ++k) EXPECT_NEAR(one[k], other[k], tolerance);
}

}  // namespace axode::test
