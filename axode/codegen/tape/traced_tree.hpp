#pragma once
#include "axode/model/tree.hpp"

namespace axode::codegen {

/// Returns a tree of bodies with the dynamics of the given tree up to rounding, but with more constants that
/// are 0 or ±1, so that shorter code can be generated from it.
///
/// Entries of vectors, tensors and columns of rotations become 0 if their magnitude is at most 1e-15 of the
/// size of the vector, tensor or column; entries of rotations within 1e-15 of ±1 become ±1. And the part of a
/// body's inertia whose effect on the predecessor does not depend on the joint coordinate is moved to the
/// predecessor, or dropped if the predecessor is the ground. For a prismatic joint this part is the whole
/// rotational inertia, and for a spherical joint the mass as a point mass in its centre. For a hinge it has
/// the mass of the body, a centre of mass on the hinge axis, and equal moments of inertia about the two axes
/// perpendicular to it; the moment of inertia about the hinge axis stays with the body.
///
/// The inertias M of the bodies of the result, and their poses B relative to the predecessors at q = 0, are
/// valid. Callers must not use any other data of these bodies.
Tree<double> traced_tree(const Tree<double>& tree);

}  // namespace axode::codegen
