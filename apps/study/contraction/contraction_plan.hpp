#pragma once
#include <limits>
#include <vector>

#include "axode/model/tree.hpp"

namespace axode::command {

/// The order in which a tree is contracted to the ground. A node is a body or a chain of bodies, named by its
/// first body. A step joins a node with the node above it, by elimination of the joint between them. There
/// are two kinds of steps: a rake joins a node without children, and a compression joins two nodes with one
/// child each. Steps that do not name the same nodes can be made at the same time, in one round; the number
/// of rounds grows with log n. See Miller and Reif, Parallel tree contraction and its application, FOCS 1985.
struct ContractionPlan {
  struct Step {
    int upper, lower;  ///< first bodies; upper is 0 for the ground
    bool upper_single,
        lower_single;  ///< whether the node is one body, with all nodes that were raked into it
    bool rake;         ///< whether the lower node has no children
  };
  std::vector<Step> steps;
  std::vector<double> least_pivot;  ///< n_screws: a segment may be singular if a pivot is not larger
  int rounds = 0, compressions = 0;

  /// Plans the contraction of a tree without coupled joints. Nodes are bodies or chains of bodies. In each
  /// round, every node without children is joined to the node above it. In the first `most_rounds` rounds a
  /// node with one child can also be joined to the node above it, if that has one child as well; with 0
  /// rounds the plan is the articulated-body algorithm. If the inertia of a node with one child does not
  /// determine the accelerations of the joint above it, for example because a body is massless, the node is
  /// joined to the one above it only after others have been joined to it.
  explicit ContractionPlan(const Tree<double>& tree, int most_rounds = std::numeric_limits<int>::max());
};

}  // namespace axode::command
