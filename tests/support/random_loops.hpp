#pragma once
#include "tests/support/random_tree.hpp"
#include "tests/support/units.hpp"

/// Random mechanisms at a state: trees, and mechanisms with loops of all kinds at a state that keeps their
/// loops closed.
namespace axode::test {

struct MechanismAtAState {
  Description description;
  Model model;
  State<double> state;
};

/// The same mechanism at the same state, in other units.
MechanismAtAState in_units(const Units& units, const MechanismAtAState& drawn);

/// A random mechanism with the lengths of the recipe, at a random state. The part of them that the recipe
/// names are closed mechanisms, and the others are trees.
MechanismAtAState mechanism_at_a_state(Random<double>& random, TreeRecipe recipe = {});

/// A mechanism with loops and a motion that keeps them closed: r(q) = 0, A v = 0 and A a + γ = 0. The names
/// of its redundant loops end in "again".
struct ClosedMechanism : MechanismAtAState {
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

/// Draws loops on a tree, in which every body must have a mass, and a motion that keeps them closed. Which
/// rows of the loops are independent is clear, far from rounding, and at least one velocity is free. Lengths
/// are of the order of `length`. Empty if the loops that were drawn are not so.
std::optional<ClosedMechanism> closed(const Description& tree, double length, Random<double>& random);

/// Draws trees in which every body has a mass until one of them can be closed().
ClosedMechanism closed_mechanism(Random<double>& random, TreeRecipe recipe = {.most_bodies = 12});

}  // namespace axode::test
