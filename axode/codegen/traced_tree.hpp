#pragma once
#include "axode/model/tree.hpp"

namespace axode::codegen {

/// The tree that is traced: it moves by the same forces, and more of its constants are 0 or 1. Kernels that
/// read Tree::M alone see no other inertias; results differ from those of the model's own tree by rounding.
///
/// Entries of rotations, vectors and tensors that are rounding noise, 1e-15 of the largest entry beside them,
/// are 0 (or, in a rotation, +-1). And inertia that the joint of its body does not turn, or cannot turn
/// because it has no orientation, is moved to the predecessor (Gautier and Khalil 1990), on the ground to
/// nothing: of a hinge, what is symmetric about its axis; of a prismatic joint, the whole of Θ; of a spherical
/// joint, a mass in its centre.
Tree<double> traced_tree(const Tree<double>& tree);

}  // namespace axode::codegen
