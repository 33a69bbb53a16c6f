#pragma once
#include "tests/support/random_tree.hpp"

/// Random mechanisms with loops of all kinds, each with a known state at which its loops are closed.
namespace axode::test {

/// A mechanism with loops and a motion that keeps them closed: r(q) = 0, A v = 0 and A a + γ = 0.
struct ClosedMechanism {
  Description description;  ///< the names of its redundant loops end in "again"
  Model model;
  State<double> state;
  std::vector<double> tau;  ///< the drive forces under which the accelerations are state.a with the loads
                            ///< state.wrenches; 0 at passive joints
};

/// Adds loops to a tree, between frames of it, that are closed at q. Each kind of LoopKind is added with a
/// probability of one half, as long as the tree keeps at least one velocity. Then some of these loops are
/// added a second time, so that their rows depend on those of the first, and some joints of the tree are
/// restated as loops, the rows of which are 0. Every loop joint is at random coordinates of its own. Some
/// joints become passive. Lengths are of the order of `length`.
Description with_closed_loops(Description tree, const std::vector<double>& q, double length,
                              Random<double>& random);

/// Draws a tree in which every body has a mass, loops on it, and a motion that keeps them closed. Which rows
/// of the loops are independent is clear, far from rounding, and at least one velocity is free.
ClosedMechanism closed_mechanism(Random<double>& random, TreeRecipe recipe = {.most_bodies = 12});

}  // namespace axode::test
