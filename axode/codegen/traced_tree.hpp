#pragma once
#include "axode/model/tree.hpp"

namespace axode::codegen {

/// The tree that is traced: it moves by the same forces, but more of its constants are 0 or 1. Results differ
/// from those of the model's own tree by rounding.
///
/// Entries of rotations, vectors and tensors that are rounding noise, 1e-15 of the largest entry beside them,
/// are 0 (or +-1 in a rotation). Inertia of a body that its joint cannot turn, or that is the same however the
/// joint turns it, is moved to the predecessor, and on the ground to nothing: of a hinge what is symmetric
/// about its axis, of a prismatic joint the whole of Θ, of a spherical joint a mass in its centre. What
/// is left are, for hinges, the minimal inertial parameters that identification knows.
///
/// For kernels that read Tree::B and Tree::M; the copies of these for sweeps over several bodies are empty.
Tree<double> traced_tree(const Tree<double>& tree);

}  // namespace axode::codegen
