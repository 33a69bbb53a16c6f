#pragma once
#include "axode/model/tree.hpp"

namespace axode::codegen {

/// An equivalent tree of bodies from which shorter code is generated: it has the dynamics of the given tree,
/// but more of its constants are 0 or 1. Results differ from those of the given tree by rounding.
///
/// Entries of rotations, vectors and tensors that are only rounding errors, 1e-15 of the size of the rotation
/// column, vector or tensor, are set to 0 (or to ±1 in a rotation). The part of a body's inertia whose effect
/// on the predecessor does not depend on the joint coordinate is moved to the predecessor, or dropped if the
/// predecessor is the ground: for a hinge the part that is symmetric about its axis, for a prismatic joint
/// the whole of the rotational inertia, for a spherical joint the mass as a point mass in its centre.
///
/// Callers may read the constants Tree::B and Tree::M of the bodies from this tree, and no other ones.
Tree<double> traced_tree(const Tree<double>& tree);

}  // namespace axode::codegen
