#pragma once
#include "axode/model/tree.hpp"

namespace axode {

/// The elimination tree of the mass matrix, from the last velocity to the first: row c of L in M = LᵀDL has
/// entries in the columns parent(c), parent(parent(c)), ... only, and -1 ends them. Without coupled joints
/// the parent is the velocity that precedes on the path to the ground; a coupled joint ties the paths of its
/// leader and its own.
std::vector<int> velocity_parents(const Tree<double>& tree);

}  // namespace axode
