#pragma once
#include "axode/model/tree.hpp"

namespace axode::codegen {

/// Returns a tree of bodies with the dynamics of the given tree, but with more constants that are 0 or 1, so
/// that shorter code can be generated from it. Its results differ from those of the given tree by rounding.
///
/// Two changes are made. Entries of rotations, vectors and tensors that are only rounding errors (1e-15 of
/// the size of the column of a rotation, of the vector or of the tensor) become 0, or ±1 in a rotation. And
/// the part of a body's inertia whose effect on the predecessor does not depend on the joint coordinate is
/// moved to the predecessor, or dropped if the predecessor is the ground. For a hinge this is the part that
/// is symmetric about its axis, for a prismatic joint the whole rotational inertia, and for a spherical joint
/// the mass as a point mass in its centre.
///
/// Callers may use only the constant poses B and the inertias M of the bodies of the result.
Tree<double> traced_tree(const Tree<double>& tree);

}  // namespace axode::codegen
