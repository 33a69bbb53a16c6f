#pragma once
#include "tests/support/random_tree.hpp"

/// Random mechanisms with loops of all kinds that are closed at a state which is known.
namespace axode::test {

/// A mechanism with loops and a motion that keeps them closed: r(q) = 0, A v = 0 and A a + γ = 0.
struct ClosedMechanism {
  Description description;  ///< of the mechanism, which names its redundant loops "... again"
  Model model;
  State<double> state;
  std::vector<double> tau;  ///< drive forces that make state.a under state.wrenches; 0 at passive joints
};

/// The tree with loops between its frames that are closed at q: each kind of LoopKind with an even chance, as far as
/// the tree keeps a velocity to spare, and then some of them again, with rows that the first ones imply, and some joints
/// of the tree restated as loops, whose rows are all 0. Every loop joint stands at random coordinates of its own. Some
/// joints become passive. Lengths are of the order of `length`.
Description with_closed_loops(Description tree, const std::vector<double>& q, double length,
                              Random<double>& random);

/// Draws a tree in which every body has a mass, loops on it, and a motion of it. The rows of the loops are clearly
/// independent or clearly not, and leave the mechanism a velocity at least.
ClosedMechanism closed_mechanism(Random<double>& random, TreeRecipe recipe = {.most_bodies = 12});

}  // namespace axode::test
